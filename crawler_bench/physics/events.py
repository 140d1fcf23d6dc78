"""When and how a node of the crawler starts or stops sliding, between two events of the muscles.

A node leaves its state when its *height* falls below 0: the distance of its holding force to a limit while it
is stuck, its velocity in the direction of sliding (times c) while it slides. exact.py has the closed forms.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from crawler_bench.physics.body import BACKWARD, FORWARD, STUCK
from crawler_bench.physics.coefficients import Coefficients
from crawler_bench.physics.compilation import inner_kernel, step_kernel
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
    W,
)
from crawler_bench.physics.response import Relaxation, Response, respond, respond_near

Memory = NDArray[np.float64]

_PASSES = 100
_QUADRATIC = 1e-2  # safety on the error of a Newton step, which is about its square


class Sights(NamedTuple):
    """How far ahead one looks, and the responses there."""

    until: float  # the end of the decision
    end: Response
    horizon: float  # the end of the last decision before the next epoch
    far: Response


@inner_kernel
def watch(
    memory: Memory, low: int, high: int, anew: bool, clock: float, now: Response, sights: Sights,
    patient: bool, k: Coefficients,
) -> None:  # fmt: skip
    """Note when to look at each node from `low` to `high` again.

    Not before the next epoch, if it surely keeps its state so long; or at the end of the decision, if it
    keeps it so long; or else when it leaves its state.

    Args:
        memory: LEAVE_AT is written.
        low: the first node.
        high: the last node.
        anew: look at all of them, as their course is new; else only at those whose time has come.
        clock: time now.
        now: the responses.
        sights: how far one looks.
        patient: whether to overlook a node that leaves at once, which rounding may do again and again.
        k: coefficients.
    """
    leave_at, listed = memory[LEAVE_AT], memory[WORK]
    count = 0
    for i in range(low, high + 1):  # lists are made without branches, too
        listed[count] = i
        count += int(anew or leave_at[i] <= clock)
    suspects = 0
    for j in range(count):
        i = int(listed[j])
        leave_at[i] = _safe_until(memory, i, clock, now, sights, k)
        listed[suspects] = i
        suspects += int(leave_at[i] < clock)
    for j in range(suspects):
        i = int(listed[j])
        leave_at[i] = sights.until
        sliding, limits = memory[SLIP, i] != STUCK, 1
        p, q_f, q_r = _force(memory, i, sliding)
        if not sliding:
            p, limits = k.backward + p, 2
        for _ in range(limits):
            time = exit_time(
                p, q_f, q_r, sliding, clock, now, sights.until, sights.end, patient, k.times, k.tolerance
            )
            leave_at[i] = min(leave_at[i], time)
            p, q_f, q_r = k.forward + k.backward - p, -q_f, -q_r  # the distance to the other limit


@inner_kernel
def _safe_until(
    memory: Memory, i: int, clock: float, now: Response, sights: Sights, k: Coefficients
) -> float:
    """Until when a node surely keeps its state: NEVER, the end of the decision, or less than `clock`.

    Without branches, of which a processor would guess many wrong.
    """
    sliding = memory[SLIP, i] != STUCK
    p, q_f, q_r = _force(memory, i, sliding)
    start, slope = _height(p, q_f, q_r, sliding, now), _slope(q_f, q_r, now, k.times.rate_f)
    lowest, highest = (0.0, NEVER) if sliding else (-k.backward, k.forward)
    is_inside = (start < highest - k.tolerance) & (start > lowest + k.tolerance)
    safe = -NEVER
    for until, end, sure in ((sights.until, sights.end, sights.until), (sights.horizon, sights.far, NEVER)):
        at_end, last_slope = _height(p, q_f, q_r, sliding, end), _slope(q_f, q_r, end, k.times.rate_f)
        stays = is_inside & (at_end < highest - k.tolerance) & (at_end > lowest + k.tolerance)
        # Where it may turn in between, it goes at most as far as its first slope takes it.
        far = start * (end.e_c if sliding else 1.0) + slope * (until - clock)
        stays &= (slope * last_slope >= 0.0) | ((far < highest) & (far > lowest))
        safe = sure if stays else safe
    return safe


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
def _height(p: float, q_f: float, q_r: float, sliding: bool, now: Response) -> float:
    """Holding force of a stuck node, or its distance to a limit; velocity of a sliding one, times c."""
    as_p, as_q_f = now.e_c if sliding else 1.0, now.e_f - now.s_f if sliding else now.e_f
    return p * as_p + q_f * as_q_f + q_r * (now.r_f - now.s_r if sliding else now.r_f)


@inner_kernel
def _slope(q_f: float, q_r: float, now: Response, rate_f: float) -> float:
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
    start, slope = _height(p, q_f, q_r, sliding, now), _slope(q_f, q_r, now, times.rate_f)
    at_end, slope_at_end = _height(p, q_f, q_r, sliding, end), _slope(q_f, q_r, end, times.rate_f)
    low, high, falls = clock, until, at_end < -tolerance
    if start <= tolerance and slope < 0.0:  # at the border, on its way out
        if patient:
            return NEVER
        if not falls and slope_at_end > 0.0:
            turn = respond(_turning_time(q_f, q_r, clock, until, times, tolerance), times)
            falls = _height(p, q_f, q_r, sliding, turn) < -tolerance
        return clock if falls else NEVER
    if start <= tolerance:  # at the border, on its way in: it may leave after the turn
        if falls:
            low = _turning_time(q_f, q_r, clock, until, times, tolerance)
            start = _height(p, q_f, q_r, sliding, respond(low, times))
            slope = 0.0
    elif not falls and slope < 0.0 and slope_at_end > 0.0:
        high = _turning_time(q_f, q_r, clock, until, times, tolerance)
        at_end = _height(p, q_f, q_r, sliding, respond(high, times))
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
    rising = _slope(q_f, q_r, respond(low, times), times.rate_f) < 0.0
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
    time, now = guess, respond(guess, times)
    for _ in range(_PASSES):
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
        now = respond_near(now, time, better, times)
        time = better
    return time


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
