"""Statistics against SciPy, closed forms and simulated data."""

from math import sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats as reference

from crawler_bench.statistics import estimates as stats
from crawler_bench.statistics.estimates import Estimate

NAN = float("nan")
SKEWED = np.random.default_rng(5).exponential(size=20)


def test_the_interquartile_mean_is_that_of_the_middle_half():
    assert stats.estimate([-1000.0, 1, 2, 3, 4, 5, 6, 1000]).value == pytest.approx(3.5)
    assert stats.estimate(SKEWED).value == pytest.approx(reference.trim_mean(SKEWED, 0.25))
    assert stats.estimate(SKEWED, np.mean).value == pytest.approx(SKEWED.mean())


@pytest.mark.parametrize("statistic", [np.mean, stats.interquartile_mean])
def test_the_interval_is_bca(statistic):
    """Another seed of the bootstrap moves it little; the percentile interval of skewed data is elsewhere."""
    ours = stats.estimate(SKEWED, statistic)
    rng = np.random.default_rng(1)
    bca, percentile = (
        reference.bootstrap(
            (SKEWED,), statistic, n_resamples=30000, method=method, rng=rng
        ).confidence_interval
        for method in ("BCa", "percentile")
    )
    width = bca.high - bca.low
    assert abs(bca.high - percentile.high) > 0.03 * width
    assert ours.low == pytest.approx(bca.low, abs=0.015 * width)
    assert ours.high == pytest.approx(bca.high, abs=0.015 * width)
    assert ours.low < ours.value < ours.high
    assert not ours.degenerate


@pytest.mark.parametrize("values", [[0.3] * 10, [0.3]])
def test_identical_values_close_the_interval(values):
    found = stats.estimate(values)
    assert found == Estimate(0.3, 0.3, 0.3, len(values))
    assert found.degenerate


def test_values_that_are_equal_but_for_one():
    """The middle half does not vary in most resamples: BCa may be undefined, the interval must not be."""
    found = stats.estimate([1.0] * 9 + [2.0])
    assert found.value == 1
    assert 1 <= found.low <= found.high <= 2


def test_missing_values_are_not_counted():
    assert stats.estimate([*SKEWED, NAN, NAN]) == stats.estimate(SKEWED)
    assert stats.estimate([*SKEWED, NAN]).n == 20


@pytest.mark.parametrize("values", [[], [NAN, NAN]])
def test_nothing_known(values):
    found = stats.estimate(values)
    assert found.n == 0
    assert np.isnan([found.value, found.low, found.high]).all()


def test_the_same_data_give_the_same_interval():
    assert stats.estimate(SKEWED) == stats.estimate(SKEWED.copy())
    assert stats.relative_excess(SKEWED, SKEWED[::-1]) == stats.relative_excess(SKEWED, SKEWED[::-1])


def test_scaling():
    assert Estimate(2, 1, 4, 9).scaled(10) == Estimate(20, 10, 40, 9)
    assert Estimate(2, 1, 4, 9).scaled(-1) == Estimate(-2, -4, -1, 9)


@pytest.mark.parametrize(("happened", "n"), [(0, 10), (3, 10), (10, 10), (1, 1), (11, 20)])
def test_shares_have_wilson_intervals(happened, n):
    found = stats.share([True] * happened + [False] * (n - happened))
    p, z = happened / n, reference.norm.ppf(0.975)
    centre, half = p + z**2 / (2 * n), z * sqrt(p * (1 - p) / n + z**2 / (4 * n**2))
    assert (found.value, found.n) == (p, n)
    assert found.low == pytest.approx((centre - half) / (1 + z**2 / n), abs=1e-12)
    assert found.high == pytest.approx((centre + half) / (1 + z**2 / n), abs=1e-12)


def test_a_share_of_nothing():
    found = stats.share([])
    assert found.n == 0
    assert np.isnan(found.value)


def test_a_paired_difference_is_first_minus_second():
    second = SKEWED
    first = second + 0.1 + 0.01 * np.linspace(-1, 1, 20)
    found = stats.paired_difference(first, second)
    assert found.value == pytest.approx(0.1)
    assert 0.09 < found.low < 0.1 < found.high < 0.11  # narrow: the spread that both share does not count
    assert stats.paired_difference(second, first).value == pytest.approx(-0.1)


def test_unpaired_runs_are_left_out_of_a_difference():
    found = stats.paired_difference([1, 2, NAN, 5], [0, NAN, 1, 4])
    assert (found.value, found.n) == (1, 2)


def test_relative_excess():
    first = np.array([1.1, 1.1, 1.2, 1.0])
    found = stats.relative_excess(first, np.ones(4))
    assert found.value == pytest.approx(0.1)
    assert found.low < 0.1 < found.high
    assert stats.relative_excess(np.ones(4), first).value == pytest.approx(1 / 1.1 - 1)


def test_relative_excess_resamples_pairs():
    """Where every run is 30 % faster, so is every resample of runs."""
    found = stats.relative_excess(1.3 * SKEWED, SKEWED)
    assert (found.value, found.low, found.high) == pytest.approx((0.3, 0.3, 0.3))


def test_relative_excess_of_incomplete_data():
    assert stats.relative_excess([], []).n == 0
    found = stats.relative_excess([2.0, 3, NAN], [1.0, NAN, 1])
    assert found == Estimate(1, 1, 1, 1)


def test_the_probability_of_improvement_compares_all_runs():
    """Of 2 and 3 with 1 and 2: three wins and a tie."""
    assert stats.improvement([2.0, 3.0], [1.0, 2.0]).value == 3.5 / 4
    assert stats.improvement([1.0, 2.0], [2.0, 3.0]).value == 0.5 / 4
    found = stats.improvement(SKEWED, SKEWED[::-1])
    assert found.value == 0.5
    assert 0.2 < found.low < 0.5 < found.high < 0.8
    first, second = SKEWED + 0.3, np.random.default_rng(6).exponential(size=20)
    u = reference.mannwhitneyu(first, second).statistic
    assert stats.improvement(first, second).value == pytest.approx(u / 400)


def test_the_probability_of_improvement_where_it_is_certain():
    assert stats.improvement(SKEWED + 100, SKEWED) == Estimate(1, 1, 1, 20)
    assert stats.improvement([1.0] * 5, [1.0] * 5) == Estimate(0.5, 0.5, 0.5, 5)
    assert stats.improvement([NAN, 2.0], [1.0, 1.0]) == Estimate(1, 1, 1, 1)
    assert stats.improvement([], []).n == 0


X = np.array([0.0, 0.1, 0.3, 0.4])


def test_two_lines_cross_where_they_do():
    rising, falling = np.tile(0.5 + X, (6, 1)), np.tile(0.9 - X, (6, 1))
    found, share = stats.crossover(X, rising, falling)
    assert (found.value, found.low, found.high) == pytest.approx((0.2, 0.2, 0.2))
    assert (found.n, share) == (6, 1)


def test_the_mean_curves_cross_with_an_interval_over_runs():
    spread = np.linspace(-0.1, 0.1, 8)[:, None]
    found, share = stats.crossover(X, 0.5 + X + spread, np.tile(0.9 - X, (8, 1)))
    assert found.value == pytest.approx(0.2)
    assert 0.15 < found.low < 0.2 < found.high < 0.25
    assert share == 1


def test_the_interval_of_a_crossover_resamples_runs():
    """A run that is faster by d crosses d / 2 earlier; so the mean curves cross at the mean place."""
    lead = np.random.default_rng(8).normal(scale=0.1, size=8)
    found, _ = stats.crossover(X, 0.5 + X + lead[:, None], np.tile(0.9 - X, (8, 1)))
    wanted = reference.bootstrap(
        (0.2 - lead / 2,), np.mean, confidence_level=0.95, method="percentile", rng=0
    ).confidence_interval
    width = wanted.high - wanted.low
    assert (found.low, found.high) == pytest.approx((wanted.low, wanted.high), abs=0.025 * width)


def test_curves_that_cross_in_some_resamples_only():
    crossing, not_crossing = X - 0.2, np.full(4, -0.15)
    found, share = stats.crossover(X, np.array([crossing, not_crossing]), np.zeros((2, 4)))
    assert found.value == pytest.approx(0.35)
    assert share == pytest.approx(0.75, abs=0.05)  # of (both, both, one twice, the other twice) the last not


def test_curves_that_do_not_cross():
    found, share = stats.crossover(X, np.zeros((5, 4)), np.ones((5, 4)))
    assert np.isnan([found.value, found.low, found.high]).all()
    assert (found.n, share) == (5, 0)


@pytest.mark.parametrize(
    ("difference", "place"),
    [
        ([-1, 1, 1, 1], 0.05),
        ([-1, -1, 0, 1], 0.3),
        ([-3, -1, 1, -1], 0.2),
        ([-1, 1, -1, 1], 0.05),
        ([1, -1, -1, -1], NAN),
        ([0, 1, 1, 1], NAN),
        ([1, -1, 1, 1], 0.2),
    ],
)
def test_the_first_crossing_is_from_below(difference, place):
    assert stats.first_crossing(X, np.array(difference, dtype=float)) == pytest.approx(place, nan_ok=True)


def test_the_interval_covers_what_it_should(monkeypatch):
    """Of 200 sets of 20 normal values, about 95 % of intervals contain the true centre."""
    monkeypatch.setattr(stats, "RESAMPLES", 999)
    sets = np.random.default_rng(7).normal(1.0, 1.0, size=(200, 20))
    found = [stats.estimate(values) for values in sets]
    covered = np.mean([each.low <= 1.0 <= each.high for each in found])
    assert 0.87 <= covered <= 0.99
    missed = [each.low > 1.0 for each in found if not each.low <= 1.0 <= each.high]
    assert 0 < sum(missed) < len(missed)  # on both sides


@settings(derandomize=True, deadline=None, max_examples=25)
@given(st.lists(st.integers(-50, 50), min_size=2, max_size=15))
def test_any_data_have_an_ordered_interval_within_their_range(values):
    found = stats.estimate(values)
    assert found.n == len(values)
    assert min(values) <= found.low <= found.high <= max(values)
    assert found.degenerate or len(set(values)) > 1
