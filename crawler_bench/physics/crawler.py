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
from crawler_bench.physics.compilation import kernel
from crawler_bench.physics.exact import cross_decision
from crawler_bench.physics.layout import DISPLACEMENT, DRIVE, FORCE, NEURON, SLIP, VELOCITY
from crawler_bench.physics.muscle import relax_muscle
from crawler_bench.physics.neuron import NO_SPIKE, step_neuron


@kernel
def act(
    state: NDArray[np.float64], work: NDArray[np.float64], action: int, n_steps: int, k: Coefficients
) -> None:
    """Hold one neuron ON for a decision interval, by the integrator that the parameters name.

    Args:
        state: (6, N + 1), changed in place.
        work: (9, N + 1) scratch.
        action: the neuron that is ON, 0 to N - 1; neuron N (tail) is ON whenever neuron 0 is [M20, eq. 10].
        n_steps: steps of dt in a decision; the exact integrator takes none.
        k: coefficients.
    """
    if not k.exact:
        advance(state, work, action, n_steps, k)
    elif not k.may_balance:
        cross_decision(state, work, action, k)
    else:
        before = state.copy()
        if not cross_decision(state, work, action, k):
            state[:] = before
            advance(state, work, action, n_steps, k)


@kernel
def advance(
    state: NDArray[np.float64], work: NDArray[np.float64], action: int, n_steps: int, k: Coefficients
) -> None:
    """Advance the crawler by n_steps integration steps with one neuron ON.

    Args:
        state: (6, N + 1), changed in place.
        work: (9, N + 1) scratch.
        action: the neuron that is ON, 0 to N - 1; neuron N (tail) is ON whenever neuron 0 is [M20, eq. 10].
        n_steps: number of steps of dt.
        k: coefficients.
    """
    tail = state.shape[1] - 1
    for _ in range(n_steps):
        for i in range(tail + 1):
            on = i == action or (i == tail and action == 0)
            _step_muscle(state, i, on, k)
        net_muscle_force(state[FORCE], work[0], k)
        _step_body(state, work, k)


@kernel
def _step_muscle(state: NDArray[np.float64], i: int, on: bool, k: Coefficients) -> None:
    """Advance neuron and muscle i by dt, exactly, with the spike (if any) at its own time."""
    F, f = state[DRIVE, i], state[FORCE, i]
    state[NEURON, i], spike = step_neuron(
        state[NEURON, i], on, k.dt, k.neuron_rate, k.tan_rate_dt, k.spike_at_pi
    )
    if spike != NO_SPIKE:
        F, f = relax_muscle(F, f, spike, k.tau_m, k.tau_f, k.force_max)
        F, f = relax_muscle(F + k.spike_gain, f, k.dt - spike, k.tau_m, k.tau_f, k.force_max)
    elif F > 1e-100 and F <= 1.0:
        f = f * k.force_decay + F * k.force_gain
        F *= k.drive_decay
    elif F * k.drive_decay > 1.0:
        f = k.force_max + (f - k.force_max) * k.force_decay
        F *= k.drive_decay
    else:
        F, f = relax_muscle(F, f, k.dt, k.tau_m, k.tau_f, k.force_max)
    state[DRIVE, i], state[FORCE, i] = F, f


@kernel
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


@kernel
def _step_body(state: NDArray[np.float64], work: NDArray[np.float64], k: Coefficients) -> None:
    """Implicit Euler step of the body under the net muscle force in work[0]."""
    u, g = state[DISPLACEMENT], work[0]
    for i in range(1, u.size):
        tension = u[i - 1] - u[i]  # of the spring of segment i: it pulls node i forward
        g[i] += tension
        g[i - 1] -= tension
    v = state[VELOCITY]
    balance_forces(g, v, state[SLIP], k.stiffness, k.forward, k.backward, work[1])
    for i in range(u.size):
        u[i] += k.dt * v[i]


@kernel
def strains(u: NDArray[np.float64], strain: NDArray[np.float64]) -> None:
    """Strain of each segment, contraction positive [M20, eq. 9].

    Args:
        u: (N + 1,) displacements, L.
        strain: (N or more,) its first N entries are written; strain[i] = u_{i+1} - u_i.
    """
    for i in range(u.size - 1):
        strain[i] = u[i + 1] - u[i]


@kernel
def strain_gradient(u: NDArray[np.float64]) -> float:
    """Largest change of strain from one segment to the next, r_2 of [M20, eq. 11]."""
    largest = 0.0
    for i in range(1, u.size - 1):
        largest = max(largest, abs(u[i + 1] - 2.0 * u[i] + u[i - 1]))
    return largest


@kernel
def centroid(u: NDArray[np.float64]) -> float:
    """Mean displacement of the nodes, L."""
    total = 0.0
    for i in range(u.size):
        total += u[i]
    return total / u.size
