"""When and how a node of the crawler starts or stops sliding, between two events of the muscles.

A node leaves its state when its *height* falls below 0: the distance of its holding force to a limit while it
is stuck, its velocity in the direction of sliding (times c) while it slides. exact.py has the closed forms.
"""

import math

import numpy as np
from numpy.typing import NDArray

from crawler_bench.physics.body import BACKWARD, FORWARD, STUCK
from crawler_bench.physics.coefficients import Coefficients
from crawler_bench.physics.compilation import inner_kernel, step_kernel
from crawler_bench.physics.response import Relaxation, Response, respond

Rows = NDArray[np.float64]

# Rows of the workspace: net muscle force and w, each as its parts that are constant, go as e_f, go as r_f.
NET, NET_F, NET_R, W, W_F, W_R, PIVOT, SPIKE_AT, LIMIT_AT = range(9)
_PASSES = 100
_QUADRATIC = 1e-2  # safety on the error of a Newton step, which is about its square


@step_kernel
def first_event(
    u: Rows, slip: Rows, work: Rows, span: float, patient: bool, k: Coefficients
) -> tuple[float, int]:
    """Find when the first node leaves its state, and which: (span, -1) if none does before `span`."""
    first, node, last = span, -1, u.size - 1
    for i in range(last + 1):
        if slip[i] != STUCK:
            p, q_f, q_r = slip[i] * (work[W, i] - u[i]), slip[i] * work[W_F, i], slip[i] * work[W_R, i]
            time = exit_time(p, q_f, q_r, True, first, patient, k.times, k.tolerance)
        else:
            held, held_f, held_r = work[NET, i], work[NET_F, i], work[NET_R, i]
            for neighbour in (i - 1, i + 1):
                if 0 <= neighbour <= last:
                    held += work[W, neighbour] - u[i]
                    held_f += work[W_F, neighbour]
                    held_r += work[W_R, neighbour]
            upper, lower = k.forward - held, k.backward + held
            time = exit_time(upper, -held_f, -held_r, False, first, patient, k.times, k.tolerance)
            time = min(time, exit_time(lower, held_f, held_r, False, first, patient, k.times, k.tolerance))
        if time < first:
            first, node = time, i
    return first, node


@inner_kernel
def may_be_overloaded(
    held: float, held_f: float, held_r: float, e_f: float, r_highest: float, k: Coefficients
) -> bool:
    """Whether the holding force may exceed a limit: a bound of each part, without false negatives."""
    at_end, following = held_f * e_f, held_r * r_highest
    highest = held + max(held_f, at_end) + max(0.0, following)
    lowest = held + min(held_f, at_end) + min(0.0, following)
    return (highest > k.forward) | (lowest < -k.backward)


@inner_kernel
def surely_slides(p: float, q_f: float, q_r: float, span: float, end: Response, k: Coefficients) -> bool:
    """Whether a sliding node surely goes on sliding to the end; see `exit_time` for the arguments."""
    start, slope = p + q_f, (q_r - q_f) * k.times.rate_f
    at_end = _height(p, q_f, q_r, True, end)
    # Its height times exp(t / c) falls at most at its first slope times exp(span / c).
    never_falls_to_0 = slope >= 0.0 or start * end.e_c + slope * span > 0.0
    return start > k.tolerance and at_end > 0.0 and never_falls_to_0


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
def exit_time(
    p: float,
    q_f: float,
    q_r: float,
    sliding: bool,
    span: float,
    patient: bool,
    times: Relaxation,
    tolerance: float,
) -> float:
    """First time within `span` at which a node's height falls below 0; infinity if it does not.

    The height (for a sliding node: times exp(t / c)) turns at most once, where the slope is 0.

    Args:
        p: constant part of the height (of a sliding node: the part that goes as e_c).
        q_f: part that goes as e_f.
        q_r: part that goes as r_f.
        sliding: whether the node slides.
        span: time to look at.
        patient: whether to overlook a node that leaves at once, which rounding may do again and again.
        times: time constants.
        tolerance: of heights and times.
    """
    end = respond(span, times)
    start, slope = p + q_f, q_r - q_f
    at_end, slope_at_end = _height(p, q_f, q_r, sliding, end), _slope(q_f, q_r, end, times.rate_f)
    if start <= tolerance and slope < 0.0:  # at the border, on its way out
        if patient:
            return np.inf
        leaves = at_end < -tolerance
        if not leaves and slope_at_end > 0.0:
            now = respond(_turning_time(q_f, q_r, span, times, tolerance), times)
            leaves = _height(p, q_f, q_r, sliding, now) < -tolerance
        return 0.0 if leaves else np.inf
    if at_end < -tolerance:
        low = 0.0
        if start <= tolerance:  # at the border, on its way in: it leaves after the turn
            low = _turning_time(q_f, q_r, span, times, tolerance)
        guess = span * start / (start - at_end) if low == 0.0 else 0.5 * (low + span)
        return _root(p, q_f, q_r, sliding, low, span, guess, times, tolerance)
    if slope < 0.0 and slope_at_end > 0.0:
        turn = _turning_time(q_f, q_r, span, times, tolerance)
        if _height(p, q_f, q_r, sliding, respond(turn, times)) < -tolerance:
            return _root(p, q_f, q_r, sliding, 0.0, turn, 0.5 * turn, times, tolerance)
    return np.inf


@step_kernel
def _turning_time(q_f: float, q_r: float, span: float, times: Relaxation, tolerance: float) -> float:
    """Where the slope changes sign within `span`, which it is known to do once."""
    if times.apart:  # q_r (e_m - r_f) = q_f e_f, with r_f = (e_m - e_f) o
        o = times.over_f_m
        turn = math.log((q_f - q_r * o) / (q_r * (1.0 - o))) / (times.rate_f - times.rate_m)
        return min(max(turn, 0.0), span)
    low, high = 0.0, span
    rising = q_r - q_f < 0.0
    while high - low > tolerance:  # divided by e_f the slope is monotone in time: bisection cannot miss
        middle = 0.5 * (low + high)
        if (_slope(q_f, q_r, respond(middle, times), times.rate_f) > 0.0) == rising:
            high = middle
        else:
            low = middle
        if middle == low == high:
            break
    return 0.5 * (low + high)


@step_kernel
def _root(
    p: float,
    q_f: float,
    q_r: float,
    sliding: bool,
    low: float,
    high: float,
    guess: float,
    times: Relaxation,
    tolerance: float,
) -> float:
    """Where the height falls through 0 between `low`, where it is positive, and `high`, where it is not."""
    time = guess
    for _ in range(_PASSES):
        now = respond(time, times)
        height = _height(p, q_f, q_r, sliding, now)
        slope = _slope(q_f, q_r, now, times.rate_f)
        if sliding:
            slope -= height * times.rate_c
        if height > 0.0:
            low = time
        else:
            high = time
        better = time - height / slope if slope != 0.0 else low
        if not low <= better <= high:
            better = 0.5 * (low + high)
        elif (better - time) ** 2 <= tolerance * _QUADRATIC:  # the next correction is of second order
            return better
        if better == time or high - low <= tolerance:
            return better
        time = better
    return time


@inner_kernel
def switch(u: Rows, slip: Rows, work: Rows, node: int, now: Response, k: Coefficients) -> None:
    """Stop a sliding node, or let a stuck one go in the direction in which it is overloaded.

    With the last stuck node gone, nothing would resist rigid motion: the body jumps to the velocity at which
    the slowest node that slides the other way sticks. (Unless friction balances: see `exact.cross_decision`.)
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
