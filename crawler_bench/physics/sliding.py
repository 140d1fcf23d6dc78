"""The force balance of body.py while no node changes its state, which is nearly always.

The states (sliding forward, stuck, sliding backward) decide the tridiagonal matrix, so it is factorized once,
without its factor c + dt, and each step is left with the two substitutions of the Thomas algorithm. They do
not chain one run of sliding nodes to the next, and they need no division. The result has to confirm the
states: a node that slides goes against its friction, and friction can hold a node that is stuck.
"""

import numpy as np
from numpy.typing import NDArray

from crawler_bench.physics.body import FORWARD, RIGID_RESISTANCE, STUCK
from crawler_bench.physics.compilation import inner_kernel


@inner_kernel
def factorize(
    slip: NDArray[np.float64],
    pivot: NDArray[np.float64],
    friction: NDArray[np.float64],
    forward: float,
    backward: float,
) -> None:
    """Eliminate once for all steps in which no node changes its state.

    Args:
        slip: (N + 1,) FORWARD, STUCK or BACKWARD for each node.
        pivot: (N + 1,) written: inverse pivot of each sliding node, 0 for a stuck one.
        friction: (N + 1,) written: friction on each sliding node, k L.
        forward: friction limit against forward sliding, k L.
        backward: friction limit against backward sliding, k L.
    """
    n = slip.size
    before = 0.0
    for i in range(n):
        degree = 1.0 if i == 0 or i == n - 1 else 2.0
        pivot[i] = 1.0 / max(degree - before, RIGID_RESISTANCE) if slip[i] != STUCK else 0.0
        friction[i] = forward if slip[i] == FORWARD else -backward
        before = pivot[i]


@inner_kernel
def eliminate(
    u: NDArray[np.float64],
    f: NDArray[np.float64],
    g: NDArray[np.float64],
    v: NDArray[np.float64],
    pivot: NDArray[np.float64],
    friction: NDArray[np.float64],
    pull_on_head: float,
    pull_on_neck: float,
    stiffness: float,
) -> None:
    """Add up the forces and do the forward half of the Thomas algorithm.

    Args:
        u: (N + 1,) displacements, L.
        f: (N + 1,) muscle forces, k L.
        g: (N + 1,) written: B f - A u, the force on each node before friction and damping, k L.
        v: (N + 1,) written: right-hand side after the elimination.
        pivot: (N + 1,) from `factorize`.
        friction: (N + 1,) from `factorize`.
        pull_on_head: share of f_0 that acts on node 0.
        pull_on_neck: share of f_0 that acts on node 1.
        stiffness: c + dt, the factor of the Laplacian.
    """
    n, scale = u.size, 1.0 / stiffness
    tension = f[1] + (u[0] - u[1])  # of muscle and spring of a segment
    g[0] = pull_on_head * f[0] - tension
    tension += pull_on_neck * f[0]
    before = (g[0] - friction[0]) * scale if pivot[0] != 0.0 else 0.0
    v[0] = before
    coupling = pivot[0]
    for i in range(1, n):
        following = f[i + 1] + (u[i] - u[i + 1]) if i < n - 1 else 0.0
        g[i] = tension - following
        tension = following
        # A branch, because a product with 0 would chain the run of sliding nodes to the one before.
        before = (g[i] - friction[i]) * scale + before * coupling if pivot[i] != 0.0 else 0.0
        v[i] = before
        coupling = pivot[i]


@inner_kernel
def substitute(
    g: NDArray[np.float64],
    v: NDArray[np.float64],
    pivot: NDArray[np.float64],
    friction: NDArray[np.float64],
    stiffness: float,
    forward: float,
    backward: float,
) -> bool:
    """Do the backward half of the Thomas algorithm; say whether the velocities confirm the states.

    Args:
        g: (N + 1,) from `eliminate`.
        v: (N + 1,) from `eliminate`; then the velocity of each node, L / tau_theta.
        pivot: (N + 1,) from `factorize`.
        friction: (N + 1,) from `factorize`.
        stiffness: c + dt, the factor of the Laplacian.
        forward: friction limit against forward sliding, k L.
        backward: friction limit against backward sliding, k L.
    """
    n = g.size
    confirmed: bool = pivot[n - 1] * RIGID_RESISTANCE < 0.5  # otherwise every node slides
    after, beyond, held = 0.0, 0.0, False  # of nodes i + 1 and i + 2; whether node i + 1 is stuck
    for i in range(n - 1, -1, -1):
        velocity = 0.0
        if pivot[i] != 0.0:
            velocity = (v[i] + after) * pivot[i]
            v[i] = velocity
            confirmed &= velocity * friction[i] >= 0.0
        if held:
            holding = g[i + 1] + stiffness * (velocity + beyond)
            confirmed &= (holding <= forward) & (holding >= -backward)
        held = pivot[i] == 0.0
        after, beyond = velocity, after
    if held:
        holding = g[0] + stiffness * beyond
        confirmed &= (holding <= forward) & (holding >= -backward)
    return bool(confirmed)
