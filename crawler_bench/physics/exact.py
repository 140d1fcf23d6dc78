"""The coupled crawler from event to event, without a time step: exact to rounding.

While no neuron spikes, no muscle crosses its limiter and no node starts or stops sliding, everything has
a closed form. Muscle forces are a + b e_f + d r_f (see response.py). On the nodes S that slide, the force
w = c du/dt + k u obeys the balance

    A_SS w_S = (B f - friction)_S - A_S,stuck u_stuck,

so w is such a sum too, and each displacement relaxes towards its w with time constant c / k. The friction
that holds a stuck node, and the velocity of a sliding one, decide when the next event is: both are sums that,
up to a positive factor, rise or fall with at most one turn, so that the first moment at which one leaves its
allowed range is bracketed surely and found by Newton's method.
"""

import math

import numpy as np
from numpy.typing import NDArray

from crawler_bench.physics.body import FORWARD, STUCK
from crawler_bench.physics.coefficients import Coefficients
from crawler_bench.physics.compilation import inner_kernel, step_kernel
from crawler_bench.physics.events import (
    LIMIT_AT,
    NET,
    NET_F,
    NET_R,
    PIVOT,
    SPIKE_AT,
    W_F,
    W_R,
    W,
    first_event,
    may_be_overloaded,
    surely_slides,
    switch,
)
from crawler_bench.physics.layout import DISPLACEMENT, DRIVE, FORCE, NEURON, SLIP, VELOCITY
from crawler_bench.physics.muscle import flush
from crawler_bench.physics.neuron import first_spike, neuron_after, step_neurons_off
from crawler_bench.physics.response import Response, respond

Rows = NDArray[np.float64]

MOST_INTERVALS = 200  # for each node in 1 tau; in crawls there is about one for the whole body


@step_kernel
def cross_decision(state: Rows, work: Rows, action: int, k: Coefficients) -> bool:
    """Advance the crawler by one decision interval with one neuron ON, from event to event.

    Args:
        state: (6, N + 1), changed in place.
        work: (9 or more, N + 1) scratch.
        action: the neuron that is ON.
        k: coefficients.

    Returns:
        False if it cannot. Where friction may balance with every node sliding, or all but one at its limit,
        rigid motion is free and no event tells what happens; and events without end are given up.
    """
    tail = state.shape[1] - 1
    other = tail if action == 0 else action
    next_spike = _schedule_spikes(state[NEURON], work[SPIKE_AT], action, other, k)
    next_limit = _schedule_limits(state[DRIVE], work[LIMIT_AT], k.tau_m)
    clock, idle, intervals = 0.0, 0, 0
    while clock < k.decision:
        intervals += 1
        if intervals > MOST_INTERVALS * state.shape[1] * (1.0 + k.decision):
            return False
        until = min(k.decision, min(next_spike, next_limit))
        span = until - clock
        crossed = _cross_interval(state, work, span, idle > 2 * tail, k)
        if k.may_balance and _stuck_nodes(state[SLIP]) <= 1:
            return False
        idle = idle + 1 if crossed == 0.0 else 0
        if crossed < span:
            clock += crossed
        elif until < k.decision:
            clock = until
            next_spike, next_limit = _excite_muscles(state[DRIVE], work, clock, action, other, k)
        else:
            clock = until
    return True


@inner_kernel
def _stuck_nodes(slip: Rows) -> int:
    count = 0
    for i in range(slip.size):
        count += int(slip[i] == STUCK)
    return count


@inner_kernel
def _schedule_spikes(V: Rows, spike_at: Rows, action: int, other: int, k: Coefficients) -> float:
    """Move the neurons to the end of the decision; note when each spikes first, return the earliest time."""
    earliest = step_neurons_off(V, spike_at, action, other, k.decision, k.neuron_rate, k.spike_at_pi)
    turn = k.neuron_rate * k.decision
    for i in range(1 + int(other != action)):
        on = other if i else action
        after = neuron_after(V[on], True, turn, k.sin_rate_decision, k.cos_rate_decision)
        # Without a spike V has risen; where it may have gone all the way round, it is asked for in any case.
        if after < V[on] or turn > 1.5 or not k.spike_at_pi:
            spike_at[on] = first_spike(V[on], True, k.neuron_rate, k.decision, k.spike_at_pi)
            earliest = min(earliest, spike_at[on])
        V[on] = after
    return earliest


@inner_kernel
def _schedule_limits(F: Rows, limit_at: Rows, tau_m: float) -> float:
    """Note when each drive falls through 1; return the earliest time."""
    earliest = np.inf
    for i in range(F.size):
        limit_at[i] = tau_m * math.log(F[i]) if F[i] > 1.0 else np.inf
        earliest = min(earliest, limit_at[i])
    return earliest


@inner_kernel
def _excite_muscles(
    F: Rows, work: Rows, clock: float, action: int, other: int, k: Coefficients
) -> tuple[float, float]:
    """Apply the spikes and falls through the limiter that are due; return when the next of each is."""
    spike_at, limit_at = work[SPIKE_AT], work[LIMIT_AT]
    next_spike, next_limit = np.inf, np.inf
    for i in range(F.size):
        if limit_at[i] <= clock:
            F[i] = 1.0
            limit_at[i] = np.inf
        if spike_at[i] <= clock:
            F[i] += k.spike_gain
            if F[i] > 1.0:
                limit_at[i] = clock + k.tau_m * math.log(F[i])
            spike_at[i] = spike_at[i] + math.pi / k.neuron_rate if i == action or i == other else np.inf
        next_spike, next_limit = min(next_spike, spike_at[i]), min(next_limit, limit_at[i])
    return next_spike, next_limit


@inner_kernel
def _cross_interval(state: Rows, work: Rows, span: float, patient: bool, k: Coefficients) -> float:
    """Advance muscles and body until a node starts or stops sliding, or to the end of the interval.

    Args:
        state: (6, N + 1), changed in place; the slip state of the node concerned is switched.
        work: (9 or more, N + 1) scratch.
        span: length of the interval; no spike or limiter crossing lies inside.
        patient: whether to overlook nodes that leave their state at once, see `events.exit_time`.
        k: coefficients.

    Returns:
        The time crossed, at most span.
    """
    u, slip = state[DISPLACEMENT], state[SLIP]
    _eliminate(u, slip, state[DRIVE], state[FORCE], work, k)
    end = k.end if span == k.decision else respond(span, k.times)
    time, node = span, -1
    if not _substitute(u, slip, work, span, end, k):
        time, node = first_event(u, slip, work, span, patient, k)
    if node >= 0:
        end = respond(time, k.times)
    if time > 0.0:
        _relax_muscles(state[DRIVE], state[FORCE], end, k.force_max)
        _relax_body(u, state[VELOCITY], slip, work, end, k.times.rate_c)
    if node >= 0:
        switch(u, slip, work, node, end, k)
        if slip[node] == STUCK:
            state[VELOCITY, node] = 0.0
    return time


@inner_kernel
def _parts(F: float, f: float, force_max: float) -> tuple[float, float, float]:
    """A muscle's force as its parts that are constant, go as e_f, go as r_f."""
    if F > 1.0:
        return force_max, f - force_max, 0.0
    return 0.0, f, force_max * F


@inner_kernel
def _eliminate(u: Rows, slip: Rows, F: Rows, f: Rows, work: Rows, k: Coefficients) -> None:
    """Write the net muscle force on each node, B f; do the forward half of the Thomas algorithm for w.

    One sweep that carries what it needs from node to node: reading back what has just been written, one node
    further on, would make the processor wait.
    """
    last = u.size - 1
    net, net_f, net_r = work[NET], work[NET_F], work[NET_R]
    w, w_f, w_r, pivot = work[W], work[W_F], work[W_R], work[PIVOT]
    head, head_f, head_r = _parts(F[0], f[0], k.force_max)
    own, own_f, own_r = k.pull_on_head * head, k.pull_on_head * head_f, k.pull_on_head * head_r
    above, above_f, above_r, taken = 0.0, 0.0, 0.0, 0.0  # what row i - 1 adds, and takes off the diagonal
    for i in range(last + 1):
        next_, next_f, next_r = _parts(F[i + 1], f[i + 1], k.force_max) if i < last else (0.0, 0.0, 0.0)
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
def _substitute(u: Rows, slip: Rows, work: Rows, span: float, end: Response, k: Coefficients) -> bool:
    """Do the backward half; say whether surely no node leaves its state within `span`."""
    net, net_f, net_r = work[NET], work[NET_F], work[NET_R]
    w, w_f, w_r, pivot = work[W], work[W_F], work[W_R], work[PIVOT]
    r_highest = k.peak if span > k.peak_time else end.r_f
    last, quiet = u.size - 1, True
    after, after_f, after_r = 0.0, 0.0, 0.0  # w of node i + 1
    beyond, beyond_f, beyond_r = (
        u[last],
        0.0,
        0.0,
    )  # w of node i + 2; behind the tail, as if at rest beside it
    for i in range(last, -2, -1):
        own, own_f, own_r = (w[i], w_f[i], w_r[i]) if i >= 0 else (u[0], 0.0, 0.0)
        if i >= 0 and slip[i] != STUCK and i < last:
            own, own_f = own + pivot[i] * after, own_f + pivot[i] * after_f
            own_r += pivot[i] * after_r
            w[i], w_f[i], w_r[i] = own, own_f, own_r
        if i >= 0 and slip[i] != STUCK:
            sign = slip[i]
            quiet &= surely_slides(sign * (own - u[i]), sign * own_f, sign * own_r, span, end, k)
        if i < last and slip[i + 1] == STUCK:
            held = net[i + 1] + (own + beyond - 2.0 * u[i + 1])
            held_f, held_r = net_f[i + 1] + own_f + beyond_f, net_r[i + 1] + own_r + beyond_r
            quiet &= not may_be_overloaded(held, held_f, held_r, end.e_f, r_highest, k)
        if i < last:
            beyond, beyond_f, beyond_r = after, after_f, after_r
        after, after_f, after_r = own, own_f, own_r
    return quiet


@inner_kernel
def _relax_muscles(F: Rows, f: Rows, now: Response, force_max: float) -> None:
    """Advance drives and forces to the time of `now`."""
    limited_gain, gain = force_max * (1.0 - now.e_f), force_max * now.r_f
    for i in range(F.size):  # without branches, so that it is done for several muscles at a time
        pull = limited_gain if F[i] > 1.0 else gain * F[i]
        f[i] = flush(f[i] * now.e_f + pull)
        F[i] = flush(F[i] * now.e_m)


@inner_kernel
def _relax_body(u: Rows, v: Rows, slip: Rows, work: Rows, now: Response, rate_c: float) -> None:
    """Advance displacements, and velocities, to the time of `now`."""
    w, w_f, w_r = work[W], work[W_F], work[W_R]
    for i in range(u.size):
        if slip[i] == STUCK:
            v[i] = 0.0
        else:
            u[i] = u[i] * now.e_c + w[i] * (1.0 - now.e_c) + w_f[i] * now.s_f + w_r[i] * now.s_r
            v[i] = (w[i] + w_f[i] * now.e_f + w_r[i] * now.r_f - u[i]) * rate_c
