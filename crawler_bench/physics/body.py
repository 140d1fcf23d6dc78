"""The viscoelastic body on dry ground [M20, eq. 1-3 and 8]: the balance of forces, and which nodes slide.

With A the Laplacian of the chain of nodes, the inertialess force balance reads

    c A du/dt + friction(du/dt) = -k A u + B f,       or       A w = B f - friction,       w = c du/dt + k u,

where friction is the forward limit on a node with du/dt > 0, minus the backward limit on one with
du/dt < 0, and between the two whatever holds a node with du/dt = 0, where w = u. Eq. 8's tanh is this law,
smoothed over a width of 1e-6. Both integrators solve this tridiagonal system for the nodes that slide, by the
Thomas algorithm.

Which nodes slide is found by an active-set iteration: assume a state of each node, solve for those that
slide, correct the states that the solution contradicts. Started from the states of the step before, this ends
after one or two passes. It may, rarely, cycle; then the states are built up from rest in an order that
provably ends, because the matrix is an M-matrix (policy iteration on max(min(v, r + forward), r - backward)
= 0, where v is the velocity and r = A w - B f).
"""

import numpy as np

from crawler_bench.physics.coefficients import Coefficients
from crawler_bench.physics.compiled import inline_kernel, inner_kernel
from crawler_bench.physics.state import Node, Nodes
from crawler_bench.physics.tolerances import BALANCED, RIGID_RESISTANCE, WARM_PASSES

FORWARD, STUCK, BACKWARD = 1.0, 0.0, -1.0


@inline_kernel
def friction(slip: float, k: Coefficients) -> float:
    """Friction on a node that slides, k L [M20, eq. 8]."""
    return k.forward if slip == FORWARD else -k.backward


@inner_kernel
def slip_of_stuck(holding: float, k: Coefficients) -> float:
    """Slip state of a stuck node that this friction, k L, would have to hold [M20, eq. 8]."""
    if holding > k.forward:
        return FORWARD
    return BACKWARD if holding < -k.backward else STUCK


@inline_kernel
def chain_force(above: float, own: float, below: float) -> float:
    """Row of -A: the pull of its neighbours on a node [M20, eq. 1-3]; beyond an end it meets itself."""
    return above + below - 2.0 * own


@inline_kernel
def holding_force(nodes: Nodes, i: int) -> tuple[float, float, float]:
    """Friction that it takes to hold the stuck node i, B f - A w, as its terms, k L."""
    node, above, below = nodes[i], nodes[max(i - 1, 0)], nodes[min(i + 1, nodes.size - 1)]
    return (
        node.net.constant + chain_force(above.w.constant, node.w.constant, below.w.constant),
        node.net.as_e_f + above.w.as_e_f + below.w.as_e_f,  # its own w is constant
        node.net.as_r_f + above.w.as_r_f + below.w.as_r_f,
    )


@inline_kernel
def stand_still(node: Node, displacement: float) -> None:
    """Let w be what it is on a node that does not move."""
    node.w.constant, node.w.as_e_f, node.w.as_r_f = displacement, 0.0, 0.0


@inline_kernel
def solve_sliding(nodes: Nodes, low: int, high: int, k: Coefficients) -> None:
    """Solve the force balance for w of the sliding nodes from `low` to `high` [M20, eq. 1-3].

    Args:
        nodes: w of stuck ones is given, w of sliding ones is written.
        low: the first node, which is at the head or stuck.
        high: the last node, which is at the tail or stuck.
        k: coefficients.
    """
    eliminate(nodes, low, high, k)
    substitute(nodes, low, high)


@inline_kernel
def eliminate(nodes: Nodes, low: int, high: int, k: Coefficients) -> None:
    """Forward half of the Thomas algorithm, for all three terms of w."""
    above, above_f, above_r, coupling = (
        0.0,
        0.0,
        0.0,
        0.0,
    )  # what the row before adds, and takes off the diagonal
    for i in range(low, high + 1):
        node = nodes[i]
        if node.slip == STUCK:
            above, above_f, above_r, coupling = node.w.constant, 0.0, 0.0, 0.0
        else:
            degree = 1.0 if i == 0 or i == nodes.size - 1 else 2.0
            coupling = 1.0 / max(degree - coupling, RIGID_RESISTANCE)
            above = coupling * (node.net.constant - friction(node.slip, k) + above)
            above_f = coupling * (node.net.as_e_f + above_f)
            above_r = coupling * (node.net.as_r_f + above_r)
            node.w.constant, node.w.as_e_f, node.w.as_r_f = above, above_f, above_r
        node.inverse_pivot = coupling


@inline_kernel
def substitute(nodes: Nodes, low: int, high: int) -> None:
    """Backward half of the Thomas algorithm."""
    after, after_f, after_r = 0.0, 0.0, 0.0  # w of the node behind
    for i in range(high, low - 1, -1):
        node = nodes[i]
        if node.slip != STUCK:
            node.w.constant += node.inverse_pivot * after
            node.w.as_e_f += node.inverse_pivot * after_f
            node.w.as_r_f += node.inverse_pivot * after_r
        after, after_f, after_r = node.w.constant, node.w.as_e_f, node.w.as_r_f


@inner_kernel
def balance_forces(nodes: Nodes, k: Coefficients) -> int:
    """Find which nodes slide, and w of all nodes, at one moment.

    Args:
        nodes: `displacement` and the constant terms of `net` are read; `slip` is the first guess, then the
            answer; w is written, and its terms other than the constant one are 0 where those of `net` are.
        k: coefficients.

    Returns:
        The number of tridiagonal solves.
    """
    for solves in range(1, WARM_PASSES + 1):
        _solve_states(nodes, k)
        if not _correct_states(nodes, k):
            return solves
    return WARM_PASSES + _balance_from_rest(nodes, k)


@inner_kernel
def _solve_states(nodes: Nodes, k: Coefficients) -> None:
    """Solve for w under the assumed states of the nodes."""
    for node in nodes:
        if node.slip == STUCK:
            stand_still(node, node.displacement)
    tail = nodes.size - 1
    eliminate(nodes, 0, tail, k)
    rigid = nodes[tail].inverse_pivot * RIGID_RESISTANCE > 0.5 and _balanced(nodes, k)
    if rigid:
        nodes[tail].w.constant = nodes[tail].displacement
    substitute(nodes, 0, tail)
    if rigid:
        _centre_rigid_motion(nodes)


@inner_kernel
def _correct_states(nodes: Nodes, k: Coefficients) -> bool:
    """Let go of overloaded nodes, stop those that slide against their own friction; say if any changed."""
    changed = False
    for i in range(nodes.size):
        node = nodes[i]
        if node.slip == STUCK:
            new = slip_of_stuck(holding_force(nodes, i)[0], k)
        else:
            new = node.slip if (node.w.constant - node.displacement) * node.slip >= 0.0 else STUCK
        if new != node.slip:
            node.slip = new
            changed = True
    return changed


@inner_kernel
def _balanced(nodes: Nodes, k: Coefficients) -> bool:
    """Whether the sum of all forces, as the elimination leaves it in the last row, is 0 up to rounding."""
    magnitude = nodes.size * (k.forward + k.backward)
    for node in nodes:
        magnitude += abs(node.net.constant)
    return abs(nodes[nodes.size - 1].w.constant) * RIGID_RESISTANCE <= BALANCED * magnitude


@inner_kernel
def _centre_rigid_motion(nodes: Nodes) -> None:
    """Where friction balances at any rigid velocity, take the middle one of those that it allows.

    It is the limit of eq. 8 for a vanishing width: both tails of its tanh have the same weight.
    """
    lowest, highest = -np.inf, np.inf
    for node in nodes:
        moving = node.w.constant - node.displacement
        if node.slip == FORWARD:
            lowest = max(lowest, -moving)
        else:
            highest = min(highest, -moving)
    if lowest <= highest and highest - lowest < np.inf:
        for node in nodes:
            node.w.constant += 0.5 * (lowest + highest)


@inner_kernel
def _balance_from_rest(nodes: Nodes, k: Coefficients) -> int:
    """Nested policy iteration; each set only grows, so it ends after at most (N + 2)^2 solves.

    Given the nodes that slip backward, the forward-sliding set grows to its fixed point; then overloaded
    stuck nodes join the backward ones, and the forward set is built again.
    """
    solves = 0
    for node in nodes:
        node.slip = STUCK
    while True:
        grown = True
        while grown:
            _solve_states(nodes, k)
            solves += 1
            grown = _let_go(nodes, FORWARD, k)
        if not _let_go(nodes, BACKWARD, k):
            return solves
        for node in nodes:
            if node.slip == FORWARD:
                node.slip = STUCK


@inner_kernel
def _let_go(nodes: Nodes, direction: float, k: Coefficients) -> bool:
    """Let go of every stuck node that is overloaded in a direction; say if there was one."""
    found = False
    for i in range(nodes.size):
        if nodes[i].slip == STUCK and slip_of_stuck(holding_force(nodes, i)[0], k) == direction:
            nodes[i].slip = direction
            found = True
    return found
