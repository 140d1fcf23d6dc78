"""Agents in pairs, against closed forms and brute force."""

from itertools import product

import numpy as np
import pandas as pd
import pytest

from crawler_bench.benchmark.keys import select
from crawler_bench.benchmark.pairwise import COMPARED, compare
from crawler_bench.statistics import estimates
from crawler_bench.statistics.significance import permutation_p, seeds_needed
from tests.benchmark.frames import NAN, evaluated, run, runs_of

RNG = np.random.default_rng(3)
SLOW, OTHER = 1 + 0.1 * RNG.normal(size=(2, 10))


def pair(rows, metric="speed", first="a", second="b", speeds=None):
    pairs = compare(pd.DataFrame(rows), evaluated(rows, speeds))
    (found,) = select(pairs, metric=metric, first_agent=first, second_agent=second).to_dict("records")
    return pd.Series(found)


@pytest.mark.parametrize("metric", ["speed", "reward", "cycle_duration", "noise_area"])
def test_the_difference_is_first_minus_second(metric):
    column = "speed" if metric == "noise_area" else metric
    found = pair([*runs_of("a", column, SLOW + 1), *runs_of("b", column, OTHER)], metric)
    wanted = estimates.paired_difference(SLOW + 1, OTHER)
    assert found["difference"] == pytest.approx(wanted.value)
    assert (found["low"], found["high"]) == pytest.approx((wanted.low, wanted.high), rel=0.001)
    assert 0 < found["low"] < found["difference"] < found["high"]
    assert (found["n"], found["degenerate"]) == (10, False)
    assert found["improvement"] == 1
    relative = estimates.relative_excess(SLOW + 1, OTHER)
    assert found["relative"] == pytest.approx(relative.value)
    turned = pair([*runs_of("a", column, OTHER), *runs_of("b", column, SLOW + 1)], metric)
    assert turned["difference"] == pytest.approx(-wanted.value)
    assert turned["improvement"] == 0
    assert turned["p"] == found["p"]


@pytest.mark.parametrize("least", [0.0, -1.0])
def test_nothing_is_relative_to_a_second_that_stands_still_in_a_run(least):
    found = pair([*runs_of("a", "speed", SLOW), *runs_of("b", "speed", [least, *OTHER[1:]])])
    assert found[["relative", "relative_low", "relative_high"]].isna().all()
    assert found["n"] == 10


def test_pairs_are_of_the_same_seed():
    """The order of the rows does not matter, nor do runs whose partner is missing."""
    first = runs_of("a", "speed", [11.0, 22, 33, 44, NAN, 5])
    second = runs_of("b", "speed", [10.0, 20, 30, 40, 50])
    found = pair([*first[::-1], *second])
    assert (found["n"], found["difference"]) == (4, 2.5)
    assert found["p"] == 2 / 2**4


@pytest.mark.parametrize("n", [2, 5, 6, 10])
def test_the_permutation_test_is_exact(n):
    a, b = RNG.normal(0.4, 1, n), RNG.normal(0, 1, n)
    means = [abs(np.mean(np.array(signs) * (a - b))) for signs in product((1, -1), repeat=n)]
    assert permutation_p(a, b) == pytest.approx(np.mean(np.array(means) >= abs((a - b).mean()) - 1e-12))


def test_the_least_p_of_ten_seeds():
    assert permutation_p(SLOW + 1, SLOW) == pytest.approx(2 / 1024)
    assert permutation_p(SLOW, SLOW) == 1
    assert permutation_p(SLOW[:1], SLOW[1:2]) == 1
    assert np.isnan(permutation_p(SLOW[:0], SLOW[:0]))


def holm(p):
    order = np.argsort(p)
    adjusted = np.maximum.accumulate(np.sort(p) * np.arange(len(p), 0, -1)).clip(max=1)
    return adjusted[np.argsort(order)]


def benjamini_hochberg(p):
    order = np.argsort(p)
    scaled = np.sort(p) * len(p) / np.arange(1, len(p) + 1)
    return np.minimum.accumulate(scaled[::-1])[::-1].clip(max=1)[np.argsort(order)]


@pytest.fixture(scope="module")
def four():
    """Four agents at two regularizations, one without cycles."""
    rows = [
        row
        for level in (0.0, 0.01)
        for i, agent in enumerate("abcd")
        for row in runs_of(
            agent, "speed", SLOW + 0.08 * i * RNG.normal(1, 1, 10), regularization=level,
            cycle_duration=NAN if agent == "d" else 40 + i + level,
        )
    ]  # fmt: skip
    return compare(pd.DataFrame(rows), evaluated(rows))


def test_every_pair_is_there_once(four):
    names = ["first_agent", "first_regularization", "second_agent", "second_regularization", "metric"]
    assert not four.duplicated(names).any()
    same = four[four["first_regularization"] == four["second_regularization"]]
    assert same.groupby(["metric", "first_regularization"]).size().tolist() == [6] * 2 * len(COMPARED)
    own = four[four["first_regularization"] != four["second_regularization"]]
    assert (own["first_agent"] == own["second_agent"]).all()
    assert set(zip(own["first_regularization"], own["second_regularization"], strict=True)) == {(0.0, 0.01)}
    assert own.groupby("metric").size().to_dict() == {"cycle_duration": 4, "noise_area": 4, "speed": 4}


def test_p_is_corrected_over_the_pairs_of_a_metric_and_regularization(four):
    for level, other in ((0.0, 0.0), (0.01, 0.01), (0.0, 0.01)):
        family = select(four, metric="speed", first_regularization=level, second_regularization=other)
        p = family["p"].to_numpy()
        assert len(set(p)) > 2
        assert family["p_holm"].to_numpy() == pytest.approx(holm(p))
        assert family["p_fdr"].to_numpy() == pytest.approx(benjamini_hochberg(p))
        assert (family["p_holm"] > family["p"]).any()


def test_pairs_that_cannot_be_compared_are_no_tests(four):
    cycles = select(four, metric="cycle_duration", first_regularization=0.0)
    missing = cycles[(cycles["first_agent"] == "d") | (cycles["second_agent"] == "d")]
    assert (missing["n"] == 0).all()
    assert missing[["difference", "improvement", "p", "p_holm", "seeds_needed"]].isna().all(axis=None)
    assert not missing["degenerate"].any()
    within = cycles[(cycles["second_regularization"] == 0.0) & (cycles["n"] > 0)]
    assert within["p_holm"].to_numpy() == pytest.approx([3 * 2 / 1024] * 3)  # of three tests, not of six


def test_equal_runs_are_marked():
    rows = [*runs_of("a", "speed", [3.0] * 10), *runs_of("b", "speed", [2.0] * 10)]
    found = pair(rows)
    assert (found["difference"], found["low"], found["high"], found["n"]) == (1, 1, 1, 10)
    assert found["degenerate"]
    assert (found["improvement"], found["improvement_low"], found["improvement_high"]) == (1, 1, 1)
    assert (found["relative"], found["seeds_needed"]) == (0.5, 2)
    same = pair([*runs_of("a", "speed", [3.0] * 10), *runs_of("b", "speed", [3.0] * 10)])
    assert (same["difference"], same["improvement"], same["p"], same["p_holm"]) == (0, 0.5, 1, 1)
    assert same["degenerate"]


def test_one_run_and_none():
    assert pair([run("a", speed=2.0), run("b", speed=1.0)])["n"] == 1
    assert pair([run("a", speed=NAN), run("b", speed=1.0)])["n"] == 0
    assert compare(pd.DataFrame([run("a")]), evaluated([run("a")])).empty


@pytest.mark.parametrize(("effect", "seeds"), [(0.2, 199), (0.5, 34), (0.8, 15), (1.0, 10), (10.0, 3)])
def test_the_seeds_of_a_paired_t_test(effect, seeds):
    """As tables of the power of the paired t-test have them."""
    noise = RNG.normal(size=12)
    noise = (noise - noise.mean()) / noise.std(ddof=1)
    second = 10 + RNG.normal(size=12)
    second += 10 - second.mean()
    assert seeds_needed(second + 3 + noise / effect, second) == seeds


def test_seeds_where_there_is_no_answer():
    assert np.isnan(seeds_needed(SLOW + 1, 0 * SLOW))
    assert np.isnan(seeds_needed(SLOW[:1], SLOW[:1]))
    assert seeds_needed(np.full(5, 3.0), np.full(5, 2.0)) == 2
    assert seeds_needed(np.array([3.0, 3 + 1e-9, 3]), np.full(3, 2.0)) == 2


def test_many_seeds_for_a_small_difference():
    """The closed form of the normal test goes on where the solver of the t-test ends."""
    noise = np.array([1.0, -1.0, 1.0, -1.0])
    noise /= noise.std(ddof=1)
    second = np.full(4, 10.0)
    above, below = (seeds_needed(second + noise / effect, second) for effect in (0.0101, 0.0099))
    assert above * 0.0101**2 == pytest.approx(7.849, abs=0.002)
    assert below * 0.0099**2 == pytest.approx(7.849, abs=0.002)
    assert seeds_needed(second + 1e9 * noise, second) == pytest.approx(7.849e18, rel=1e-3)


CURVES = {"a": {0.0: 3.0, 0.2: 1.0, 0.4: 1.0}, "b": {0.0: 2.0, 0.2: 2.0, 0.4: 2.0}}


@pytest.mark.parametrize(("first", "overtakes"), [("a", "second"), ("b", "first")])
def test_where_the_noise_curves_cross(first, overtakes):
    second = "b" if first == "a" else "a"
    rows = [*runs_of(first, "speed", [1.0] * 4), *runs_of(second, "speed", [1.0] * 4)]
    found = pair(rows, "noise_area", first, second, CURVES)
    assert (found["crossover"], found["crossover_low"], found["crossover_high"]) == pytest.approx((0.1,) * 3)
    assert (found["crossover_share"], found["overtakes"]) == (1, overtakes)
    assert np.isnan(pair(rows, "speed", first, second, CURVES)["crossover"])


def test_curves_that_do_not_cross():
    rows = [*runs_of("a", "speed", [2.0] * 4), *runs_of("b", "speed", [1.0] * 4)]
    found = pair(rows, "noise_area")
    assert np.isnan(found["crossover"])
    assert (found["crossover_share"], found["overtakes"]) == (0, "")


def test_ten_percent_faster_without_regularization():
    rows = [*runs_of("a", "speed", 1.1 * SLOW), *runs_of("a", "speed", SLOW, regularization=0.01)]
    found = pair(rows, "speed", "a", "a")
    assert (found["first_regularization"], found["second_regularization"]) == (0.0, 0.01)
    assert (found["relative"], found["relative_low"], found["relative_high"]) == pytest.approx((0.1,) * 3)
