"""Which nodes of the crawler start or stop sliding, and how, between two events of the muscles.

A node leaves its state when its height falls below 0 (exits.py). That most nodes do not is seen from where
they are now, where they will be, and how steeply they go there; only the others are asked when.
"""

from typing import NamedTuple

import numpy as np

from crawler_bench.physics.body import BACKWARD, FORWARD, STUCK
from crawler_bench.physics.coefficients import Coefficients
from crawler_bench.physics.compilation import inner_kernel
from crawler_bench.physics.exits import exit_time, height, slope_of
from crawler_bench.physics.layout import (
    LEAVE_AT,
    NET,
    NET_F,
    NET_R,
    NEVER,
    ORIGIN,
    SLIP,
    W_F,
    W_R,
    WORK,
    Memory,
    W,
)
from crawler_bench.physics.response import Response


class Sights(NamedTuple):
    """How far ahead one looks, and the responses there."""

    until: float  # the end of the decision
    end: Response
    horizon: float  # the end of the last decision before the next epoch
    far: Response


@inner_kernel
def watch(
    memory: Memory, low: int, high: int, anew: bool, clock: float, now: Response, sights: Sights,
    patient: bool, k: Coefficients,
) -> None:  # fmt: skip
    """Note when to look at each node from `low` to `high` again.

    Not before the next epoch, if it surely keeps its state so long; or at the end of the decision, if it
    keeps it so long; or else when it leaves its state.

    Args:
        memory: LEAVE_AT is written.
        low: the first node.
        high: the last node.
        anew: look at all of them, as their course is new; else only at those whose time has come.
        clock: time now.
        now: the responses.
        sights: how far one looks.
        patient: whether to overlook a node that leaves at once, which rounding may do again and again.
        k: coefficients.
    """
    leave_at, listed = memory[LEAVE_AT], memory[WORK]
    count = 0
    for i in range(low, high + 1):  # lists are made without branches, too
        listed[count] = i
        count += int(anew or leave_at[i] <= clock)
    suspects = 0
    for j in range(count):
        i = int(listed[j])
        leave_at[i] = _safe_until(memory, i, clock, now, sights, k)
        listed[suspects] = i
        suspects += int(leave_at[i] < clock)
    for j in range(suspects):
        i = int(listed[j])
        leave_at[i] = sights.until
        sliding, limits = memory[SLIP, i] != STUCK, 1
        p, q_f, q_r = _force(memory, i, sliding)
        if not sliding:
            p, limits = k.backward + p, 2
        for _ in range(limits):
            time = exit_time(
                p, q_f, q_r, sliding, clock, now, sights.until, sights.end, patient, k.times, k.tolerance
            )
            leave_at[i] = min(leave_at[i], time)
            p, q_f, q_r = k.forward + k.backward - p, -q_f, -q_r  # the distance to the other limit


@inner_kernel
def _safe_until(
    memory: Memory, i: int, clock: float, now: Response, sights: Sights, k: Coefficients
) -> float:
    """Until when a node surely keeps its state: NEVER, the end of the decision, or less than `clock`.

    Without branches, of which a processor would guess many wrong.
    """
    sliding = memory[SLIP, i] != STUCK
    p, q_f, q_r = _force(memory, i, sliding)
    start, slope = height(p, q_f, q_r, sliding, now), slope_of(q_f, q_r, now, k.times.rate_f)
    lowest, highest = (0.0, NEVER) if sliding else (-k.backward, k.forward)
    is_inside = (start < highest - k.tolerance) & (start > lowest + k.tolerance)
    safe = -NEVER
    for until, end, sure in ((sights.until, sights.end, sights.until), (sights.horizon, sights.far, NEVER)):
        at_end, last_slope = height(p, q_f, q_r, sliding, end), slope_of(q_f, q_r, end, k.times.rate_f)
        stays = is_inside & (at_end < highest - k.tolerance) & (at_end > lowest + k.tolerance)
        # Where it may turn in between, it goes at most as far as its first slope takes it.
        far = start * (end.e_c if sliding else 1.0) + slope * (until - clock)
        stays &= (slope * last_slope >= 0.0) | ((far < highest) & (far > lowest))
        safe = sure if stays else safe
    return safe


@inner_kernel
def _force(memory: Memory, i: int, sliding: bool) -> tuple[float, float, float]:
    """Force that holds a stuck node; velocity of a sliding one in its direction, times c; as its parts."""
    slip, own, own_f, own_r = memory[SLIP, i], memory[W, i], memory[W_F, i], memory[W_R, i]
    above, below = max(i - 1, 0), min(i + 1, memory.shape[1] - 1)  # at an end: the node itself, where w is u
    held = memory[NET, i] + (memory[W, above] + memory[W, below] - 2.0 * memory[ORIGIN, i])
    held_f = memory[NET_F, i] + memory[W_F, above] + memory[W_F, below]
    held_r = memory[NET_R, i] + memory[W_R, above] + memory[W_R, below]
    return (
        slip * (own - memory[ORIGIN, i]) if sliding else held,
        slip * own_f if sliding else held_f,
        slip * own_r if sliding else held_r,
    )


@inner_kernel
def switch(memory: Memory, node: int, now: Response, k: Coefficients) -> None:
    """Stop a sliding node, or let a stuck one go in the direction in which it is overloaded.

    With the last stuck node gone, nothing would resist rigid motion: the body jumps to the velocity at which
    the slowest node that slides the other way sticks. (Unless friction balances: see `exact.cross_decision`.)
    """
    u, slip, last = memory[ORIGIN], memory[SLIP], memory.shape[1] - 1
    if slip[node] != STUCK:
        slip[node] = STUCK
        return
    pull = memory[NET, node] + memory[NET_F, node] * now.e_f + memory[NET_R, node] * now.r_f
    for neighbour in (node - 1, node + 1):
        if 0 <= neighbour <= last:
            pull += _w(memory, neighbour, now) - u[node]
    direction = FORWARD if pull > 0.5 * (k.forward - k.backward) else BACKWARD
    slowest, best = -1, np.inf
    for i in range(last + 1):
        if k.may_balance or (i != node and slip[i] == STUCK):
            slip[node] = direction
            return
        if slip[i] == -direction:
            distance = abs(_w(memory, i, now) - u[i])
            if distance < best:
                slowest, best = i, distance
    if slowest >= 0:
        slip[slowest] = STUCK
        slip[node] = direction


@inner_kernel
def _w(memory: Memory, i: int, now: Response) -> float:
    """What node i relaxes towards; where it is, if it is stuck."""
    return float(memory[W, i] + memory[W_F, i] * now.e_f + memory[W_R, i] * now.r_f)
