"""The crawler of [M20, eq. 1-8] written a second time, slowly and straight from the paper.

Nothing here is shared with the package except its parameters. Neurons are followed as angles, drives are
explicit sums over spike times, friction is the printed tanh with a width of 1e-6, and the velocities of the
nodes come from a root finder at every instant. Neurons do not feel the muscles and muscles do not feel the
body, so the three are solved one after the other with adaptive integrators that know no common time step.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import cos, exp, pi

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import OdeSolution, solve_ivp
from scipy.optimize import root

from crawler_bench.physics import CrawlerParameters

Array = NDArray[np.float64]
FRICTION_WIDTH = 1e-6  # epsilon_f [M20, Table S1]


@dataclass(frozen=True)
class Trajectory:
    """What the crawler did, sampled at the start and after each action."""

    times: Array  # (actions + 1,)
    displacements: Array  # (actions + 1, N + 1)
    forces: Array  # (actions + 1, N + 1)
    thetas: Array  # (actions + 1, N + 1)
    spikes: list[list[float]]  # spike times of each neuron


def simulate(p: CrawlerParameters, actions: Sequence[int]) -> Trajectory:
    """Crawl from rest, each action held for one decision interval."""
    times = p.decision_interval * np.arange(len(actions) + 1)
    nodes = range(p.n_segments + 1)
    neurons = [_neuron_through(p, [_is_on(p, i, action) for action in actions]) for i in nodes]
    spikes = [spike_times for _, spike_times in neurons]
    muscles = [_force_history(p, spike_times, times[-1]) for spike_times in spikes]
    corners = sorted({0.0, times[-1], *(t for spike_times in spikes for t in spike_times)})
    displacement = _crawl(p, lambda t: np.array([force(t) for force in muscles]), corners)
    return Trajectory(
        times=times,
        displacements=np.array([displacement(t) for t in times]),
        forces=np.array([[force(t) for force in muscles] for t in times]),
        thetas=np.array([theta for theta, _ in neurons]).T,
        spikes=spikes,
    )


def _is_on(p: CrawlerParameters, neuron: int, action: int) -> bool:
    """Eq. 10, and the tail neuron that is switched on with the head neuron."""
    return neuron == action or (neuron == p.n_segments and action == 0)


def _neuron_through(p: CrawlerParameters, inputs: Sequence[bool]) -> tuple[list[float], list[float]]:
    """Theta at the ends of all intervals, and all spike times, for an input held over each interval."""
    thetas, spikes = [0.0], []
    for interval, on in enumerate(inputs):
        theta, new = follow_theta(thetas[-1], on, p.decision_interval, p.neuron_rate, p.spike_phase)
        thetas.append(theta)
        spikes += [interval * p.decision_interval + t for t in new]
    return thetas, spikes


def follow_theta(
    theta: float, on: bool, duration: float, rate: float, spike_phase: str
) -> tuple[float, list[float]]:
    """Integrate eq. 6 under a constant input; return theta at the end and the spike times of eq. 7.

    Theta is not wrapped. It is integrated from one spike angle to the next, so that a spike is counted once.
    """

    def rhs(_: float, y: Array) -> list[float]:
        return [rate * (1.0 - cos(y[0]) + (1.0 + cos(y[0])) * on)]

    phase = pi if spike_phase == "pi" else 2.0 * pi
    target = phase + 2.0 * pi * np.floor((theta - phase) / (2.0 * pi) + 1.0)
    spikes, t = [], 0.0
    while t < duration:
        to_target = _crossing(target)
        solution = solve_ivp(
            rhs, (t, duration), [theta], method="DOP853", events=to_target, rtol=1e-11, atol=1e-13
        )
        if solution.status == 0:
            return float(solution.y[0, -1]), spikes
        theta, t, target = target, float(solution.t[-1]), target + 2.0 * pi
        spikes.append(t)
    return theta, spikes


def _crossing(target: float) -> Callable[[float, Array], float]:
    def distance(_: float, y: Array) -> float:
        return y[0] - target

    distance.terminal, distance.direction = True, 1.0  # type: ignore[attr-defined]
    return distance


def drive(t: float, spikes: Sequence[float], p: CrawlerParameters) -> float:
    """Eq. 5, the sum over all spikes that have been."""
    return p.spike_gain * sum(exp(-(t - spike) / p.tau_m) for spike in spikes if spike <= t)


def _force_history(p: CrawlerParameters, spikes: Sequence[float], end: float) -> Callable[[float], float]:
    """Eq. 4, solved from each spike to the next, where its right-hand side jumps."""
    corners = sorted({0.0, end, *spikes})
    pieces, force = [], 0.0
    for start, stop in pairwise(corners):
        past = [spike for spike in spikes if spike <= start]

        def rhs(t: float, f: Array, past: list[float] = past) -> Array:
            return (-f + p.muscle_force_max * min(1.0, drive(t, past, p))) / p.tau_f

        # The limiter bends the right-hand side: short steps keep the error control from jumping over it.
        accuracy = {"rtol": 1e-9, "atol": 1e-11, "max_step": 0.1}
        pieces.append(solve_ivp(rhs, (start, stop), [force], dense_output=True, **accuracy).sol)
        force = float(pieces[-1](stop)[0])
    return lambda t: float(_piece_at(t, corners, pieces)(t)[0])


def _crawl(
    p: CrawlerParameters, forces: Callable[[float], Array], corners: Sequence[float]
) -> Callable[[float], Array]:
    """Integrate du/dt from rest, from each spike of any neuron to the next."""
    pieces, u = [], np.zeros(p.n_segments + 1)

    def rhs(t: float, u: Array) -> Array:
        return velocities(u, forces(t), p)

    for start, stop in pairwise(corners):
        pieces.append(solve_ivp(rhs, (start, stop), u, dense_output=True, rtol=1e-8, atol=1e-9).sol)
        u = pieces[-1](stop)
    return lambda t: _piece_at(t, corners, pieces)(t)


def _piece_at(t: float, corners: Sequence[float], pieces: Sequence[OdeSolution]) -> OdeSolution:
    index = int(np.searchsorted(corners, t, side="right")) - 1
    return pieces[min(max(index, 0), len(pieces) - 1)]


def velocities(u: Array, f: Array, p: CrawlerParameters) -> Array:
    """Node velocities at which eq. 1-3 hold with the friction of eq. 8."""
    laplacian = laplacian_of_chain(u.size)
    force = net_force(f, p) - laplacian @ u

    def residual(v: Array) -> Array:
        return force - p.damping * laplacian @ v - friction(v, p)[0]

    def jacobian(v: Array) -> Array:
        return -p.damping * laplacian - np.diag(friction(v, p)[1])

    options = {"xtol": 1e-14, "ftol": 1e-14, "maxiter": 100_000}
    v = root(residual, np.zeros_like(u), jac=jacobian, method="lm", options=options).x
    error = np.max(np.abs(residual(v)))
    assert error < 1e-9, f"the root finder left a force of {error} unbalanced"
    return v


def laplacian_of_chain(n_nodes: int) -> Array:
    """A of the force balance: (A u)_j is the sum of u_j - u_i over the neighbours i of node j."""
    difference = np.diff(np.eye(n_nodes), axis=0)
    return difference.T @ difference


def net_force(f: Array, p: CrawlerParameters) -> Array:
    """Muscle forces of eq. 1-3 on each node, with the reading of what f_0 does."""
    net = np.append(-f[1:], 0.0) + np.append(0.0, f[1:])
    if p.head_muscle != "none":
        net[0] += f[0]
    if p.head_muscle == "reaction":
        net[1] -= f[0]
    return net


def friction(v: Array, p: CrawlerParameters) -> tuple[Array, Array]:
    """Eq. 8 and its derivative; the shift of the tanh makes friction vanish at rest."""
    eta = p.backward_limit / p.forward_limit
    shift = FRICTION_WIDTH * np.arctanh((1.0 - eta) / (1.0 + eta))
    slope = np.tanh((v - shift) / FRICTION_WIDTH)
    force = 0.5 * p.forward_limit * ((1.0 + eta) * slope + (1.0 - eta))
    return force, 0.5 * p.forward_limit * (1.0 + eta) * (1.0 - slope**2) / FRICTION_WIDTH
