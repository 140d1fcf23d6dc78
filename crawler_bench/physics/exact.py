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

from crawler_bench.physics.body import BACKWARD, FORWARD, STUCK
from crawler_bench.physics.coefficients import Coefficients
from crawler_bench.physics.compilation import inner_kernel, step_kernel
from crawler_bench.physics.layout import DISPLACEMENT, DRIVE, FORCE, NEURON, SLIP, VELOCITY
from crawler_bench.physics.neuron import first_spike, neuron_after
from crawler_bench.physics.response import Response, respond

# Rows of the workspace: net muscle force and w, each as its parts that are constant, go as e_f, go as r_f.
NET, NET_F, NET_R, W, W_F, W_R, PIVOT, SPIKE_AT, LIMIT_AT = range(9)
_PASSES = 100
_QUADRATIC = 1e-2  # safety on the error of a Newton step, which is about its square


@step_kernel
def cross_decision(
    state: NDArray[np.float64], work: NDArray[np.float64], action: int, k: Coefficients
) -> bool:
    """Advance the crawler by one decision interval with one neuron ON, from event to event.

    Args:
        state: (6, N + 1), changed in place.
        work: (15, N + 1) scratch.
        action: the neuron that is ON.
        k: coefficients.

    Returns:
        False if it cannot: friction may balance with every node sliding, or all but one at its limit, and
        leaves rigid motion free; then no event tells what happens.
    """
    _schedule(state, work, action, k)
    clock, idle = 0.0, 0
    while clock < k.decision:
        until = k.decision
        for i in range(state.shape[1]):
            until = min(until, work[SPIKE_AT, i], work[LIMIT_AT, i])
        span = until - clock
        crossed = _cross_interval(state, work, span, idle, k)
        if k.may_balance and _stuck_nodes(state[SLIP]) <= 1:
            return False
        idle = idle + 1 if crossed == 0.0 else 0
        if crossed < span:
            clock += crossed
        else:
            clock = until
            _excite_muscles(state, work, clock, action, k)
    return True


@inner_kernel
def _stuck_nodes(slip: NDArray[np.float64]) -> int:
    count = 0
    for i in range(slip.size):
        count += int(slip[i] == STUCK)
    return count


@inner_kernel
def _schedule(state: NDArray[np.float64], work: NDArray[np.float64], action: int, k: Coefficients) -> None:
    """Move the neurons to the end of the decision; note when each spikes first, when each limiter opens."""
    tail = state.shape[1] - 1
    V, F = state[NEURON], state[DRIVE]
    for i in range(tail + 1):
        on = i == action or (i == tail and action == 0)
        spike = first_spike(V[i], on, k.neuron_rate, k.decision, k.spike_at_pi)
        work[SPIKE_AT, i] = spike if spike < k.decision else np.inf
        V[i] = neuron_after(V[i], on, k.neuron_rate * k.decision, k.sin_rate_decision, k.cos_rate_decision)
        work[LIMIT_AT, i] = k.tau_m * math.log(F[i]) if F[i] > 1.0 else np.inf


@inner_kernel
def _excite_muscles(
    state: NDArray[np.float64], work: NDArray[np.float64], clock: float, action: int, k: Coefficients
) -> None:
    """Apply the spikes and limiter openings that are due."""
    F = state[DRIVE]
    for i in range(F.size):
        if work[LIMIT_AT, i] <= clock:
            F[i] = 1.0
            work[LIMIT_AT, i] = np.inf
        if work[SPIKE_AT, i] <= clock:
            F[i] += k.spike_gain
            if F[i] > 1.0:
                work[LIMIT_AT, i] = clock + k.tau_m * math.log(F[i])
            on = i == action or (i == F.size - 1 and action == 0)
            again = work[SPIKE_AT, i] + math.pi / k.neuron_rate if on else np.inf
            work[SPIKE_AT, i] = again if again < k.decision else np.inf


@inner_kernel
def _cross_interval(
    state: NDArray[np.float64], work: NDArray[np.float64], span: float, idle: int, k: Coefficients
) -> float:
    """Advance muscles and body until a node starts or stops sliding, or to the end of the interval.

    Args:
        state: (6, N + 1), changed in place; the slip state of the node concerned is switched.
        work: (15, N + 1) scratch.
        span: length of the interval; no spike or limiter crossing lies inside.
        idle: number of calls before this one that crossed no time, a sign of rounding at a border.
        k: coefficients.

    Returns:
        The time crossed, at most span.
    """
    u, slip = state[DISPLACEMENT], state[SLIP]
    _split_net_force(state[DRIVE], state[FORCE], work, k)
    _solve_sliding(u, slip, work, k)
    end = k.end if span == k.decision else respond(span, k.times)
    time, node = _first_event(u, slip, work, span, end, idle > 2 * u.size, k)
    if node >= 0:
        end = respond(time, k.times)
    if time > 0.0:
        _relax(state, work, end, k)
    if node >= 0:
        _switch(u, slip, work, node, end, k)
        if slip[node] == STUCK:
            state[VELOCITY, node] = 0.0
    return time


@inner_kernel
def _split_net_force(
    F: NDArray[np.float64], f: NDArray[np.float64], work: NDArray[np.float64], k: Coefficients
) -> None:
    """Write the three parts of the net muscle force on each node, B f."""
    previous, previous_f, previous_r = 0.0, 0.0, 0.0  # what muscle j pulls node j - 1 back with
    for j in range(F.size - 1, -1, -1):
        limited = F[j] > 1.0
        constant = k.force_max if limited else 0.0
        going_f, going_r = f[j] - constant, 0.0 if limited else k.force_max * F[j]
        share = 1.0 if j > 0 else k.pull_on_head
        work[NET, j] = share * constant - previous
        work[NET_F, j] = share * going_f - previous_f
        work[NET_R, j] = share * going_r - previous_r
        previous, previous_f, previous_r = constant, going_f, going_r
    work[NET, 1] += k.pull_on_neck * previous
    work[NET_F, 1] += k.pull_on_neck * previous_f
    work[NET_R, 1] += k.pull_on_neck * previous_r


@inner_kernel
def _solve_sliding(
    u: NDArray[np.float64], slip: NDArray[np.float64], work: NDArray[np.float64], k: Coefficients
) -> None:
    """Solve for the three parts of w on the sliding nodes; on a stuck node w is u."""
    last = u.size - 1
    above, above_f, above_r, taken = 0.0, 0.0, 0.0, 0.0  # what the row above adds, and takes off the diagonal
    for i in range(last + 1):
        if slip[i] == STUCK:
            work[W, i], work[W_F, i], work[W_R, i] = u[i], 0.0, 0.0
            above, above_f, above_r, taken = u[i], 0.0, 0.0, 0.0
        else:
            degree = 1.0 if i == 0 or i == last else 2.0
            friction = k.forward if slip[i] == FORWARD else -k.backward
            taken = 1.0 / (degree - taken)
            above = taken * (work[NET, i] - friction + above)
            above_f = taken * (work[NET_F, i] + above_f)
            above_r = taken * (work[NET_R, i] + above_r)
            work[W, i], work[W_F, i], work[W_R, i] = above, above_f, above_r
            work[PIVOT, i] = taken
    for i in range(last - 1, -1, -1):
        if slip[i] != STUCK:
            pivot = work[PIVOT, i]
            work[W, i] += pivot * work[W, i + 1]
            work[W_F, i] += pivot * work[W_F, i + 1]
            work[W_R, i] += pivot * work[W_R, i + 1]


@inner_kernel
def _relax(state: NDArray[np.float64], work: NDArray[np.float64], now: Response, k: Coefficients) -> None:
    """Advance muscles, and displacements and velocities of sliding nodes, to the time of `now`."""
    u, v, slip, F, f = state[DISPLACEMENT], state[VELOCITY], state[SLIP], state[DRIVE], state[FORCE]
    for i in range(u.size):
        if F[i] > 1.0:
            f[i] = k.force_max + (f[i] - k.force_max) * now.e_f
        else:
            f[i] = f[i] * now.e_f + k.force_max * F[i] * now.r_f
        F[i] *= now.e_m
        if f[i] < k.negligible:
            f[i] = 0.0
        if F[i] < k.negligible:
            F[i] = 0.0
        if slip[i] == STUCK:
            v[i] = 0.0
        else:
            w, w_f, w_r = work[W, i], work[W_F, i], work[W_R, i]
            u[i] = u[i] * now.e_c + w * (1.0 - now.e_c) + w_f * now.s_f + w_r * now.s_r
            v[i] = (w + w_f * now.e_f + w_r * now.r_f - u[i]) * k.times.rate_c


@inner_kernel
def _first_event(
    u: NDArray[np.float64],
    slip: NDArray[np.float64],
    work: NDArray[np.float64],
    span: float,
    end: Response,
    patient: bool,
    k: Coefficients,
) -> tuple[float, int]:
    """Find when the first node leaves its state, and which: (span, -1) if none does before `span`."""
    first, node = span, -1
    r_highest = end.r_f if span <= k.peak_time else k.peak
    last = u.size - 1
    for i in range(last + 1):
        if slip[i] != STUCK:
            sign = slip[i]
            time = _exit_time(
                sign * (work[W, i] - u[i]), sign * work[W_F, i], sign * work[W_R, i],
                True, first, end, patient, k,
            )  # fmt: skip
        else:
            constant, going_f, going_r = work[NET, i], work[NET_F, i], work[NET_R, i]
            if i > 0:
                constant += work[W, i - 1] - u[i]
                going_f += work[W_F, i - 1]
                going_r += work[W_R, i - 1]
            if i < last:
                constant += work[W, i + 1] - u[i]
                going_f += work[W_F, i + 1]
                going_r += work[W_R, i + 1]
            time = np.inf
            highest = constant + max(going_f, going_f * end.e_f) + max(0.0, going_r * r_highest)
            lowest = constant + min(going_f, going_f * end.e_f) + min(0.0, going_r * r_highest)
            if highest > k.forward:
                time = _exit_time(
                    k.forward - constant, -going_f, -going_r, False, first, end, patient, k
                )  # fmt: skip
            if lowest < -k.backward:
                time = min(time, _exit_time(
                    k.backward + constant, going_f, going_r, False, first, end, patient, k
                ))  # fmt: skip
        if time < first or (time == first and node < 0 and time < span):
            first, node = time, i
            end = respond(first, k.times)
            if first == 0.0:
                break
    return first, node


@inner_kernel
def _height(p: float, q_f: float, q_r: float, sliding: bool, now: Response) -> float:
    """Distance of a node to the border of its state: of its holding force to the limit, of c v to 0."""
    if sliding:
        return p * now.e_c + q_f * (now.e_f - now.s_f) + q_r * (now.r_f - now.s_r)
    return p + q_f * now.e_f + q_r * now.r_f


@inner_kernel
def _slope(q_f: float, q_r: float, now: Response, rate_f: float) -> float:
    """Rate of change of the force on a node.

    It is that of a stuck node's height and, up to a positive factor, of exp(t / c) times a sliding one's.
    """
    return (q_r * (now.e_m - now.r_f) - q_f * now.e_f) * rate_f


@step_kernel
def _exit_time(
    p: float,
    q_f: float,
    q_r: float,
    sliding: bool,
    span: float,
    end: Response,
    patient: bool,
    k: Coefficients,
) -> float:
    """First time within `span` at which a node's height falls below 0; infinity if it does not.

    The height (for a sliding node: times exp(t / c)) turns at most once, where the slope is 0.

    Args:
        p: constant part of the height (of a sliding node: the part that goes as e_c).
        q_f: part that goes as e_f.
        q_r: part that goes as r_f.
        sliding: whether the node slides.
        span: time to look at.
        end: the responses at `span`.
        patient: whether to overlook a node that leaves at once, which rounding may do again and again.
        k: coefficients.
    """
    start, slope = p + q_f, q_r - q_f
    at_end, slope_at_end = _height(p, q_f, q_r, sliding, end), _slope(q_f, q_r, end, k.times.rate_f)
    if start <= k.tolerance and slope < 0.0:  # at the border, on its way out
        if patient:
            return np.inf
        leaves = at_end < -k.tolerance
        if not leaves and slope_at_end > 0.0:
            turn = _turning_time(q_f, q_r, span, k)
            now = respond(turn, k.times)
            leaves = _height(p, q_f, q_r, sliding, now) < -k.tolerance
        return 0.0 if leaves else np.inf
    if at_end < -k.tolerance:
        low = 0.0
        if start <= k.tolerance:  # at the border, on its way in: it leaves after the turn
            low = _turning_time(q_f, q_r, span, k)
        guess = span * start / (start - at_end) if low == 0.0 else 0.5 * (low + span)
        return _root(p, q_f, q_r, sliding, low, span, guess, k)
    if slope < 0.0 and slope_at_end > 0.0:
        turn = _turning_time(q_f, q_r, span, k)
        now = respond(turn, k.times)
        if _height(p, q_f, q_r, sliding, now) < -k.tolerance:
            return _root(p, q_f, q_r, sliding, 0.0, turn, 0.5 * turn, k)
    return np.inf


@step_kernel
def _turning_time(q_f: float, q_r: float, span: float, k: Coefficients) -> float:
    """Where the slope changes sign within `span`; `span` if it does not.

    Divided by e_f it is monotone in time, so that bisection cannot miss.
    """
    low, high = 0.0, span
    rising = q_r - q_f < 0.0
    time = 0.5 * span
    for _ in range(_PASSES):
        slope = _slope(q_f, q_r, respond(time, k.times), k.times.rate_f)
        if (slope > 0.0) == rising:
            high = time
        else:
            low = time
        middle = 0.5 * (low + high)
        if middle == time or high - low < k.tolerance:
            break
        time = middle
    return time


@step_kernel
def _root(
    p: float, q_f: float, q_r: float, sliding: bool, low: float, high: float, guess: float, k: Coefficients
) -> float:
    """Where the height falls through 0 between `low`, where it is positive, and `high`, where it is not."""
    time = guess
    for _ in range(_PASSES):
        now = respond(time, k.times)
        height = _height(p, q_f, q_r, sliding, now)
        slope = _slope(q_f, q_r, now, k.times.rate_f)
        if sliding:
            slope -= height * k.times.rate_c
        if height > 0.0:
            low = time
        else:
            high = time
        better = time - height / slope if slope != 0.0 else low
        if not low <= better <= high:
            better = 0.5 * (low + high)
        elif (better - time) ** 2 <= k.tolerance * _QUADRATIC:  # the next correction is of second order
            return better
        if better == time or high - low <= k.tolerance:
            return better
        time = better
    return time


@step_kernel
def _switch(
    u: NDArray[np.float64],
    slip: NDArray[np.float64],
    work: NDArray[np.float64],
    node: int,
    now: Response,
    k: Coefficients,
) -> None:
    """Stop a sliding node, or let a stuck one go in the direction in which it is overloaded.

    With the last stuck node gone, nothing would resist rigid motion: the body jumps to the velocity at which
    the slowest node that slides the other way sticks. (Unless friction balances: see `cross_decision`.)
    """
    if slip[node] != STUCK:
        slip[node] = STUCK
        return
    constant, last = work[NET, node], u.size - 1
    pull = constant + work[NET_F, node] * now.e_f + work[NET_R, node] * now.r_f
    for neighbour in (node - 1, node + 1):
        if 0 <= neighbour <= last:
            w = work[W, neighbour] + work[W_F, neighbour] * now.e_f + work[W_R, neighbour] * now.r_f
            pull += w - u[node]
    direction = FORWARD if pull > 0.5 * (k.forward - k.backward) else BACKWARD
    slowest, best = -1, np.inf
    for i in range(last + 1):
        if k.may_balance or (i != node and slip[i] == STUCK):
            slip[node] = direction
            return
        if slip[i] == -direction:
            w = work[W, i] + work[W_F, i] * now.e_f + work[W_R, i] * now.r_f
            if abs(w - u[i]) < best:
                slowest, best = i, abs(w - u[i])
    if slowest >= 0:
        slip[slowest] = STUCK
        slip[node] = direction
