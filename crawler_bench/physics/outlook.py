"""Which nodes may leave their state before the end of a decision: a cheap test that overlooks none.

A node leaves its state when its height falls below 0 (exits.py). That most nodes do not is seen from where
they will be at the end, and from how far their first slope takes them; only the others are asked when.

Lists of nodes are made without branches, of which a processor would guess many wrong.
"""

from typing import NamedTuple

import numpy as np

from crawler_bench.physics.body import STUCK
from crawler_bench.physics.coefficients import Coefficients
from crawler_bench.physics.compilation import inner_kernel
from crawler_bench.physics.course import hold
from crawler_bench.physics.intrinsics import NO_BITS, WORD, flat, lowest_bit
from crawler_bench.physics.layout import HOLD, HOLD_F, HOLD_R, LEAVE_AT, NEVER, SLIP, WORK, Memory
from crawler_bench.physics.response import Response

_ONE = np.uint64(1)
_LANES = 4  # doubles that a processor calculates with at a time


class Outlook(NamedTuple):
    """What the parts of a force count at the end, and along the first slope up to there.

    The constant part of the force on a stuck node counts 1; that of a sliding one counts as much at the end
    as along the slope.
    """

    sliding: float  # constant part of a sliding node
    end_stuck: tuple[float, float]  # parts that go as e_f and as r_f, at the end
    end_sliding: tuple[float, float]
    far_stuck: tuple[float, float]  # the same where the first slope leads by then
    far_sliding: tuple[float, float]
    backward: float  # limits of the force on a stuck node, narrowed by the tolerance
    forward: float
    still: float  # limit of the velocity of a sliding one, likewise


@inner_kernel
def look_ahead(clock: float, now: Response, until: float, end: Response, k: Coefficients) -> Outlook:
    """Prepare to look from now, `clock`, to the end, `until`, at which the responses are `end`.

    Where a force turns on its way, it goes at most as far as its first slope takes it, as its slope, divided
    by e_f, is monotone; where it does not turn, it stays between its start and its end. The same holds for
    the velocity of a sliding node, which follows the force and fades meanwhile. A node begins inside its
    limits, or at one: on its way out, its first slope tells; on its way in, the end does.
    """
    passes, fade = (until - clock) * k.times.rate_f, end.e_c / now.e_c
    slope_f, slope_r = -now.e_f * passes, (now.e_m - now.r_f) * passes
    return Outlook(
        sliding=end.e_c,
        end_stuck=(end.e_f, end.r_f),
        end_sliding=(end.e_f - end.s_f, end.r_f - end.s_r),
        far_stuck=(now.e_f + slope_f, now.r_f + slope_r),
        far_sliding=((now.e_f - now.s_f) * fade + slope_f, (now.r_f - now.s_r) * fade + slope_r),
        backward=k.tolerance - k.backward,
        forward=k.forward - k.tolerance,
        still=k.tolerance,
    )


@inner_kernel
def _may_leave(p: float, q_f: float, q_r: float, sliding: bool, outlook: Outlook) -> bool:
    """Whether a node, whose force or velocity is given as its parts, may leave its state before the end."""
    o = outlook
    fixed = p * (o.sliding if sliding else 1.0)
    end_f, end_r = o.end_sliding if sliding else o.end_stuck
    far_f, far_r = o.far_sliding if sliding else o.far_stuck
    end, far = fixed + q_f * end_f + q_r * end_r, fixed + q_f * far_f + q_r * far_r
    lowest, highest = (o.still, NEVER) if sliding else (o.backward, o.forward)
    return not ((min(end, far) > lowest) & (max(end, far) < highest))


@inner_kernel
def look_at_run(memory: Memory, low: int, high: int, outlook: Outlook) -> np.uint64:
    """List those of the nodes from `low` to `high`, whose course is new, that may leave their state.

    Args:
        memory: WORK receives the list; HOLD is found for these nodes, LEAVE_AT is set to NEVER.
        low: the first node.
        high: the last node.
        outlook: up to the end.

    Returns:
        How many there are.
    """
    count = np.uint64(0)
    for n in range(low, high + 1):
        i = np.uint64(n)
        p, q_f, q_r = hold(memory, n)
        memory[LEAVE_AT, i] = NEVER
        memory[WORK, count] = n  # written anyway, and counted if it belongs to the list
        count += np.uint64(_may_leave(p, q_f, q_r, memory[SLIP, i] != STUCK, outlook))
    return count


@inner_kernel
def look_at_all(memory: Memory, outlook: Outlook) -> np.uint64:
    """List those of all nodes, of which HOLD is up to date, that may leave their state; see `look_at_run`."""
    nodes, rows, count = memory.shape[1], flat(memory), np.uint64(0)
    p, q_f, q_r = rows[HOLD * nodes :], rows[HOLD_F * nodes :], rows[HOLD_R * nodes :]
    slip = rows[SLIP * nodes :]
    memory[LEAVE_AT] = NEVER
    for first in range(0, nodes, WORD):
        # Several at a time; those beyond the last node are entries of the next row, and mean nothing.
        size = min(WORD, (nodes - first + _LANES - 1) // _LANES * _LANES)
        found = NO_BITS
        for n in range(size):
            i = np.uint64(first + n)
            may_leave = _may_leave(p[i], q_f[i], q_r[i], slip[i] != STUCK, outlook)
            found |= np.uint64(may_leave) << np.uint64(n)
        if nodes - first < WORD:
            found &= (_ONE << np.uint64(nodes - first)) - _ONE
        while found != NO_BITS:
            memory[WORK, count] = first + lowest_bit(found)
            found &= found - _ONE
            count += _ONE
    return count
