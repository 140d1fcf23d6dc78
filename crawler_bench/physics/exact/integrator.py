"""The coupled crawler from event to event, without a time step: exact to rounding.

While no neuron spikes, no muscle crosses its limiter and no node starts or stops sliding, everything has
a closed form (trajectory.py). The friction that holds a stuck node, and the velocity of a sliding one, decide
when the next event is (slip_events.py, crossings.py); spikes and falls through the limiter are known
beforehand (spikes.py).

An event concerns one run of sliding nodes and the stuck ones beside it; the end of a decision concerns no
node. So the trajectory is kept from one decision to the next, and a decision in which nothing happens costs
what it takes to say where the body is.
"""

from crawler_bench.physics.body import STUCK
from crawler_bench.physics.coefficients import Coefficients
from crawler_bench.physics.compiled import inline_kernel, inner_kernel
from crawler_bench.physics.crawler import fires_with
from crawler_bench.physics.exact.slip_events import change_slip, find_slip_times, next_slip_event
from crawler_bench.physics.exact.spikes import due_muscle, excite, next_excitation, turn_off, turn_on
from crawler_bench.physics.exact.trajectory import (
    begin_epoch,
    initialize,
    read_clock,
    set_trajectory,
    store_clock,
    write_positions,
    write_state,
)
from crawler_bench.physics.relaxation import START, after, respond
from crawler_bench.physics.state import Clock, Nodes
from crawler_bench.physics.tolerances import MOST_EVENTS, SUM_OF_DECISIONS


@inline_kernel
def cross_decision(nodes: Nodes, clock: Clock, action: int, k: Coefficients) -> bool:
    """Advance the crawler by one decision interval with one neuron ON, from event to event.

    Args:
        nodes: changed in place; `trajectory.write_state` completes the state.
        clock: moved on.
        action: the neuron that is ON, 0 to N - 1, with the tail's when it is the head's [M20, eq. 10].
        k: coefficients.

    Returns:
        False if it cannot; the state is then as before and the trajectory is gone. Where friction may balance
        with every node sliding, or all but one at its limit, rigid motion is free and no event tells what
        happens; and events without end are given up.
    """
    tail = nodes.size - 1
    also_on = fires_with(action, tail)
    if clock.has_trajectory == 0.0:
        initialize(nodes, clock, k)
    elif clock.now.time + k.decision > k.horizon * SUM_OF_DECISIONS:
        begin_epoch(nodes, clock, read_clock(clock), k)
    now = read_clock(clock)
    end = after(now, k.end)
    q = turn_on(nodes[action], now.time, k)
    q_also = turn_on(nodes[also_on], now.time, k) if also_on != action else q
    excitation = next_excitation(nodes)
    slip = find_slip_times(nodes, 0, tail, now, end, False, k)
    events, idle = 0, 0
    most = int(MOST_EVENTS * nodes.size * (1.0 + k.decision))
    in_one_epoch = True
    while True:
        time = min(slip.time, excitation)
        is_end = time >= end.time
        if events == 0 and (k.may_balance or not is_end):
            _keep_state(nodes, clock, k)
        if (not is_end and events > most) or (k.may_balance and _stuck_nodes(nodes) <= 1):
            _give_up(nodes, clock)
            return False
        if is_end:
            break
        events += 1
        idle = idle + 1 if time == now.time else 0
        now = respond(time, k.times)
        if time > k.longest:  # only where a single decision is longer; the event comes next
            in_one_epoch = False
            begin_epoch(nodes, clock, now, k)
            excitation -= time
            end = respond(end.time - time, k.times)
            now, idle = START, 0
            low, high = 0, tail
        else:
            if slip.time < excitation:
                changed = slip.node
                low, high = _reach(nodes, changed - 1, changed + 1)
                change_slip(nodes, changed, now, k)
            else:
                changed, muscle = -1, due_muscle(nodes, time)
                low, high = _reach(nodes, muscle - 1, max(muscle, 1))
                excite(nodes, muscle, now, muscle == action or muscle == also_on, k)
                excitation = next_excitation(nodes)
            set_trajectory(nodes, low, high, changed, now, k)
        find_slip_times(nodes, low, high, now, end, idle > 2 * tail, k)
        slip = next_slip_event(nodes, end)
    turn_off(nodes[action], q, end.time, k)
    if also_on != action:
        turn_off(nodes[also_on], q_also, end.time, k)
    write_positions(nodes, end)
    store_clock(clock, end)
    if not in_one_epoch:
        begin_epoch(nodes, clock, end, k)
    return True


@inline_kernel
def _stuck_nodes(nodes: Nodes) -> int:
    count = 0
    for node in nodes:
        count += int(node.slip == STUCK)
    return count


@inline_kernel
def _reach(nodes: Nodes, low: int, high: int) -> tuple[int, int]:
    """The nodes from `low` to `high` and those that slide next to them, up to a stuck node on either side."""
    low, high = max(low, 0), min(high, nodes.size - 1)
    while low > 0 and nodes[low].slip != STUCK:
        low -= 1
    while high < nodes.size - 1 and nodes[high].slip != STUCK:
        high += 1
    return low, high


@inner_kernel
def _keep_state(nodes: Nodes, clock: Clock, k: Coefficients) -> None:
    """Complete the state at the start of the decision, before an event changes the trajectory."""
    write_state(nodes, clock, k)
    for node in nodes:
        node.slip_before = node.slip


@inner_kernel
def _give_up(nodes: Nodes, clock: Clock) -> None:
    """Go back to the start of the decision and forget the trajectory."""
    for node in nodes:
        node.slip = node.slip_before
    clock.has_trajectory = 0.0
