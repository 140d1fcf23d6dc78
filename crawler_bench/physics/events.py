"""Which nodes of the crawler start or stop sliding, and how, between two events of the muscles.

A node leaves its state when its height falls below 0 (exits.py). That most nodes do not is seen from where
they are now, where they will be, and how steeply they go there; only the others are asked when.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

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

# Lists of nodes are made without branches, of which a processor would guess many wrong: what comes next is
# written anyway, and counted if it belongs to the list. An index without sign needs no check for one below 0.
NO_NODES = np.uint64(0)


class Sights(NamedTuple):
    """How far ahead one looks, and the responses there."""

    until: float  # the end of the decision
    end: Response
    horizon: float  # the end of the last decision before the next epoch
    far: Response


class Leaver(NamedTuple):
    """The node that leaves its state next."""

    time: float  # when; the end of the decision if none leaves before
    node: int  # -1 if none does
    known: int  # how many were found since the decision began


@inner_kernel
def watch(
    memory: Memory, low: int, high: int, anew: bool, clock: float, now: Response, sights: Sights,
    first: Leaver, patient: bool, k: Coefficients,
) -> Leaver:  # fmt: skip
    """Note when to look at nodes again.

    Not before the next epoch, if a node surely keeps its state so long; or at the end of the decision, if it
    keeps it so long; or else when it leaves its state.

    Args:
        memory: LEAVE_AT is written.
        low: the first node whose course is new.
        high: the last node whose course is new.
        anew: look at these; else, at all nodes whose time has come, as no course is new.
        clock: time now.
        now: the responses.
        sights: how far one looks.
        first: who left, or was to leave, first up to now.
        patient: whether to overlook a node that leaves at once, which rounding may do again and again.
        k: coefficients.

    Returns:
        Who leaves first.
    """
    leave_at, listed, suspects = memory[LEAVE_AT], memory[WORK], NO_NODES
    if anew:
        for i in range(low, high + 1):
            suspects = _look(memory, i, suspects, clock, now, sights, k)
    else:
        count = NO_NODES
        for i in range(leave_at.size):
            listed[count] = i
            count += np.uint64(leave_at[i] <= clock)
        for j in range(count):
            suspects = _look(memory, int(listed[j]), suspects, clock, now, sights, k)
    time, node, known = sights.until, -1, first.known
    for j in range(suspects):
        i = int(listed[j])
        sliding, limits = memory[SLIP, i] != STUCK, 1
        p, q_f, q_r = _force(memory, i, sliding)
        if not sliding:
            p, limits = k.backward + p, 2
        for _ in range(limits):
            at = exit_time(
                p, q_f, q_r, sliding, clock, now, sights.until, sights.end, patient, k.times, k.tolerance
            )
            leave_at[i] = min(leave_at[i], at)
            p, q_f, q_r = k.forward + k.backward - p, -q_f, -q_r  # the distance to the other limit
        if leave_at[i] < time:
            time, node = leave_at[i], i
        known += int(leave_at[i] < sights.until)
    has_left = low <= first.node <= high
    if has_left and first.known > 1:  # others may be waiting elsewhere
        time, node = _earliest(leave_at, sights.until)
    elif not has_left and (first.time, first.node) <= (time, node):
        time, node = first.time, first.node
    return Leaver(time, node, known)


@inner_kernel
def _earliest(times: NDArray[np.float64], limit: float) -> tuple[float, int]:
    """The earliest time before `limit` and where it stands; `limit` and -1 if there is none."""
    first, where = limit, -1
    for i in range(times.size):
        if times[i] < first:
            first, where = times[i], i
    return first, where


@inner_kernel
def _look(
    memory: Memory, i: int, suspects: np.uint64, clock: float, now: Response, sights: Sights,
    k: Coefficients,
) -> np.uint64:  # fmt: skip
    """Note until when node i surely keeps its state; list it as a suspect if it may not until the end.

    Returns:
        How many suspects there are now.
    """
    sliding = memory[SLIP, i] != STUCK
    p, q_f, q_r = _force(memory, i, sliding)
    to_end = _stays(p, q_f, q_r, sliding, clock, now, sights.until, sights.end, k)
    to_horizon = _stays(p, q_f, q_r, sliding, clock, now, sights.horizon, sights.far, k)
    memory[LEAVE_AT, i] = sights.until + int(to_horizon) * NEVER  # without branches, like the list
    memory[WORK, suspects] = i
    return suspects + np.uint64(not (to_end | to_horizon))


@inner_kernel
def _stays(
    p: float, q_f: float, q_r: float, sliding: bool, clock: float, now: Response, until: float, end: Response,
    k: Coefficients,
) -> bool:  # fmt: skip
    """Whether a node surely keeps its state until a time."""
    start, slope = height(p, q_f, q_r, sliding, now), slope_of(q_f, q_r, now, k.times.rate_f)
    at_end, last_slope = height(p, q_f, q_r, sliding, end), slope_of(q_f, q_r, end, k.times.rate_f)
    lowest, highest = (0.0, NEVER) if sliding else (-k.backward, k.forward)
    is_inside = (start < highest - k.tolerance) & (start > lowest + k.tolerance)
    is_inside &= (at_end < highest - k.tolerance) & (at_end > lowest + k.tolerance)
    # Where it may turn in between, it goes at most as far as its first slope takes it.
    far = start * (end.e_c if sliding else 1.0) + slope * (until - clock)
    return bool(is_inside & ((slope * last_slope >= 0.0) | ((far < highest) & (far > lowest))))


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
