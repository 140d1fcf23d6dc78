"""How relaxations answer to relaxations: the functions of time that the exact integrator adds up.

Between events a spike's drive decays as e_m = exp(-t / tau_m). Forces and displacements follow it through up
to two relaxations more, so every quantity is a sum of these functions of the time t since the epoch:

    e_f = exp(-t / tau_f)         a force left alone
    r_f                           the force that follows e_m:         tau_f r_f' = e_m - r_f,   r_f(0) = 0
    e_c = exp(-t / c)             a displacement left alone (c: damping over stiffness)
    s_f                           the displacement that follows e_f:  c s_f' = e_f - s_f,       s_f(0) = 0
    s_r                           the displacement that follows r_f:  c s_r' = r_f - s_r,       s_r(0) = 0

They are divided differences of the exponential function, written so that they also hold where time constants
are equal, or nearly so.
"""

import math
from typing import NamedTuple

from crawler_bench.physics.compiled import inline_kernel, inner_kernel
from crawler_bench.physics.muscle import follow
from crawler_bench.physics.tolerances import APART_RATES, CLOSE_EXPONENTS, NEAR_EXPONENT, SERIES_TERMS


class Response(NamedTuple):
    """A time since the epoch, and the functions above at this time."""

    time: float
    e_m: float
    e_f: float
    r_f: float
    e_c: float
    s_f: float
    s_r: float


START = Response(0.0, 1.0, 1.0, 0.0, 1.0, 0.0, 0.0)


class Relaxation(NamedTuple):
    """Time constants, and what partial fractions need of them."""

    tau_m: float
    tau_f: float
    c: float
    rate_m: float
    rate_f: float
    rate_c: float
    apart: bool  # whether the rates are far enough apart for partial fractions
    over_f_m: float  # 1 / (1 - tau_f / tau_m), and so on; 0 where they are not
    over_c_f: float
    over_c_m: float


def relaxation(tau_m: float, tau_f: float, c: float) -> Relaxation:
    """Prepare time constants for `respond`."""
    f_m, c_f, c_m = 1.0 - tau_f / tau_m, 1.0 - c / tau_f, 1.0 - c / tau_m
    apart = min(abs(f_m), abs(c_f), abs(c_m)) > APART_RATES
    over = (1.0 / f_m, 1.0 / c_f, 1.0 / c_m) if apart else (0.0, 0.0, 0.0)
    return Relaxation(tau_m, tau_f, c, 1.0 / tau_m, 1.0 / tau_f, 1.0 / c, apart, *over)


@inline_kernel
def respond(time: float, times: Relaxation) -> Response:
    """Evaluate all functions at a time, for any time constants."""
    e_m, e_f = math.exp(-time * times.rate_m), math.exp(-time * times.rate_f)
    e_c = math.exp(-time * times.rate_c)
    if times.apart:
        r_f = (e_m - e_f) * times.over_f_m
        s_f = (e_f - e_c) * times.over_c_f
        s_r = ((e_m - e_c) * times.over_c_m - s_f) * times.over_f_m
    else:
        r_f, s_f, s_r = _follow_close(time, times)
    return Response(time, e_m, e_f, r_f, e_c, s_f, s_r)


@inner_kernel
def _follow_close(time: float, times: Relaxation) -> tuple[float, float, float]:
    """Evaluate r_f, s_f and s_r where rates are close to each other."""
    difference = _second_difference(-time * times.rate_m, -time * times.rate_f, -time * times.rate_c)
    return (
        follow(time, times.tau_m, times.tau_f),
        follow(time, times.tau_f, times.c),
        time * time * times.rate_f * times.rate_c * difference,
    )


@inline_kernel
def after(first: Response, then: Response) -> Response:
    """The functions at the sum of two times at which they are known."""
    return Response(
        first.time + then.time,
        first.e_m * then.e_m,
        first.e_f * then.e_f,
        first.r_f * then.e_f + first.e_m * then.r_f,
        first.e_c * then.e_c,
        first.s_f * then.e_c + first.e_f * then.s_f,
        first.s_r * then.e_c + first.r_f * then.s_f + first.e_m * then.s_r,
    )


@inner_kernel
def respond_near(known: Response, time: float, times: Relaxation) -> Response:
    """Evaluate all functions at a time near one at which they are known: without exponentials."""
    passed = time - known.time
    x, y, z = -passed * times.rate_m, -passed * times.rate_f, -passed * times.rate_c
    if not times.apart or max(abs(x), abs(y), abs(z)) > NEAR_EXPONENT:
        return respond(time, times)
    e_m, e_f, e_c = _series(x), _series(y), _series(z)
    s_f = (e_f - e_c) * times.over_c_f
    s_r = ((e_m - e_c) * times.over_c_m - s_f) * times.over_f_m
    there = after(known, Response(passed, e_m, e_f, (e_m - e_f) * times.over_f_m, e_c, s_f, s_r))
    return Response(time, there.e_m, there.e_f, there.r_f, there.e_c, there.s_f, there.s_r)


@inline_kernel
def _series(x: float) -> float:
    """The exponential function of a number of at most NEAR_EXPONENT, to rounding."""
    return 1.0 + x * (1.0 + x * (1.0 / 2.0 + x * (1.0 / 6.0 + x * (1.0 / 24.0 + x * (1.0 / 120.0)))))


@inner_kernel
def _second_difference(x: float, y: float, z: float) -> float:
    """Divided difference of exp at three points, equal or not."""
    low, high = min(x, y, z), max(x, y, z)
    middle = x + y + z - low - high
    if high - low > CLOSE_EXPONENTS:
        return (_first_difference(high, middle) - _first_difference(middle, low)) / (high - low)
    total, factor = 0.0, 0.5
    h1, h2, h3 = 1.0, 1.0, 1.0  # complete homogeneous polynomials of the deviations from the middle
    for n in range(1, SERIES_TERMS + 1):
        total += h3 * factor
        factor /= n + 2
        h1 *= high - middle
        h2 = h1  # the middle's own deviation is 0
        h3 = h2 + (low - middle) * h3
    return math.exp(middle) * total


@inner_kernel
def _first_difference(x: float, y: float) -> float:
    """Divided difference of exp at two points, x >= y."""
    return math.exp(x) * (-math.expm1(y - x) / (x - y) if x != y else 1.0)
