"""The crawler of Mishra, van Rees & Mahadevan 2020 [M20, eq. 1-8], as the paper prints it.

Read this file beside the paper: one function per equation, in the paper's order, with the paper's letters.
What the paper leaves open is an argument; docs/differences.md says why it is open. As in the paper, lengths
are in units of the segment length L, times in tau_theta and forces in k L, so L, tau_theta and k are 1 and
do not appear. Node 0 is the head, node N the tail, and + is forward.

Nothing here is compiled, and nothing but the parameters is shared with the fast models. Both integrators,
stepped.py and exact/, are tested against `simulate`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import root

from crawler_bench.physics.parameters import CrawlerParameters

Array = NDArray[np.float64]
FRICTION_WIDTH = 1e-6  # epsilon_f, L / tau_theta [M20, Table S1]
_UNBALANCED = 1e-9  # k L, largest error of a force balance: what a root finder reaches in double precision


def force_inside(u: Array, v: Array, f: Array, c: float, head_muscle: str) -> Array:
    """Eq. 1, left side: spring, damper and muscle force on the nodes 1 to N - 1, k L.

    Args:
        u: (N + 1,) displacements, L.
        v: (N + 1,) velocities du/dt, L / tau_theta.
        f: (N + 1,) muscle forces f^m, k L; muscle i contracts segment i, and muscle 0 pushes the head.
        c: damping, k tau_theta.
        head_muscle: "external" is eq. 1 as printed, without f_0; "reaction" pushes node 1 back with f_0, as
            Pehlevan et al. 2016 do, so internal forces sum to zero; "none" leaves f_0 out of eq. 2 too.
    """
    spring = u[2:] - 2.0 * u[1:-1] + u[:-2]
    damper = c * (v[2:] - 2.0 * v[1:-1] + v[:-2])
    muscle = f[1:-1] - f[2:]
    if head_muscle == "reaction":
        muscle[0] -= f[0]
    return spring + damper + muscle


def force_on_head(u: Array, v: Array, f: Array, c: float, head_muscle: str) -> float:
    """Eq. 2, left side: the same forces on node 0, k L."""
    head_push = 0.0 if head_muscle == "none" else f[0]
    return float(u[1] - u[0] + c * (v[1] - v[0]) + head_push - f[1])


def force_on_tail(u: Array, v: Array, f: Array, c: float) -> float:
    """Eq. 3, left side: the same forces on node N, k L."""
    return float(u[-2] - u[-1] + c * (v[-2] - v[-1]) + f[-1])


def muscle_rate(f: float, F: float, tau_f: float, F_max: float) -> float:
    """Eq. 4: df/dt of one muscle, k L / tau_theta, from its force f and F_max in k L and its drive F."""
    return (-f + F_max * min(1.0, F)) / tau_f


def drive(t: float, spikes: Sequence[float], tau_m: float, gain: float) -> float:
    """Eq. 5: drive F at time t of the muscle whose neuron spiked at these times.

    The paper prints no gain (gain = 1): each spike then adds 1.
    """
    return float(gain * sum(np.exp(-(t - t_s) / tau_m) for t_s in spikes if t_s <= t))


def theta_rate(theta: float, I_i: float, rate: float) -> float:
    """Eq. 6: d theta/dt of one neuron with input I_i, 1 / tau_theta. The paper prints rate = 1."""
    return float(rate * (1.0 - np.cos(theta) + (1.0 + np.cos(theta)) * min(1.0, I_i)))


def next_spike_angle(theta: float, spike_phase: str) -> float:
    """Eq. 7: the next angle above theta at which the neuron spikes.

    Args:
        theta: angle now, not wrapped to one turn.
        spike_phase: "pi" is eq. 7, mod(theta - pi, 2 pi) = 0; "2pi" is its text, "a multiple of 2 pi";
            "every_pi" is both.
    """
    phase = 2.0 * np.pi if spike_phase == "2pi" else np.pi
    turn = spike_turn(spike_phase)
    return float(theta + turn - np.mod(theta - phase, turn))


def spike_turn(spike_phase: str) -> float:
    """Angle from one spike to the next."""
    return np.pi if spike_phase == "every_pi" else 2.0 * np.pi


def friction(
    v: Array, forward: float | Array, backward: float | Array, width: float = FRICTION_WIDTH
) -> Array:
    """Eq. 8: friction f^f on nodes that move at these velocities, k L; positive against forward motion.

    Args:
        v: (N + 1,) velocities, L / tau_theta.
        forward: f_max, the limit against forward motion, k L; one number, or (N + 1,) one per node.
        backward: eta_f f_max, the limit against backward motion, k L; likewise.
        width: epsilon_f, L / tau_theta.
    """
    eta = np.asarray(backward / forward)
    v_0 = width * np.arctanh((1.0 - eta) / (1.0 + eta))  # du^0, "chosen such that f^f(0) = 0"
    return np.asarray(0.5 * forward * ((1.0 + eta) * np.tanh((v - v_0) / width) + (1.0 - eta)))


def neuron_input(i: int, action: int, n_segments: int) -> float:
    """Eq. 10: input I_i of neuron i, 0 or 1; the tail neuron is ON whenever the head neuron is."""
    return float(i == action or (i == n_segments and action == 0))


# Eq. 1-8 together. Neurons do not feel the muscles and muscles do not feel the body, so the three are solved
# one after the other, by adaptive integrators that share no time step.


@dataclass(frozen=True)
class Trajectory:
    """The crawler at the start and after each of n actions."""

    times: Array  # (n + 1,) tau_theta
    displacements: Array  # (n + 1, N + 1) L
    forces: Array  # (n + 1, N + 1) k L
    thetas: Array  # (n + 1, N + 1) not wrapped to one turn
    spikes: list[list[float]]  # spike times of each neuron, tau_theta


def simulate(p: CrawlerParameters, actions: Sequence[int]) -> Trajectory:
    """Crawl from rest, each action held for one decision interval."""
    times = np.asarray(p.decision_interval * np.arange(len(actions) + 1), dtype=np.float64)
    neurons = [follow_neuron(i, p, actions) for i in range(p.n_segments + 1)]
    spikes = [spike_times for _, spike_times in neurons]
    muscles = [follow_muscle(spike_times, p, times[-1]) for spike_times in spikes]
    body = follow_body(muscles, p, sorted({0.0, times[-1], *(t for each in spikes for t in each)}))
    return Trajectory(
        times=times,
        displacements=np.array([body(t) for t in times]),
        forces=np.array([[force(t)[0] for force in muscles] for t in times]),
        thetas=np.array([theta for theta, _ in neurons]).T,
        spikes=spikes,
    )


def follow_neuron(i: int, p: CrawlerParameters, actions: Sequence[int]) -> tuple[list[float], list[float]]:
    """Theta of neuron i at the start and after each action, and all its spike times."""
    thetas, spikes = [0.0], []
    for n, action in enumerate(actions):
        I_i = neuron_input(i, action, p.n_segments)
        theta, new = follow_theta(thetas[-1], I_i, p.decision_interval, p.neuron_rate, p.spike_phase)
        thetas.append(theta)
        spikes += [n * p.decision_interval + t for t in new]
    return thetas, spikes


def follow_theta(
    theta: float, I_i: float, duration: float, rate: float, spike_phase: str
) -> tuple[float, list[float]]:
    """Integrate eq. 6 under a constant input; return theta at the end and the spike times of eq. 7.

    It stops at each spike angle and goes on to the next, so each spike counts once.
    """
    t, spike_angle = 0.0, next_spike_angle(theta, spike_phase)
    spikes: list[float] = []
    while t < duration:

        def to_spike(_: float, y: Array, spike_angle: float = spike_angle) -> float:
            return float(y[0] - spike_angle)

        to_spike.terminal, to_spike.direction = True, 1.0  # type: ignore[attr-defined]
        solution = solve_ivp(
            lambda _, y: [theta_rate(y[0], I_i, rate)], (t, duration), [theta],
            method="DOP853", events=to_spike, rtol=1e-11, atol=1e-13,
        )  # fmt: skip
        if solution.status == 0:
            return float(solution.y[0, -1]), spikes
        theta, t, spike_angle = spike_angle, float(solution.t[-1]), spike_angle + spike_turn(spike_phase)
        spikes.append(t)
    return theta, spikes


def follow_muscle(spikes: Sequence[float], p: CrawlerParameters, end: float) -> Callable[[float], Array]:
    """Integrate eq. 4-5 from rest to `end`; return the force, (1,), as a function of time."""

    def rate(t: float, f: Array, start: float) -> list[float]:
        past = [t_s for t_s in spikes if t_s <= start]  # a spike at the very end belongs to the next piece
        return [muscle_rate(f[0], drive(t, past, p.tau_m, p.spike_gain), p.tau_f, p.muscle_force_max)]

    # The limiter bends the rate: short steps keep the error control from jumping over the bend.
    return _integrate(rate, np.zeros(1), sorted({0.0, end, *spikes}), rtol=1e-9, atol=1e-11, max_step=0.1)


def follow_body(
    muscles: Sequence[Callable[[float], Array]], p: CrawlerParameters, jumps: Sequence[float]
) -> Callable[[float], Array]:
    """Integrate eq. 1-3 and 8 from rest; return the displacements, (N + 1,), as a function of time."""

    def rate(t: float, u: Array, _: float) -> Array:
        f = np.concatenate([force(t) for force in muscles])
        return velocities(u, f, p.damping, p.head_muscle, p.forward_limit, p.backward_limit)

    # Short steps, or the error control jumps over a slide that begins and ends within one.
    return _integrate(rate, np.zeros(p.n_segments + 1), jumps, rtol=1e-8, atol=1e-9, max_step=0.05)


def _integrate(
    rate: Callable[..., Any], y: Array, jumps: Sequence[float], **accuracy: Any
) -> Callable[[float], Array]:
    """Solve dy/dt = rate(t, y, start of the piece), piece by piece between the times where the rate jumps."""
    pieces = []
    for start, stop in pairwise(jumps):
        solution: Any = solve_ivp(rate, (start, stop), y, dense_output=True, args=(start,), **accuracy)
        pieces.append(solution.sol)
        y = solution.y[:, -1]
    return lambda t: pieces[int(np.clip(np.searchsorted(jumps, t, "right") - 1, 0, len(pieces) - 1))](t)


def velocities(
    u: Array, f: Array, c: float, head_muscle: str, forward: float | Array, backward: float | Array
) -> Array:
    """Solve eq. 1-3 with the friction of eq. 8 for the (N + 1,) velocities; arguments as there.

    Raises:
        ArithmeticError: the root finder left forces unbalanced.
    """

    def unbalanced(v: Array) -> Array:
        return force_on_nodes(u, v, f, c, head_muscle) - friction(v, forward, backward)

    def slope(v: Array) -> Array:
        f_f = friction(v, forward, backward)  # whose own slope follows from tanh' = 1 - tanh^2
        tanh_slope = (forward - f_f) * (backward + f_f) / (0.5 * (forward + backward) * FRICTION_WIDTH)
        return np.asarray(-c * laplacian_of_chain(v.size) - np.diag(tanh_slope))

    options: Any = {"xtol": 1e-14, "ftol": 1e-14, "maxiter": 100_000}
    v = np.asarray(root(unbalanced, np.zeros_like(u), jac=slope, method="lm", options=options).x)
    error = float(np.max(np.abs(unbalanced(v))))
    if error > _UNBALANCED:
        raise ArithmeticError(f"the root finder left a force of {error:g} kL unbalanced")
    return v


def force_on_nodes(u: Array, v: Array, f: Array, c: float, head_muscle: str) -> Array:
    """Left sides of eq. 1-3 at all nodes: the (N + 1,) forces that friction balances, k L."""
    head, tail = force_on_head(u, v, f, c, head_muscle), force_on_tail(u, v, f, c)
    return np.concatenate(([head], force_inside(u, v, f, c, head_muscle), [tail]))


def laplacian_of_chain(n_nodes: int) -> Array:
    """A, (n_nodes, n_nodes): springs of eq. 1-3 pull with -A u, dampers with -c A v."""
    difference = np.diff(np.eye(n_nodes), axis=0)
    return np.asarray(difference.T @ difference)
