"""The coupled crawler from event to event, without a time step: exact to rounding.

While no neuron spikes, no muscle crosses its limiter and no node starts or stops sliding, everything has
a closed form, the *course* (course.py). The friction that holds a stuck node, and the velocity of a sliding
one, decide when the next event is (events.py, outlook.py, exits.py); spikes and falls through the limiter
are known beforehand (excitation.py).

An event concerns one run of sliding nodes and the stuck ones beside it; the end of a decision concerns no
course at all. So the course is kept from one decision to the next, and a decision in which nothing happens
costs what it takes to say where the body is.
"""

import numpy as np
from numpy.typing import NDArray

from crawler_bench.physics.body import STUCK
from crawler_bench.physics.coefficients import Coefficients
from crawler_bench.physics.compilation import inner_kernel, step_kernel
from crawler_bench.physics.course import arrive, begin_epoch, lay, responses, set_course, settle
from crawler_bench.physics.events import Leaver, switch, watch
from crawler_bench.physics.excitation import due, excite, next_excitation, turn_off, turn_on
from crawler_bench.physics.intrinsics import flat
from crawler_bench.physics.layout import (
    CHARGE,
    CLOCK,
    DISPLACEMENT,
    DRIVE,
    EPOCH,
    FORCE,
    IS_LAID,
    NEURON,
    PHASE,
    PULL,
    PULL_F,
    PULL_R,
    SLIP,
    WORK,
    Memory,
)
from crawler_bench.physics.muscle import flush
from crawler_bench.physics.neuron import tangent
from crawler_bench.physics.response import START, Response, after, respond

MOST_EVENTS = 200  # for each node in 1 tau; in crawls there are a few for the whole body
# What events change of the state at the start of a decision; but for SLIP, rows that follow each other.
_KEPT = (SLIP, CHARGE, PULL, PULL_F, PULL_R)
_BEFORE = WORK + 1
_ROUNDING = 1.0 + 1e-9  # of a sum of decision intervals


@inner_kernel
def cross_decision(memory: Memory, action: int, k: Coefficients) -> bool:
    """Advance the crawler by one decision interval with one neuron ON, from event to event.

    Args:
        memory: (ROWS, N + 1), changed in place; `course.report` writes what the state has become.
        action: the neuron that is ON.
        k: coefficients.

    Returns:
        False if it cannot; the state, but for the velocities that follow from it, is then as before and the
        course is gone. Where friction may balance
        with every node sliding, or all but one at its limit, rigid motion is free and no event tells what
        happens; and events without end are given up.
    """
    epoch, tail = memory[EPOCH], memory.shape[1] - 1
    other = tail if action == 0 else action
    if epoch[IS_LAID] == 0.0:
        lay(memory, k)
    elif epoch[CLOCK] + k.decision > k.horizon * _ROUNDING:
        begin_epoch(memory, epoch[CLOCK], responses(memory), k)
    start = clock = epoch[CLOCK]
    begin = now = responses(memory)
    until, end = clock + k.decision, after(now, k.end)
    q, q_other = turn_on(memory, action, clock, k), 0.0
    if other != action:
        q_other = turn_on(memory, other, clock, k)
    excitation = next_excitation(memory)
    low, high, anew, aligned = 0, tail, False, True
    events, idle = 0, 0
    most = int(MOST_EVENTS * (tail + 1) * (1.0 + k.decision))
    first = Leaver(until, -1, 0)
    while True:
        first = watch(memory, low, high, anew, clock, now, until, end, first, idle > 2 * tail, k)
        node = first.node if first.time < excitation else -1
        before, clock = clock, min(first.time, excitation)
        is_end = clock >= until
        if events == 0 and (k.may_balance or not is_end):
            _keep(memory)
        too_many = not is_end and events > most
        if too_many or (k.may_balance and _stuck_nodes(memory[SLIP]) <= 1):
            _give_up(memory, start, begin, k)
            return False
        if is_end:
            break
        events += 1
        now = respond(clock, k.times)
        if clock > k.longest:  # only where a single decision is longer; the event comes next
            aligned = False
            begin_epoch(memory, clock, now, k)
            excitation, start, until = excitation - clock, start - clock, until - clock
            end = respond(until, k.times)
            first = Leaver(until, -1, 0)
            clock, now, low, high = 0.0, START, 0, tail
        else:
            muscle = due(memory, clock) if node < 0 else 0
            low, high = (muscle - 1, max(muscle, 1)) if node < 0 else (node - 1, min(node + 1, tail))
            low, high = _reach(memory[SLIP], max(low, 0), high)
            if node >= 0:
                switch(memory, node, now, k)
            else:
                excite(memory, muscle, clock, now, muscle == action or muscle == other, k)
                excitation = next_excitation(memory)
            set_course(memory, low, high, node, now, k)
        anew, idle = True, idle + 1 if clock == before else 0
    turn_off(memory, action, q, until, k)
    if other != action:
        turn_off(memory, other, q_other, until, k)
    settle(memory, DISPLACEMENT, end)
    arrive(memory, until, end)
    if not aligned:
        begin_epoch(memory, until, end, k)
    return True


@inner_kernel
def _stuck_nodes(slip: NDArray[np.float64]) -> int:
    count = 0
    for i in range(slip.size):
        count += int(slip[i] == STUCK)
    return count


@inner_kernel
def _reach(slip: NDArray[np.float64], low: int, high: int) -> tuple[int, int]:
    """The nodes from `low` to `high` and those that slide next to them, up to a stuck node on either side."""
    while low > 0 and slip[low] != STUCK:
        low -= 1
    while high < slip.size - 1 and slip[high] != STUCK:
        high += 1
    return low, high


@inner_kernel
def _keep(memory: Memory) -> None:
    """Keep what events change of the state at the start of a decision."""
    nodes, rows = memory.shape[1], flat(memory)
    for n in range(nodes):
        memory[_BEFORE, n] = memory[SLIP, n]
    first, kept = CHARGE * nodes, (_BEFORE + 1) * nodes
    for n in range((len(_KEPT) - 1) * nodes):
        rows[kept + n] = rows[first + n]


@step_kernel
def _give_up(memory: Memory, start: float, begin: Response, k: Coefficients) -> None:
    """Write the state as it was at the start of the decision, without velocities, and forget the course."""
    for i in range(memory.shape[1]):
        for n, row in enumerate(_KEPT):
            memory[row, i] = memory[_BEFORE + n, i]
        force = memory[PULL, i] + memory[PULL_F, i] * begin.e_f + memory[PULL_R, i] * begin.r_f
        memory[FORCE, i] = flush(force)
        memory[DRIVE, i] = flush(memory[CHARGE, i] * begin.e_m)
        memory[NEURON, i] = tangent(memory[PHASE, i] - k.neuron_rate * start)
    memory[EPOCH, IS_LAID] = 0.0
