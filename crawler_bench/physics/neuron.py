"""The theta-neuron [M20, eq. 6-7], stepped exactly and without trigonometry.

With V = tan(theta / 2), eq. 6 becomes the quadratic integrate-and-fire neuron

    dV/dt = neuron_rate (V^2 + I),        I = 0 (OFF) or 1 (ON),

whose solution over any time is a Moebius map of V. Rest is V = 0, theta = pi is V = infinity, and theta
passes a multiple of 2 pi where V rises through 0.
"""

import math

from crawler_bench.physics.compiled import inner_kernel
from crawler_bench.physics.tolerances import NEVER

NO_SPIKE = -1.0
_JUST_PAST_INFINITY = -NEVER


@inner_kernel
def step_neuron(
    V: float, on: bool, dt: float, rate: float, tan_rate_dt: float, at_pi: bool, at_2pi: bool
) -> tuple[float, float]:
    """Advance one neuron by dt under a constant input [M20, eq. 6]; find its spike [M20, eq. 7].

    Args:
        V: tan(theta / 2).
        on: whether the input I is 1.
        dt: step, tau_theta; rate * dt must be below pi / 2, so that a step holds one spike at most.
        rate: neuron_rate, 1 / tau_theta.
        tan_rate_dt: tan(rate * dt), precomputed.
        at_pi: spike where theta = pi mod 2 pi (eq. 7).
        at_2pi: spike where theta = 0 mod 2 pi (its text).

    Returns:
        V at the end of the step, and the time of the spike from the start of the step, or NO_SPIKE.
    """
    if on:
        denominator = 1.0 - V * tan_rate_dt
        numerator = V + tan_rate_dt
    else:
        denominator = 1.0 - V * rate * dt
        numerator = V
    if denominator > 0.0:
        new = numerator / denominator
        if at_2pi and V < 0.0 and new >= 0.0:
            return new, min(_time_to_zero(V, rate), dt)
        return new, NO_SPIKE
    new = numerator / denominator if denominator < 0.0 else _JUST_PAST_INFINITY
    return new, min(_time_to_infinity(V, on, rate), dt) if at_pi else NO_SPIKE


@inner_kernel
def _time_to_infinity(V: float, on: bool, rate: float) -> float:
    """Time until theta = pi, from V > 0."""
    return (math.atan(1.0 / V) if on else 1.0 / V) / rate


@inner_kernel
def _time_to_zero(V: float, rate: float) -> float:
    """Time until theta = 2 pi, from V < 0 and ON (OFF, V creeps towards 0 and never arrives)."""
    return math.atan(-V) / rate


@inner_kernel
def cotangent(V: float) -> float:
    """The clock q = 1 / V = cot(theta / 2): eq. 6 of a neuron that is OFF becomes dq/dt = -neuron_rate."""
    return min(max(1.0 / V, -NEVER), NEVER) if V != 0.0 else NEVER


@inner_kernel
def tangent(q: float) -> float:
    """Undo `cotangent`."""
    if q == 0.0:
        return _JUST_PAST_INFINITY
    return 1.0 / q if q < NEVER else 0.0
