"""The coupled crawler from event to event, without a time step: exact to rounding.

While no neuron spikes, no muscle crosses its limiter and no node starts or stops sliding, everything has
a closed form. Muscle forces are a + b e_f + d r_f (see response.py). On the nodes S that slide, the force
w = c du/dt + k u obeys the balance

    A_SS w_S = (B f - friction)_S - A_S,stuck u_stuck,

so w is such a sum too, and each displacement relaxes towards its w with time constant c / k. The friction
that holds a stuck node, and the velocity of a sliding one, decide when the next event is: both are sums that,
up to a positive factor, rise or fall with at most one turn, so that the first moment at which one leaves its
allowed range is bracketed surely and found by Newton's method.

An event concerns one run of sliding nodes and the stuck ones beside it. So all times count from the start of
the decision, and drives, forces and displacements stand in the state as what they *would have been then* for
their present course: an event changes only those that change course.
"""

import numpy as np
from numpy.typing import NDArray

from crawler_bench.physics.body import FORWARD, STUCK
from crawler_bench.physics.coefficients import Coefficients
from crawler_bench.physics.compilation import inner_kernel, step_kernel
from crawler_bench.physics.events import (
    LEAVE_AT,
    LIMIT_AT,
    NET,
    NET_F,
    NET_R,
    PIVOT,
    SPIKE_AT,
    W_F,
    W_R,
    W,
    switch,
    watch,
)
from crawler_bench.physics.excitation import (
    delay_excitation,
    due,
    excite,
    parts,
    schedule_limits,
    schedule_spikes,
)
from crawler_bench.physics.layout import DISPLACEMENT, DRIVE, FORCE, NEURON, SLIP, VELOCITY
from crawler_bench.physics.muscle import flush
from crawler_bench.physics.response import START, Response, respond

Rows = NDArray[np.float64]

MOST_INTERVALS = 200  # for each node in 1 tau; in crawls there is about one for the whole body


@step_kernel
def cross_decision(state: Rows, work: Rows, action: int, k: Coefficients) -> bool:
    """Advance the crawler by one decision interval with one neuron ON, from event to event.

    Args:
        state: (6, N + 1), changed in place.
        work: (10 or more, N + 1) scratch.
        action: the neuron that is ON.
        k: coefficients.

    Returns:
        False if it cannot. Where friction may balance with every node sliding, or all but one at its limit,
        rigid motion is free and no event tells what happens; and events without end are given up.
    """
    u, slip, tail = state[DISPLACEMENT], state[SLIP], state.shape[1] - 1
    other = tail if action == 0 else action
    next_spike = schedule_spikes(state[NEURON], work[SPIKE_AT], action, other, k)
    next_limit = schedule_limits(state[DRIVE], work[LIMIT_AT], k.tau_m)
    excitation = min(next_spike, next_limit)
    clock, until, end, intervals, idle = 0.0, k.decision, k.end, 0, 0
    _set_course(state, work, 0, tail, START, k)
    watch(u, slip, work, 0, tail, clock, START, until, end, False, k)
    while True:
        intervals += 1
        if intervals > MOST_INTERVALS * (tail + 1) * (1.0 + k.decision):
            return False
        if k.may_balance and _stuck_nodes(slip) <= 1:
            return False
        before = clock
        clock, node = _earliest(work[LEAVE_AT], min(excitation, until))
        if node < 0 and excitation >= until:
            break
        now = respond(clock, k.times)
        if clock > k.longest:  # count anew from here; the event comes next
            _finish(state, work, now, k)
            delay_excitation(work, -clock)
            excitation, until = excitation - clock, until - clock
            clock, now, end, low, high = 0.0, START, respond(until, k.times), 0, tail
        elif node >= 0:
            low, high = _reach(slip, max(node - 1, 0), min(node + 1, tail))
            _settle(u, slip, work, low, high, now)
            switch(u, slip, work, node, now, k)
        else:
            muscle = due(work, clock)
            low, high = _reach(slip, max(muscle - 1, 0), max(muscle, 1))
            _settle(u, slip, work, low, high, now)
            excite(state, work, muscle, clock, now, muscle == action or muscle == other, k)
            excitation = min(_earliest(work[SPIKE_AT], np.inf)[0], _earliest(work[LIMIT_AT], np.inf)[0])
        idle = idle + 1 if clock == before else 0
        _set_course(state, work, low, high, now, k)
        watch(u, slip, work, low, high, clock, now, until, end, idle > 2 * tail, k)
    _finish(state, work, end, k)
    return True


@inner_kernel
def _stuck_nodes(slip: Rows) -> int:
    count = 0
    for i in range(slip.size):
        count += int(slip[i] == STUCK)
    return count


@inner_kernel
def _earliest(times: Rows, limit: float) -> tuple[float, int]:
    """The earliest time before `limit` and where it stands; `limit` and -1 if there is none."""
    first, where = limit, -1
    for i in range(times.size):
        if times[i] < first:
            first, where = times[i], i
    return first, where


@inner_kernel
def _reach(slip: Rows, low: int, high: int) -> tuple[int, int]:
    """The nodes from `low` to `high` and those that slide next to them, up to a stuck node on either side."""
    while low > 0 and slip[low] != STUCK:
        low -= 1
    while high < slip.size - 1 and slip[high] != STUCK:
        high += 1
    return low, high


@inner_kernel
def _set_course(state: Rows, work: Rows, low: int, high: int, now: Response, k: Coefficients) -> None:
    """Find w of the nodes from `low` to `high` by the Thomas algorithm; let displacements follow it."""
    u, slip = state[DISPLACEMENT], state[SLIP]
    w, w_f, w_r, pivot = work[W], work[W_F], work[W_R], work[PIVOT]
    _eliminate(u, slip, state[DRIVE], state[FORCE], work, low, high, k)
    after, after_f, after_r = 0.0, 0.0, 0.0  # w of node i + 1
    for i in range(high, low - 1, -1):
        if slip[i] != STUCK:
            w[i] += pivot[i] * after
            w_f[i] += pivot[i] * after_f
            w_r[i] += pivot[i] * after_r
            u[i] = (u[i] - w[i] * (1.0 - now.e_c) - w_f[i] * now.s_f - w_r[i] * now.s_r) / now.e_c
        after, after_f, after_r = w[i], w_f[i], w_r[i]


@inner_kernel
def _eliminate(
    u: Rows, slip: Rows, F: Rows, f: Rows, work: Rows, low: int, high: int, k: Coefficients
) -> None:
    """Write the net muscle force on each node, B f; do the forward half of the Thomas algorithm for w.

    One sweep that carries what it needs from node to node: reading back what has just been written, one node
    further on, would make the processor wait.
    """
    last = u.size - 1
    net, net_f, net_r, limit_at = work[NET], work[NET_F], work[NET_R], work[LIMIT_AT]
    w, w_f, w_r, pivot = work[W], work[W_F], work[W_R], work[PIVOT]
    head, head_f, head_r = parts(F[0], f[0], limit_at[0], k.force_max)
    if low == 0:
        own, own_f, own_r = k.pull_on_head * head, k.pull_on_head * head_f, k.pull_on_head * head_r
    else:
        own, own_f, own_r = parts(F[low], f[low], limit_at[low], k.force_max)
    above, above_f, above_r, taken = 0.0, 0.0, 0.0, 0.0  # what row i - 1 adds, and takes off the diagonal
    for i in range(low, high + 1):
        next_, next_f, next_r = 0.0, 0.0, 0.0
        if i < last:
            next_, next_f, next_r = parts(F[i + 1], f[i + 1], limit_at[i + 1], k.force_max)
        pull, pull_f, pull_r = own - next_, own_f - next_f, own_r - next_r
        if i == 1:
            pull, pull_f = pull + k.pull_on_neck * head, pull_f + k.pull_on_neck * head_f
            pull_r += k.pull_on_neck * head_r
        net[i], net_f[i], net_r[i] = pull, pull_f, pull_r
        own, own_f, own_r = next_, next_f, next_r
        if slip[i] == STUCK:
            above, above_f, above_r, taken = u[i], 0.0, 0.0, 0.0
        else:
            degree = 1.0 if i == 0 or i == last else 2.0
            friction = k.forward if slip[i] == FORWARD else -k.backward
            taken = 1.0 / (degree - taken)
            above = taken * (pull - friction + above)
            above_f, above_r = taken * (pull_f + above_f), taken * (pull_r + above_r)
            pivot[i] = taken
        w[i], w_f[i], w_r[i] = above, above_f, above_r  # on a stuck node w is u


@inner_kernel
def _settle(u: Rows, slip: Rows, work: Rows, low: int, high: int, now: Response) -> None:
    """Put the displacements from node `low` to `high` where they are now."""
    w, w_f, w_r = work[W], work[W_F], work[W_R]
    for i in range(low, high + 1):
        if slip[i] != STUCK:
            u[i] = u[i] * now.e_c + w[i] * (1.0 - now.e_c) + w_f[i] * now.s_f + w_r[i] * now.s_r


@inner_kernel
def _finish(state: Rows, work: Rows, end: Response, k: Coefficients) -> None:
    """Put muscles and body where they are at the time of `end`, and note the velocities."""
    u, v, slip, F, f = state[DISPLACEMENT], state[VELOCITY], state[SLIP], state[DRIVE], state[FORCE]
    w, w_f, w_r, limit_at = work[W], work[W_F], work[W_R], work[LIMIT_AT]
    limited_gain, gain = k.force_max * (1.0 - end.e_f), k.force_max * end.r_f
    for i in range(u.size):  # without branches, so that it is done for several muscles at a time
        pull = limited_gain if limit_at[i] < np.inf else gain * F[i]
        f[i] = flush(f[i] * end.e_f + pull)
        F[i] = flush(F[i] * end.e_m)
    _settle(u, slip, work, 0, u.size - 1, end)
    for i in range(u.size):
        moving = w[i] + w_f[i] * end.e_f + w_r[i] * end.r_f - u[i]
        v[i] = moving * k.times.rate_c if slip[i] != STUCK else 0.0
