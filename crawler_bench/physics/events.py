"""Which nodes of the crawler start or stop sliding, and how, between two events of the muscles."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from crawler_bench.physics.body import BACKWARD, FORWARD, STUCK
from crawler_bench.physics.coefficients import Coefficients
from crawler_bench.physics.compilation import inner_kernel
from crawler_bench.physics.course import position
from crawler_bench.physics.exits import exit_time
from crawler_bench.physics.layout import (
    HOLD,
    HOLD_F,
    HOLD_R,
    LEAVE_AT,
    NET,
    NET_F,
    NET_R,
    ORIGIN,
    SLIP,
    W_F,
    W_R,
    WORK,
    Memory,
    W,
)
from crawler_bench.physics.outlook import look_ahead, look_at_all, look_at_run
from crawler_bench.physics.response import Response


class Leaver(NamedTuple):
    """The node that leaves its state next."""

    time: float  # when; the end of the decision if none leaves before
    node: int  # -1 if none does
    known: int  # how many were found since the decision began


@inner_kernel
def watch(
    memory: Memory, low: int, high: int, anew: bool, clock: float, now: Response, until: float, end: Response,
    first: Leaver, patient: bool, k: Coefficients,
) -> Leaver:  # fmt: skip
    """Find out which nodes leave their state before the end of the decision, and when.

    Args:
        memory: LEAVE_AT is written; HOLD of the nodes whose course is new; WORK.
        low: the first node whose course is new.
        high: the last node whose course is new.
        anew: look at these; else, as the decision begins, at all nodes.
        clock: time now.
        now: the responses.
        until: the end of the decision.
        end: the responses then.
        first: who left, or was to leave, first up to now.
        patient: whether to overlook a node that leaves at once, which rounding may do again and again.
        k: coefficients.

    Returns:
        Who leaves first.
    """
    leave_at, listed = memory[LEAVE_AT], memory[WORK]
    outlook = look_ahead(clock, now, until, end, k)
    suspects = look_at_run(memory, low, high, outlook) if anew else look_at_all(memory, outlook)
    time, node, known = until, -1, first.known
    for j in range(suspects):
        i = int(listed[j])
        sliding, limits = memory[SLIP, i] != STUCK, 1
        p, q_f, q_r = memory[HOLD, i], memory[HOLD_F, i], memory[HOLD_R, i]
        if not sliding:
            p, limits = k.backward + p, 2
        for _ in range(limits):
            at = exit_time(p, q_f, q_r, sliding, clock, now, until, end, patient, k.times, k.tolerance)
            leave_at[i] = min(leave_at[i], at)
            p, q_f, q_r = k.forward + k.backward - p, -q_f, -q_r  # the distance to the other limit
        if leave_at[i] < time:
            time, node = leave_at[i], i
        known += int(leave_at[i] < until)
    has_left = low <= first.node <= high
    if has_left and first.known > 1:  # others may be waiting elsewhere
        time, node = _earliest(leave_at, until)
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
def switch(memory: Memory, node: int, now: Response, k: Coefficients) -> None:
    """Stop a sliding node, or let a stuck one go in the direction in which it is overloaded.

    With the last stuck node gone, nothing would resist rigid motion: the body jumps to the velocity at which
    the slowest node that slides the other way sticks. (Unless friction balances: see `exact.cross_decision`.)
    """
    u, slip, last = memory[ORIGIN], memory[SLIP], memory.shape[1] - 1
    if slip[node] != STUCK:
        u[node] = position(memory, node, now)
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
            distance = abs(_w(memory, i, now) - position(memory, i, now))
            if distance < best:
                slowest, best = i, distance
    if slowest >= 0:
        u[slowest] = position(memory, slowest, now)
        slip[slowest] = STUCK
        slip[node] = direction


@inner_kernel
def _w(memory: Memory, i: int, now: Response) -> float:
    """What node i relaxes towards; where it is, if it is stuck."""
    return float(memory[W, i] + memory[W_F, i] * now.e_f + memory[W_R, i] * now.r_f)
