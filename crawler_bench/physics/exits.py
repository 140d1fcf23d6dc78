"""When the height of a node falls below 0, on its course from one event of the muscles to the next.

The *height* of a node says how far it is from leaving its state: the distance of its holding force to a limit
while it is stuck, its velocity in the direction of sliding (times c) while it slides. On a course (course.py)
it is, up to a positive factor, a sum that rises or falls with at most one turn, so that the first moment at
which it falls below 0 is bracketed surely and found by Newton's method.
"""

import math

from crawler_bench.physics.compilation import inner_kernel, step_kernel
from crawler_bench.physics.layout import NEVER
from crawler_bench.physics.response import Relaxation, Response, respond, respond_near

_PASSES = 100
_QUADRATIC = 1e-2  # safety on the error of a Newton step, which is about its square


@inner_kernel
def height(p: float, q_f: float, q_r: float, sliding: bool, now: Response) -> float:
    """Holding force of a stuck node, or its distance to a limit; velocity of a sliding one, times c."""
    as_p, as_q_f = now.e_c if sliding else 1.0, now.e_f - now.s_f if sliding else now.e_f
    return p * as_p + q_f * as_q_f + q_r * (now.r_f - now.s_r if sliding else now.r_f)


@inner_kernel
def slope_of(q_f: float, q_r: float, now: Response, rate_f: float) -> float:
    """Rate of change of the force on a node.

    It is that of a stuck node's height and, up to a positive factor, of exp(t / c) times a sliding one's.
    """
    return (q_r * (now.e_m - now.r_f) - q_f * now.e_f) * rate_f


@inner_kernel
def exit_time(
    p: float,
    q_f: float,
    q_r: float,
    sliding: bool,
    clock: float,
    now: Response,
    until: float,
    end: Response,
    patient: bool,
    times: Relaxation,
    tolerance: float,
) -> float:
    """First time at which a node's height falls below 0; NEVER if it does not before the end.

    The height (for a sliding node: times exp(t / c)) turns at most once, where the slope is 0.

    Args:
        p: constant part of the height (of a sliding node: the part that goes as e_c).
        q_f: part that goes as e_f.
        q_r: part that goes as r_f.
        sliding: whether the node slides.
        clock: time to look from.
        now: the responses at this time.
        until: time of the end.
        end: the responses then.
        patient: whether to overlook a node that leaves at once, which rounding may do again and again.
        times: the time constants.
        tolerance: of heights and times.
    """
    start, slope = height(p, q_f, q_r, sliding, now), slope_of(q_f, q_r, now, times.rate_f)
    at_end, slope_at_end = height(p, q_f, q_r, sliding, end), slope_of(q_f, q_r, end, times.rate_f)
    low, high, falls = clock, until, at_end < -tolerance
    if start <= tolerance and slope < 0.0:  # at the border, on its way out
        if patient:
            return NEVER
        if not falls and slope_at_end > 0.0:
            turn = respond(_turning_time(q_f, q_r, clock, until, times, tolerance), times)
            falls = height(p, q_f, q_r, sliding, turn) < -tolerance
        return clock if falls else NEVER
    if start <= tolerance:  # at the border, on its way in: it may leave after the turn
        if falls:
            low = _turning_time(q_f, q_r, clock, until, times, tolerance)
            start = height(p, q_f, q_r, sliding, respond(low, times))
            slope = 0.0
    elif not falls and slope < 0.0 and slope_at_end > 0.0:
        high = _turning_time(q_f, q_r, clock, until, times, tolerance)
        at_end = height(p, q_f, q_r, sliding, respond(high, times))
        falls = at_end < -tolerance
    if not falls:
        return NEVER
    if sliding:
        slope -= start * times.rate_c
    guess = low + (high - low) * _fall(start, slope * (high - low), at_end)
    return _root(p, q_f, q_r, sliding, low, high, guess, times, tolerance)


@inner_kernel
def _fall(start: float, slope: float, end: float) -> float:
    """Where, from 0 to 1, a parabola falls through 0 that has this value and slope at 0 and value at 1."""
    root = math.sqrt(max(slope * slope - 4.0 * (end - start - slope) * start, 0.0))
    return min(2.0 * start / (root - slope), 1.0) if start > 0.0 and root > slope else 0.5


@step_kernel
def _turning_time(
    q_f: float, q_r: float, low: float, high: float, times: Relaxation, tolerance: float
) -> float:
    """Where the slope changes sign between two times, which it is known to do once."""
    if times.apart:  # q_r (e_m - r_f) = q_f e_f, with r_f = (e_m - e_f) o
        o = times.over_f_m
        turn = math.log((q_f - q_r * o) / (q_r * (1.0 - o))) / (times.rate_f - times.rate_m)
        return min(max(turn, low), high)
    rising = slope_of(q_f, q_r, respond(low, times), times.rate_f) < 0.0
    while high - low > tolerance:  # divided by e_f the slope is monotone in time: bisection cannot miss
        middle = 0.5 * (low + high)
        if (slope_of(q_f, q_r, respond(middle, times), times.rate_f) > 0.0) == rising:
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
    time, now = guess, respond(guess, times)
    for _ in range(_PASSES):
        above = height(p, q_f, q_r, sliding, now)
        slope = slope_of(q_f, q_r, now, times.rate_f)
        if sliding:
            slope -= above * times.rate_c
        if above > 0.0:
            low = time
        else:
            high = time
        better = time - above / slope if slope != 0.0 else low
        if not low <= better <= high:
            better = 0.5 * (low + high)
        elif (better - time) ** 2 <= tolerance * _QUADRATIC:  # the next correction is of second order
            return better
        if better == time or high - low <= tolerance:
            return better
        now = respond_near(now, time, better, times)
        time = better
    return time
