"""When the margin of a node falls below 0, on its way from one event of the muscles to the next.

The *margin* of a node says how far it is from changing its slip state: the distance of its holding force to a
limit while it is stuck, its velocity in the direction of sliding (times c) while it slides. Between events
(trajectory.py) it is, up to a positive factor, a sum that rises or falls with at most one turn, so the first
moment at which it falls below 0 is bracketed surely and found by Newton's method.
"""

import math
from typing import NamedTuple

from crawler_bench.physics.coefficients import Coefficients
from crawler_bench.physics.compiled import inline_kernel, inner_kernel
from crawler_bench.physics.relaxation import Relaxation, Response, respond, respond_near
from crawler_bench.physics.tolerances import NEVER, QUADRATIC, ROOT_PASSES


class Margin(NamedTuple):
    """The terms of a margin."""

    constant: float  # of a sliding node: what goes as e_c
    as_e_f: float
    as_r_f: float
    sliding: bool


@inline_kernel
def margin_at(m: Margin, now: Response) -> float:
    """Distance of the holding force of a stuck node to a limit; velocity of a sliding one, times c."""
    if m.sliding:
        return m.constant * now.e_c + m.as_e_f * (now.e_f - now.s_f) + m.as_r_f * (now.r_f - now.s_r)
    return m.constant + m.as_e_f * now.e_f + m.as_r_f * now.r_f


@inline_kernel
def slope_of(m: Margin, now: Response, rate_f: float) -> float:
    """Rate of change of the force on a node.

    It is that of a stuck node's margin and, up to a positive factor, of exp(t / c) times a sliding one's.
    """
    return (m.as_r_f * (now.e_m - now.r_f) - m.as_e_f * now.e_f) * rate_f


@inner_kernel
def crossing_time(m: Margin, now: Response, end: Response, patient: bool, k: Coefficients) -> float:
    """First time at which a node's margin falls below 0; NEVER if it does not before the end.

    The margin (of a sliding node: times exp(t / c)) turns at most once, where the slope is 0.

    Args:
        m: the margin.
        now: the responses at the time to look from.
        end: the responses at the end.
        patient: whether to overlook a node that leaves at once, which rounding may do again and again.
        k: coefficients.
    """
    times, tolerance = k.times, k.tolerance
    start, slope = margin_at(m, now), slope_of(m, now, times.rate_f)
    at_end, slope_at_end = margin_at(m, end), slope_of(m, end, times.rate_f)
    low, high, falls = now.time, end.time, at_end < -tolerance
    if start <= tolerance and slope < 0.0:  # at the border, on its way out
        if patient:
            return NEVER
        if not falls and slope_at_end > 0.0:
            turn = _turning_time(m, now.time, end.time, times, tolerance)
            falls = margin_at(m, respond(turn, times)) < -tolerance
        return now.time if falls else NEVER
    if start <= tolerance:  # at the border, on its way in: it may leave after the turn
        if falls:
            low = _turning_time(m, now.time, end.time, times, tolerance)
            start = margin_at(m, respond(low, times))
            slope = 0.0
    elif not falls and slope < 0.0 and slope_at_end > 0.0:
        high = _turning_time(m, now.time, end.time, times, tolerance)
        at_end = margin_at(m, respond(high, times))
        falls = at_end < -tolerance
    if not falls:
        return NEVER
    if m.sliding:
        slope -= start * times.rate_c
    guess = low + (high - low) * _parabola_root(start, slope * (high - low), at_end)
    return _root(m, low, high, guess, times, tolerance)


@inner_kernel
def _parabola_root(start: float, slope: float, end: float) -> float:
    """Where, from 0 to 1, a parabola falls through 0 that has this value and slope at 0 and value at 1."""
    root = math.sqrt(max(slope * slope - 4.0 * (end - start - slope) * start, 0.0))
    return min(2.0 * start / (root - slope), 1.0) if start > 0.0 and root > slope else 0.5


@inner_kernel
def _turning_time(m: Margin, low: float, high: float, times: Relaxation, tolerance: float) -> float:
    """Where the slope changes sign between two times, which it is known to do once."""
    if times.apart:  # as_r_f (e_m - r_f) = as_e_f e_f, with r_f = (e_m - e_f) o
        o = times.over_f_m
        turn = math.log((m.as_e_f - m.as_r_f * o) / (m.as_r_f * (1.0 - o))) / (times.rate_f - times.rate_m)
        return min(max(turn, low), high)
    rising = slope_of(m, respond(low, times), times.rate_f) < 0.0
    while high - low > tolerance:  # divided by e_f the slope is monotone in time: bisection cannot miss
        middle = 0.5 * (low + high)
        if (slope_of(m, respond(middle, times), times.rate_f) > 0.0) == rising:
            high = middle
        else:
            low = middle
        if middle == low == high:
            break
    return 0.5 * (low + high)


@inner_kernel
def _root(m: Margin, low: float, high: float, guess: float, times: Relaxation, tolerance: float) -> float:
    """Where the margin falls through 0 between `low`, where it is positive, and `high`, where it is not."""
    time, now = guess, respond(guess, times)
    for _ in range(ROOT_PASSES):
        above = margin_at(m, now)
        slope = slope_of(m, now, times.rate_f)
        if m.sliding:
            slope -= above * times.rate_c
        if above > 0.0:
            low = time
        else:
            high = time
        better = time - above / slope if slope != 0.0 else low
        if not low <= better <= high:
            better = 0.5 * (low + high)
        elif (better - time) ** 2 <= tolerance * QUADRATIC:  # the next correction is of second order
            return better
        if better == time or high - low <= tolerance:
            return better
        now = respond_near(now, better, times)
        time = better
    return time
