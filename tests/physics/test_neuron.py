"""The closed-form theta-neuron against the numerical integration of eq. 6-7 in its printed angle.

A step of the package is a Moebius map of V = tan(theta / 2) that has to get three things right: where the
neuron ends up, whether it spiked on the way, and when. Each is compared with an adaptive integration of theta
for both readings of the spike phase, ON and OFF, far from rest, and exactly on the singularity V = infinity.
"""

from math import atan, cos, isfinite, pi, sin, tan

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from crawler_bench.physics.as_printed import follow_theta
from crawler_bench.physics.neuron import NO_SPIKE, step_neuron

PHASES = ("pi", "2pi", "every_pi")
SPIKE_TIME_ERROR = 1e-7  # of the integrated theta, whose crossing is interpolated


def step(V: float, on: bool, dt: float, rate: float, phase: str) -> tuple[float, float]:
    return step_neuron(V, on, dt, rate, tan(rate * dt), phase != "2pi", phase != "pi")


def run(V: float, inputs: list[tuple[bool, float]], steps: int, rate: float, phase: str):
    """Hold each input for its duration, in equal steps; return V and all spike times."""
    spikes, start = [], 0.0
    for on, duration in inputs:
        dt = duration / steps
        for i in range(steps):
            V, spike = step(V, on, dt, rate, phase)
            if spike != NO_SPIKE:
                spikes.append(start + i * dt + spike)
        start += duration
    return V, spikes


def assert_same_angle(V: float, theta: float, tolerance: float) -> None:
    angle = 2.0 * atan(V)
    assert abs(cos(angle) - cos(theta)) < tolerance
    assert abs(sin(angle) - sin(theta)) < tolerance


@settings(derandomize=True, deadline=None, max_examples=200)
@given(
    theta=st.floats(-pi + 1e-6, pi - 1e-6),
    on=st.booleans(),
    rate=st.floats(0.2, 5.0),
    fraction=st.floats(1e-3, 0.999),
    phase=st.sampled_from(PHASES),
)
def test_a_step_is_the_integral_of_theta(
    theta: float, on: bool, rate: float, fraction: float, phase: str
) -> None:
    assume(theta == 0.0 or abs(theta) > 1e-9)  # an angle next to 2 pi has no digits for less
    dt = fraction * pi / (2.0 * rate)
    V, spike = step(tan(theta / 2.0), on, dt, rate, phase)
    end, spikes = follow_theta(theta, on, dt, rate, phase)
    assert_same_angle(V, end, 1e-8)
    # A spike at the very end belongs to this step or to the next, as rounding has it.
    assume(all(abs(t - dt) > SPIKE_TIME_ERROR for t in spikes))
    assert (spike != NO_SPIKE) == bool(spikes)
    if spikes:
        assert len(spikes) == 1
        assert spike == pytest.approx(spikes[0], abs=SPIKE_TIME_ERROR)
        assert 0.0 <= spike <= dt


@pytest.mark.parametrize("phase", PHASES)
@pytest.mark.parametrize("steps", [4, 7, 100, 1000])
def test_a_spike_train_does_not_depend_on_the_step(phase: str, steps: int) -> None:
    inputs = [(True, 1.2), (False, 1.7), (True, 1.9), (False, 0.4), (True, 1.1)]
    theta, expected, start = 0.0, [], 0.0
    for on, duration in inputs:
        theta, new = follow_theta(theta, on, duration, 1.3, phase)
        expected += [start + t for t in new]
        start += duration
    V, spikes = run(0.0, inputs, steps, 1.3, phase)
    assert len(expected) >= 2
    assert spikes == pytest.approx(expected, abs=SPIKE_TIME_ERROR)
    assert_same_angle(V, theta, 1e-7)


@pytest.mark.parametrize(("phase", "first", "turn"), [
    ("pi", pi / 2.0, pi), ("2pi", pi, pi), ("every_pi", pi / 2.0, pi / 2.0),
])  # fmt: skip
@pytest.mark.parametrize("dt", [0.001, 0.01, 0.3, 0.7])
def test_a_neuron_left_on_spikes_periodically(phase: str, first: float, turn: float, dt: float) -> None:
    rate = 2.0
    steps = round(6.0 / dt)
    V, spikes = run(0.0, [(True, steps * dt)], steps, rate, phase)
    expected = [(first + k * turn) / rate for k in range(len(spikes))]
    assert len(spikes) in ((7, 8) if phase == "every_pi" else (3, 4))
    assert spikes == pytest.approx(expected, abs=1e-11)
    assert tan(rate * steps * dt) == pytest.approx(V, rel=1e-9)


@pytest.mark.parametrize("rate", [0.5, 1.0, 2.0])
def test_a_neuron_switched_off_spikes_late_at_pi_only(rate: float) -> None:
    """Switched off past theta = 0 it drifts on through pi, then creeps to 2 pi and never arrives."""
    on = 0.9 / rate
    late = on + 1.0 / (rate * tan(0.9))
    inputs = [(True, on), (False, 50.0 / rate)]
    V, at_pi = run(0.0, inputs, 1000, rate, "pi")
    assert at_pi == [pytest.approx(late, abs=1e-12)]
    assert -0.1 < V < 0.0
    assert run(0.0, inputs, 1000, rate, "2pi")[1] == []


@pytest.mark.parametrize("phase", PHASES)
def test_a_neuron_at_rest_stays_at_rest(phase: str) -> None:
    assert step(0.0, False, 0.01, 2.0, phase) == (0.0, NO_SPIKE)


@pytest.mark.parametrize(("on", "rate", "dt"), [(False, 2.0, 0.25), (True, 1.0, atan(0.5))])
def test_landing_exactly_on_infinity_is_one_spike(on: bool, rate: float, dt: float) -> None:
    """V = 2 and a Moebius factor of 0.5 make the denominator vanish exactly."""
    V, spike = step_neuron(2.0, on, dt, rate, 0.5, True, False)
    assert isfinite(V)
    assert V < -1e100
    assert 0.0 <= spike <= dt
    assert spike == pytest.approx(dt, rel=1e-12)
    V, spike = step_neuron(V, on, dt, rate, 0.5, True, False)
    assert V == pytest.approx(-2.0, rel=1e-12)
    assert spike == NO_SPIKE


@pytest.mark.parametrize("on", [True, False])
@pytest.mark.parametrize("V", [1e3, 1e16, 1e300])
def test_next_to_infinity(on: bool, V: float) -> None:
    after, spike = step(V, on, 0.01, 2.0, "pi")
    assert spike == pytest.approx(1.0 / (2.0 * V), rel=1e-5)
    assert after == pytest.approx(-1.0 / (tan(0.02) if on else 0.02), rel=0.06)
    assert step(V, on, 0.01, 2.0, "2pi")[1] == NO_SPIKE
    after, spike = step(-V, on, 0.01, 2.0, "pi")
    assert after == pytest.approx(-1.0 / (tan(0.02) if on else 0.02), rel=0.06)
    assert spike == NO_SPIKE


@settings(derandomize=True, deadline=None, max_examples=300)
@given(rate=st.floats(0.2, 5.0), fraction=st.floats(1e-3, 0.999))
def test_arriving_at_two_pi_with_the_end_of_a_step_is_one_spike(rate: float, fraction: float) -> None:
    dt = fraction * pi / (2.0 * rate)
    V, first = step(-tan(rate * dt), True, dt, rate, "2pi")
    _, second = step(V, True, dt, rate, "2pi")
    assert [first, second].count(NO_SPIKE) == 1
    assert V == pytest.approx(0.0, abs=1e-12)
    assert first == NO_SPIKE or first == pytest.approx(dt, rel=1e-12)
    assert first <= dt  # a spike after its step would be lost
