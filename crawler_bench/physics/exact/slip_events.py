"""Which node starts or stops sliding next, between two events of the muscles, and what happens then.

Most nodes keep their slip state up to the end of a decision. A cheap test, which overlooks none that changes,
finds them: by where their margins will be at the end, and by how far their first slope takes them. Only the
others are asked when.
"""

from typing import NamedTuple

import numpy as np

from crawler_bench.physics.body import BACKWARD, FORWARD, STUCK
from crawler_bench.physics.coefficients import Coefficients
from crawler_bench.physics.compiled import inline_kernel, inner_kernel
from crawler_bench.physics.exact.crossings import Margin, crossing_time
from crawler_bench.physics.exact.trajectory import force_at, position
from crawler_bench.physics.relaxation import Response
from crawler_bench.physics.state import Node, Nodes
from crawler_bench.physics.tolerances import NEVER


class SlipEvent(NamedTuple):
    """The node that starts or stops sliding next."""

    time: float  # the end of the decision if none does before
    node: int  # -1 if none does


class Outlook(NamedTuple):
    """What the terms of a margin count at the end, and where the first slope leads by then.

    The constant term of a stuck node counts 1; that of a sliding one counts `fade` in both.
    """

    fade: float
    end_stuck: tuple[float, float]  # the terms that go as e_f and as r_f, at the end
    end_sliding: tuple[float, float]
    far_stuck: tuple[float, float]  # the same along the first slope
    far_sliding: tuple[float, float]


@inline_kernel
def look_ahead(now: Response, end: Response, k: Coefficients) -> Outlook:
    """Prepare to look from now to the end.

    Where a force turns on its way, it goes at most as far as its first slope takes it, as its slope, divided
    by e_f, is monotone; where it does not turn, it stays between its start and its end. The same holds for
    the velocity of a sliding node, which follows the force and fades meanwhile. A node begins inside its
    limits, or at one: on its way out, its first slope tells; on its way in, the end does.
    """
    passes, fade = (end.time - now.time) * k.times.rate_f, end.e_c / now.e_c
    slope_f, slope_r = -now.e_f * passes, (now.e_m - now.r_f) * passes
    return Outlook(
        fade=end.e_c,
        end_stuck=(end.e_f, end.r_f),
        end_sliding=(end.e_f - end.s_f, end.r_f - end.s_r),
        far_stuck=(now.e_f + slope_f, now.r_f + slope_r),
        far_sliding=((now.e_f - now.s_f) * fade + slope_f, (now.r_f - now.s_r) * fade + slope_r),
    )


@inline_kernel
def may_change(node: Node, outlook: Outlook, k: Coefficients) -> bool:
    """Whether a node may start or stop sliding before the end: True where in doubt."""
    o, m = outlook, node.margin
    sliding = node.slip != STUCK
    fixed = m.constant * (o.fade if sliding else 1.0)
    end_f, end_r = o.end_sliding if sliding else o.end_stuck
    far_f, far_r = o.far_sliding if sliding else o.far_stuck
    end, far = fixed + m.as_e_f * end_f + m.as_r_f * end_r, fixed + m.as_e_f * far_f + m.as_r_f * far_r
    lowest, highest = (k.tolerance, NEVER) if sliding else (k.tolerance - k.backward, k.forward - k.tolerance)
    return not (min(end, far) > lowest and max(end, far) < highest)


@inline_kernel
def find_slip_times(
    nodes: Nodes, low: int, high: int, now: Response, end: Response, patient: bool, k: Coefficients
) -> SlipEvent:
    """Find when each node from `low` to `high` starts or stops sliding, if before the end.

    Args:
        nodes: their margins are read, their slip times written.
        low: the first node.
        high: the last node.
        now: the responses.
        end: the responses at the end of the decision.
        patient: whether to overlook a node that leaves at once, which rounding may do again and again.
        k: coefficients.

    Returns:
        The first of these nodes that does.
    """
    outlook, first = look_ahead(now, end, k), SlipEvent(end.time, -1)
    for i in range(low, high + 1):
        node = nodes[i]
        node.slip_time = NEVER
        if may_change(node, outlook, k):
            node.slip_time = slip_time(node, now, end, patient, k)
            if node.slip_time < first.time:
                first = SlipEvent(node.slip_time, i)
    return first


@inline_kernel
def slip_time(node: Node, now: Response, end: Response, patient: bool, k: Coefficients) -> float:
    """When a node starts or stops sliding; NEVER if it does not before the end."""
    m = node.margin
    if node.slip != STUCK:
        return crossing_time(Margin(m.constant, m.as_e_f, m.as_r_f, True), now, end, patient, k)
    above_backward = Margin(k.backward + m.constant, m.as_e_f, m.as_r_f, False)
    below_forward = Margin(k.forward + k.backward - above_backward.constant, -m.as_e_f, -m.as_r_f, False)
    return min(
        crossing_time(above_backward, now, end, patient, k),
        crossing_time(below_forward, now, end, patient, k),
    )


@inline_kernel
def next_slip_event(nodes: Nodes, end: Response) -> SlipEvent:
    """The first of the slip times before the end."""
    first, where = end.time, -1
    for i in range(nodes.size):
        if nodes[i].slip_time < first:
            first, where = nodes[i].slip_time, i
    return SlipEvent(first, where)


@inner_kernel
def change_slip(nodes: Nodes, i: int, now: Response, k: Coefficients) -> None:
    """Stop the sliding node i, or let the stuck one go in the direction in which it is overloaded.

    With the last stuck node gone, nothing would resist rigid motion: the body jumps to the velocity at which
    the slowest node that slides the other way sticks. (Unless friction balances: see integrator.py.)
    """
    node = nodes[i]
    if node.slip != STUCK:
        stop(node, now)
        return
    direction = FORWARD if force_at(node.margin, now) > 0.5 * (k.forward - k.backward) else BACKWARD
    slowest, best = -1, np.inf
    for n in range(nodes.size):
        other = nodes[n]
        if k.may_balance or (n != i and other.slip == STUCK):
            node.slip = direction
            return
        if other.slip == -direction:
            distance = abs(force_at(other.w, now) - position(other, now))
            if distance < best:
                slowest, best = n, distance
    if slowest >= 0:
        stop(nodes[slowest], now)
        node.slip = direction


@inline_kernel
def stop(node: Node, now: Response) -> None:
    """Stop a sliding node where it is."""
    node.displacement_at_epoch = position(node, now)
    node.slip = STUCK
