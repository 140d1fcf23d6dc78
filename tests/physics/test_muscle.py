"""The exact muscle step against quadrature, against the printed sum over spikes, and against itself.

The force is a relaxation towards a drive that decays, jumps at spikes and is cut off at 1. Between those
corners the package uses exponentials, with the limit tau_f = tau_m taken in closed form; how a span of time
is cut into steps must therefore not matter beyond rounding.
"""

from dataclasses import replace
from itertools import pairwise
from math import exp, log, pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.integrate import quad

from crawler_bench.physics import CrawlerParameters
from crawler_bench.physics.as_printed import drive
from crawler_bench.physics.muscle import follow, relax_muscle
from crawler_bench.physics.neuron import NO_SPIKE
from crawler_bench.physics.stepped import step_muscle
from tests.bodies import former
from tests.physics.crawling import Crawler, crawl

TIMES = st.floats(1e-3, 10.0)
TAUS = st.floats(0.05, 5.0)


def force_by_quadrature(
    F: float, f: float, time: float, tau_m: float, tau_f: float, force_max: float
) -> float:
    """Variation of constants on eq. 4, integrated on either side of the limiter."""

    def memory(s: float) -> float:
        return exp(-(time - s) / tau_f) / tau_f * min(1.0, F * exp(-s / tau_m))

    limiter = min(max(tau_m * log(F), 0.0), time) if F > 0.0 else 0.0
    # Only the last few tau_f are remembered: the interval before would hide the peak from the quadrature.
    corners = sorted({limiter, time, *(max(limiter, time - k * tau_f) for k in (1, 5, 40))})
    limited = exp(-(time - limiter) / tau_f) - exp(-time / tau_f)
    relaxing = sum(quad(memory, a, b, epsabs=1e-13, epsrel=1e-9)[0] for a, b in pairwise(corners))
    return f * exp(-time / tau_f) + force_max * (limited + relaxing)


@settings(derandomize=True, deadline=None, max_examples=200)
@given(
    F=st.floats(0.0, 20.0), f=st.floats(0.0, 1.0), time=TIMES, tau_m=TAUS, tau_f=TAUS, top=st.floats(0.1, 3.0)
)
def test_relaxation_is_the_quadrature(
    F: float, f: float, time: float, tau_m: float, tau_f: float, top: float
) -> None:
    new_F, new_f = relax_muscle(F, f, time, tau_m, tau_f, top)
    assert new_F == pytest.approx(F * exp(-time / tau_m), rel=1e-12, abs=1e-150)
    assert new_f == pytest.approx(force_by_quadrature(F, f, time, tau_m, tau_f, top), abs=1e-10)


@settings(derandomize=True, deadline=None, max_examples=200)
@given(
    F=st.floats(0.0, 20.0),
    f=st.floats(0.0, 1.0),
    time=TIMES,
    cut=st.floats(0.0, 1.0),
    tau_m=TAUS,
    tau_f=TAUS,
)
def test_two_relaxations_are_one(
    F: float, f: float, time: float, cut: float, tau_m: float, tau_f: float
) -> None:
    whole = relax_muscle(F, f, time, tau_m, tau_f, 1.0)
    middle = relax_muscle(F, f, cut * time, tau_m, tau_f, 1.0)
    assert relax_muscle(*middle, time - cut * time, tau_m, tau_f, 1.0) == pytest.approx(
        whole, rel=1e-11, abs=1e-13
    )


@pytest.mark.parametrize("time", [0.01, 0.5, 3.0])
def test_the_limiter_is_crossed_inside_a_step(time: float) -> None:
    """From F = exp(t / 2) the drive is limited for exactly half the time when tau_m = 1."""
    F, f = relax_muscle(exp(time / 2.0), 0.25, time, 1.0, 0.7, 1.0)
    at_crossing = 1.0 - 0.75 * exp(-time / 2.0 / 0.7)
    gain = (exp(-time / 2.0 / 0.7) - exp(-time / 2.0)) / (0.7 - 1.0)
    assert F == pytest.approx(exp(-time / 2.0), rel=1e-13)
    assert f == pytest.approx(at_crossing * exp(-time / 2.0 / 0.7) + gain, rel=1e-12)


@pytest.mark.parametrize("detune", [0.0, 1e-15, 1e-12, 1e-9, 1e-6, -1e-6, -1e-9, -1e-12])
@pytest.mark.parametrize("tau", [0.3, 1.0, 4.0])
def test_equal_and_nearly_equal_time_constants(tau: float, detune: float) -> None:
    """The textbook difference of two exponentials over tau_f - tau_m has no digits left here."""
    time = 0.37
    equal = time / tau * exp(-time / tau)
    slope = (time / tau) * (time / (2.0 * tau) - 1.0) * exp(-time / tau)  # d follow / d ln tau_f
    expected = equal + slope * detune
    assert follow(time, tau, tau * (1.0 + detune)) == pytest.approx(expected, rel=1e-11)


@pytest.mark.parametrize(
    ("time", "tau_m", "tau_f"),
    [(80.0, 1.0, 0.1), (0.01, 1.0, 1e-5), (1000.0, 1.0, 0.7), (1000.0, 0.1, 0.7), (1e-9, 1.0, 0.7)],
)
def test_extreme_times_stay_finite(time: float, tau_m: float, tau_f: float) -> None:
    expected = (exp(-time / tau_m) - exp(-time / tau_f)) / (tau_m - tau_f) * tau_m
    assert follow(time, tau_m, tau_f) == pytest.approx(expected, rel=1e-6, abs=1e-250)
    F, f = relax_muscle(0.5, 0.5, time, tau_m, tau_f, 1.0)
    assert 0.0 <= F <= 0.5
    assert 0.0 <= f <= 0.5


def test_a_muscle_left_alone_ends_at_exactly_zero() -> None:
    F, f = 5.0, 1.0
    for _ in range(100):
        F, f = relax_muscle(F, f, 10.0, 1.0, 0.7, 1.0)
    assert (F, f) == (0.0, 0.0)


def test_a_small_drive_decays_and_is_not_cut_off() -> None:
    """What is flushed to zero is far below anything that moves a muscle."""
    F, f = relax_muscle(1e-150, 1e-150, 1.0, 1.0, 1.0, 1.0)
    assert F == pytest.approx(1e-150 * exp(-1.0), rel=1e-12)
    assert f == pytest.approx(2e-150 * exp(-1.0), rel=1e-12)
    assert relax_muscle(1e-220, 1e-220, 1.0, 1.0, 1.0, 1.0) == (0.0, 0.0)


@pytest.mark.parametrize("steps", [1, 7])
@pytest.mark.parametrize("drive_now", [0.9, 1.0, 1.0 + 1e-12, 1.005, 1.4, 3.0])
def test_known_exponentials_are_those_of_a_relaxation(drive_now: float, steps: int) -> None:
    """On either side of the limiter, at it and through it: a fall is not put off to the end of a step."""
    crawler = Crawler(former(tau_m=0.4))
    node, k, s = crawler.nodes[0], crawler.k, crawler.s
    node.drive, node.force = drive_now, 0.3
    for _ in range(steps):
        step_muscle(node, NO_SPIKE, k, s)
    expected = relax_muscle(drive_now, 0.3, steps * s.dt, k.tau_m, k.tau_f, k.force_max)
    assert (node.drive, node.force) == pytest.approx(expected, rel=1e-13)


def muscle_history(p: CrawlerParameters, actions: list[int]) -> NDArray[np.float64]:
    """Drive and force of every muscle after each decision interval: (actions, 2, N + 1)."""
    trail = crawl(replace(p, integrator="step"), actions)[1:]
    return np.stack([trail["drive"], trail["force"]], axis=1)


@pytest.mark.parametrize(("tau_m", "tau_f"), [(1.0, 0.7), (0.5, 0.5), (0.2, 2.0)])
@pytest.mark.parametrize("spike_phase", ["pi", "2pi"])
@pytest.mark.parametrize("spike_gain", [0.4, 2.0])
def test_the_step_size_does_not_matter(
    tau_m: float, tau_f: float, spike_phase: str, spike_gain: float
) -> None:
    """Spikes and limiter crossings fall inside the long steps and between the short ones."""
    p = former(
        n_segments=3, tau_m=tau_m, tau_f=tau_f, spike_phase=spike_phase, spike_gain=spike_gain, dt=0.5,
        decision_interval=0.5,
    )  # fmt: skip
    actions = [0, 0, 0, 0, 1, 1, 1, 1, 0, 0, 2, 2, 2, 2, 2, 2, 2, 0, 0]
    coarse = muscle_history(p, actions)
    fine = muscle_history(replace(p, dt=p.dt / 100), actions)
    assert np.count_nonzero(fine.max(axis=(0, 1))) == 4
    np.testing.assert_allclose(coarse, fine, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("spike_gain", [0.5, 1.0, 3.0])
@pytest.mark.parametrize("dt", [0.001, 0.01, 0.1])
def test_the_drive_is_the_sum_over_spikes(spike_gain: float, dt: float) -> None:
    """A neuron left ON spikes at pi / 2, 3 pi / 2, ...; the force follows by quadrature."""
    p = former(
        n_segments=2, neuron_rate=1.0, spike_gain=spike_gain, muscle_force_max=0.8, dt=dt,
        decision_interval=1.0,
    )  # fmt: skip
    spikes = [pi / 2.0 + k * pi for k in range(4)]
    history = muscle_history(p, [1] * 9)
    for t, (F, f) in enumerate(history[:, :, 1], start=1):
        assert F == pytest.approx(drive(t, spikes, p.tau_m, p.spike_gain), rel=1e-11)
        corners = [0.0, *(s for s in spikes if s < t), float(t)]
        expected = 0.0
        for start, stop in pairwise(corners):
            expected = force_by_quadrature(
                drive(start, spikes, p.tau_m, p.spike_gain), expected, stop - start,
                p.tau_m, p.tau_f, p.muscle_force_max,
            )  # fmt: skip
        assert f == pytest.approx(expected, abs=1e-10)
        assert f <= p.muscle_force_max
