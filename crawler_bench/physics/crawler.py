"""The coupled crawler: neurons drive muscles, muscles pull the body, friction holds it [M20, eq. 1-8].

Node 0 is the head and + is forward; node i rests at x_i = -i and stands at x_i = -i + u_i, so segment i
(between nodes i - 1 and i) is contracted when u_i - u_{i-1} > 0. Muscle i pulls the two ends of segment i
together; muscle 0 acts on the head alone. Neuron i drives muscle i.

Two integrators share all this: `advance` takes implicit Euler steps, `exact.py` goes from event to event.
"""

import numpy as np
from numpy.typing import NDArray

from crawler_bench.physics.body import balance_forces
from crawler_bench.physics.coefficients import Coefficients
from crawler_bench.physics.compilation import inner_kernel, step_kernel
from crawler_bench.physics.exact import cross_decision
from crawler_bench.physics.layout import DISPLACEMENT, DRIVE, FORCE, NEURON, SLIP, STATE_ROWS, VELOCITY, WORK
from crawler_bench.physics.muscle import (
    any_leaves_limiter,
    leaves_limiter,
    relax_muscle,
    step_quiet_muscle,
    step_quiet_muscles,
)
from crawler_bench.physics.neuron import NO_SPIKE, step_neuron, step_neurons_off
from crawler_bench.physics.sliding import eliminate, factorize, substitute

# Rows of the scratch memory: force on each node, factors of the sliding nodes, time of each neuron's spike.
LOAD, PIVOT, FRICTION, SPIKE = range(4)


@inner_kernel
def act(memory: NDArray[np.float64], action: int, n_steps: int, k: Coefficients) -> None:
    """Hold one neuron ON for a decision interval, by the integrator that the parameters name.

    Args:
        memory: (ROWS, N + 1), changed in place: where the body is then; `course.report` writes the rest.
        action: the neuron that is ON, 0 to N - 1; neuron N (tail) is ON whenever neuron 0 is [M20, eq. 10].
        n_steps: steps of dt in a decision; the exact integrator takes none.
        k: coefficients.
    """
    if k.exact and cross_decision(memory, action, k):
        return
    advance(memory[:STATE_ROWS], memory[WORK:], action, n_steps, k)


@inner_kernel
def advance(
    state: NDArray[np.float64], work: NDArray[np.float64], action: int, n_steps: int, k: Coefficients
) -> None:
    """Advance the crawler by n_steps integration steps with one neuron ON.

    Args:
        state: (6, N + 1), changed in place.
        work: (WORK_ROWS, N + 1) scratch.
        action: the neuron that is ON, 0 to N - 1; neuron N (tail) is ON whenever neuron 0 is [M20, eq. 10].
        n_steps: number of steps of dt.
        k: coefficients.
    """
    V, F, f, spike = state[NEURON], state[DRIVE], state[FORCE], work[SPIKE]
    other = V.size - 1 if action == 0 else action
    # A neuron that is OFF receives nothing, so one Moebius map takes it to the end of the call.
    next_spike = step_neurons_off(V, spike, action, other, n_steps * k.dt, k.neuron_rate, k.spike_at_pi)
    crossing = any_leaves_limiter(F, k.drive_decay)
    factorize(state[SLIP], work[PIVOT], work[FRICTION], k.forward, k.backward)
    for step in range(n_steps):
        start = step * k.dt
        end = start + k.dt if step < n_steps - 1 else np.inf  # rounding must not lose the last spike
        next_spike = min(next_spike, _step_neuron_on(V, spike, action, start, k))
        if other != action:
            next_spike = min(next_spike, _step_neuron_on(V, spike, other, start, k))
        if crossing or next_spike < end:
            next_spike = _step_muscles(F, f, spike, start, end, k)
            crossing = any_leaves_limiter(F, k.drive_decay)
        else:
            crossing = step_quiet_muscles(
                F, f, k.drive_decay, k.force_decay, k.force_gain, k.limited_force_gain
            )
        _step_body(state, work, k)


@inner_kernel
def _step_neuron_on(
    V: NDArray[np.float64], spike: NDArray[np.float64], i: int, start: float, k: Coefficients
) -> float:
    """Advance neuron i, which is ON, by dt; note and return when it spikes, counted from the first step."""
    V[i], delay = step_neuron(V[i], True, k.dt, k.neuron_rate, k.tan_rate_dt, k.spike_at_pi)
    when = np.inf
    if delay != NO_SPIKE:
        when = start + delay
        spike[i] = when
    return when


@step_kernel
def _step_muscles(
    F: NDArray[np.float64],
    f: NDArray[np.float64],
    spike: NDArray[np.float64],
    start: float,
    end: float,
    k: Coefficients,
) -> float:
    """Advance all muscles by dt, with spikes and falls through the limiter at their own times.

    Spikes before `end` are struck off the list; the earliest of the others is returned.
    """
    remaining = np.inf
    for i in range(F.size):
        if spike[i] < end:
            delay = min(max(spike[i] - start, 0.0), k.dt)
            spike[i] = np.inf
            F[i], f[i] = relax_muscle(F[i], f[i], delay, k.tau_m, k.tau_f, k.force_max)
            F[i], f[i] = relax_muscle(F[i] + k.spike_gain, f[i], k.dt - delay, k.tau_m, k.tau_f, k.force_max)
        elif leaves_limiter(F[i], k.drive_decay):
            F[i], f[i] = relax_muscle(F[i], f[i], k.dt, k.tau_m, k.tau_f, k.force_max)
        else:
            F[i], f[i] = step_quiet_muscle(
                F[i], f[i], k.drive_decay, k.force_decay, k.force_gain, k.limited_force_gain
            )
        remaining = min(remaining, spike[i])
    return remaining


@step_kernel
def net_muscle_force(f: NDArray[np.float64], net: NDArray[np.float64], k: Coefficients) -> None:
    """Net muscle force on each node, B f of [M20, eq. 1-3], with the reading of the head muscle.

    Args:
        f: (N + 1,) muscle forces, k L.
        net: (N + 1,) written.
        k: coefficients.
    """
    tail = f.size - 1
    net[0] = k.pull_on_head * f[0] - f[1]
    for j in range(1, tail):
        net[j] = f[j] - f[j + 1]
    net[tail] = f[tail]
    net[1] += k.pull_on_neck * f[0]


@inner_kernel
def _step_body(state: NDArray[np.float64], work: NDArray[np.float64], k: Coefficients) -> None:
    """Implicit Euler step of the body; the factors in work belong to the states of the nodes all the time."""
    u, v, slip, f = state[DISPLACEMENT], state[VELOCITY], state[SLIP], state[FORCE]
    g, pivot, friction = work[LOAD], work[PIVOT], work[FRICTION]
    eliminate(u, f, g, v, pivot, friction, k.pull_on_head, k.pull_on_neck, k.stiffness)
    if not substitute(g, v, pivot, friction, k.stiffness, k.forward, k.backward):
        balance_forces(g, v, slip, k.stiffness, k.forward, k.backward, pivot)
        factorize(slip, pivot, friction, k.forward, k.backward)
    for i in range(u.size):
        if pivot[i] != 0.0:
            u[i] += k.dt * v[i]


@step_kernel
def centroid(u: NDArray[np.float64]) -> float:
    """Mean displacement of the nodes, L; `measure` adds up in the same order."""
    total = 0.0
    for i in range(u.size):
        total += u[i]
    return total / u.size


@inner_kernel
def measure(u: NDArray[np.float64], strain: NDArray[np.float64]) -> tuple[float, float]:
    """Strain of each segment, contraction positive [M20, eq. 9], and what the reward needs, in one pass.

    Args:
        u: (N + 1,) displacements, L.
        strain: (N or more,) its first N entries are written; strain[i] = u_{i+1} - u_i.

    Returns:
        The centroid, L: mean displacement of the nodes; and the largest change of strain from one segment to
        the next, r_2 of [M20, eq. 11].
    """
    total, largest = u[0], 0.0
    before, here = u[0], u[0]
    for i in range(1, u.size):
        following = u[i]
        strain[i - 1] = following - here
        change = abs(following - 2.0 * here + before) if i > 1 else 0.0
        largest = max(largest, change)
        total += following
        before, here = here, following
    return total / u.size, largest
