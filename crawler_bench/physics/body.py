"""The viscoelastic body on dry ground [M20, eq. 1-3 and 8], solved exactly.

One implicit Euler step of the inertialess force balance reads, with A the Laplacian of the chain of nodes,

    (c + dt) A v + friction(v) = g,        g = B f - A u,

where friction is forward_limit on a node with v > 0, -backward_limit on one with v < 0, and whatever holds
the node, between the two, on one with v = 0. Eq. 8's tanh is this law, smoothed over a width of 1e-6.

Which nodes slide is found by an active-set iteration: assume a state of each node, solve the tridiagonal
system of those that slide, correct the states that the solution contradicts. Started from the states of the
step before, this ends after one or two passes. It may, rarely, cycle; then the states are built up from
rest in an order that provably ends, because the matrix is an M-matrix (policy iteration on the equation
max(min(v, r + forward), r - backward) = 0, with r = (c + dt) A v - g).
"""

import numpy as np
from numpy.typing import NDArray

from crawler_bench.physics.compilation import step_kernel

FORWARD, STUCK, BACKWARD = 1.0, 0.0, -1.0
_WARM_PASSES = 8
# With every node sliding, rigid motion meets no resistance and the matrix is singular: with this pivot,
# relative to the diagonal, forces out of balance drive a violent motion, which shows who has to stop.
RIGID_RESISTANCE = 1e-9
_ROUNDING = 1e-13  # relative to the sum of their magnitudes, forces below this balance


@step_kernel
def balance_forces(
    g: NDArray[np.float64],
    v: NDArray[np.float64],
    slip: NDArray[np.float64],
    stiffness: float,
    forward: float,
    backward: float,
    pivot: NDArray[np.float64],
) -> int:
    """Find the velocities at which all forces balance.

    Args:
        g: (N + 1,) force on each node before friction and damping, k L.
        v: (N + 1,) velocity of each node, L / tau_theta; written.
        slip: (N + 1,) FORWARD, STUCK or BACKWARD for each node; the first guess, then the answer.
        stiffness: c + dt, the factor of the Laplacian.
        forward: friction limit against forward sliding, k L.
        backward: friction limit against backward sliding, k L.
        pivot: (N + 1,) scratch.

    Returns:
        The number of tridiagonal solves.
    """
    for solves in range(1, _WARM_PASSES + 1):
        _solve_sliding(g, v, slip, stiffness, forward, backward, pivot)
        if not _correct(g, v, slip, stiffness, forward, backward):
            return solves
    return _WARM_PASSES + _balance_from_rest(g, v, slip, stiffness, forward, backward, pivot)


@step_kernel
def _solve_sliding(
    g: NDArray[np.float64],
    v: NDArray[np.float64],
    slip: NDArray[np.float64],
    stiffness: float,
    forward: float,
    backward: float,
    pivot: NDArray[np.float64],
) -> None:
    """Solve for the velocities of the sliding nodes, those of the stuck ones being 0 (Thomas algorithm)."""
    n = g.size
    scale = 1.0 / stiffness
    before, coupling = 0.0, 0.0  # right-hand side and inverse pivot of the row above; 0 where it is stuck
    for i in range(n):
        if slip[i] == STUCK:
            v[i], pivot[i] = 0.0, 0.0
        else:
            friction = forward if slip[i] == FORWARD else -backward
            degree = 1.0 if i == 0 or i == n - 1 else 2.0
            remaining = degree - coupling
            if remaining < RIGID_RESISTANCE:
                remaining = RIGID_RESISTANCE
            v[i] = (g[i] - friction) * scale + coupling * before
            pivot[i] = 1.0 / remaining
        before, coupling = v[i], pivot[i]
    rigid = pivot[n - 1] * RIGID_RESISTANCE > 0.5 and _balanced(v[n - 1], g, scale, forward + backward)
    if rigid:
        v[n - 1] = 0.0
    v[n - 1] *= pivot[n - 1]
    for i in range(n - 2, -1, -1):
        v[i] = (v[i] + v[i + 1]) * pivot[i]
    if rigid:
        _centre_rigid_motion(v, slip)


@step_kernel
def _balanced(total: float, g: NDArray[np.float64], scale: float, limits: float) -> bool:
    """Whether the sum of all forces, as the elimination leaves it in the last row, is 0 up to rounding."""
    magnitude = g.size * limits
    for i in range(g.size):
        magnitude += abs(g[i])
    return abs(total) <= _ROUNDING * magnitude * scale


@step_kernel
def _centre_rigid_motion(v: NDArray[np.float64], slip: NDArray[np.float64]) -> None:
    """Where friction balances at any rigid velocity, take the middle one of those that it allows.

    It is the limit of eq. 8 for a vanishing width: both tails of its tanh have the same weight.
    """
    lowest, highest = -np.inf, np.inf
    for i in range(v.size):
        if slip[i] == FORWARD:
            lowest = max(lowest, -v[i])
        else:
            highest = min(highest, -v[i])
    if lowest <= highest and highest - lowest < np.inf:
        v += 0.5 * (lowest + highest)


@step_kernel
def _correct(
    g: NDArray[np.float64],
    v: NDArray[np.float64],
    slip: NDArray[np.float64],
    stiffness: float,
    forward: float,
    backward: float,
) -> bool:
    """Let go of overloaded nodes, stop those that slide against their own friction; say if any changed."""
    n = g.size
    changed = False
    for i in range(n):
        if slip[i] == STUCK:
            new = _slip_of_stuck(_holding_force(g, v, stiffness, i), forward, backward)
        else:
            new = slip[i] if v[i] * slip[i] >= 0.0 else STUCK
        if new != slip[i]:
            slip[i] = new
            changed = True
    return changed


@step_kernel
def _holding_force(g: NDArray[np.float64], v: NDArray[np.float64], stiffness: float, i: int) -> float:
    """Friction that it takes to hold the stuck node i."""
    pull: float = 0.0
    if i > 0:
        pull += v[i - 1]
    if i < g.size - 1:
        pull += v[i + 1]
    return float(g[i] + stiffness * pull)


@step_kernel
def _slip_of_stuck(holding: float, forward: float, backward: float) -> float:
    if holding > forward:
        return FORWARD
    return BACKWARD if holding < -backward else STUCK


@step_kernel
def _balance_from_rest(
    g: NDArray[np.float64],
    v: NDArray[np.float64],
    slip: NDArray[np.float64],
    stiffness: float,
    forward: float,
    backward: float,
    pivot: NDArray[np.float64],
) -> int:
    """Nested policy iteration; each set only grows, so it ends after at most (N + 2)^2 solves.

    Given the nodes that slip backward, the forward-sliding set grows to its fixed point; then overloaded
    stuck nodes join the backward ones, and the forward set is built again.
    """
    n = g.size
    solves = 0
    slip[:] = STUCK
    while True:
        grown = True
        while grown:
            _solve_sliding(g, v, slip, stiffness, forward, backward, pivot)
            solves += 1
            grown = False
            for i in range(n):
                if slip[i] == STUCK and _holding_force(g, v, stiffness, i) > forward:
                    slip[i] = FORWARD
                    grown = True
        overloaded = False
        for i in range(n):
            if slip[i] == STUCK and _holding_force(g, v, stiffness, i) < -backward:
                slip[i] = BACKWARD
                overloaded = True
        if not overloaded:
            return solves
        for i in range(n):
            if slip[i] == FORWARD:
                slip[i] = STUCK
