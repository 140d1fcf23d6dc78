"""Distances at the borders of their rules, groups, caps, resamples and ranks, on planted results."""

import numpy as np
import pandas as pd
import pytest

from crawler_bench.paper.claims import CLAIMS
from crawler_bench.paper.verdicts import Claim, Kind, Results
from crawler_bench.readings.scoring import (
    CAP,
    CORE,
    COUNTED,
    GROUPS,
    UNCOUNTED,
    Score,
    distance,
    group_of,
    rank,
    rescored,
    score,
    total,
)
from crawler_bench.statistics import estimates
from crawler_bench.statistics.estimates import Estimate
from tests.paper.planted import PLANTED, planted

NAN = float("nan")
SEEDS = 5
STORY = {  # what the paper says, as far as the claims that contradict it allow
    "regularized": {"speed_learning_end": 0.0056},
    "unregularized": {"speed_moving": 0.00616, "speed_learning_end": 0.00616, "strain_range": 0.2},
}


def plant(**changes: dict[str, float]) -> Results:
    """What the paper says, with other values for some columns of some experiments."""
    told = {name: STORY.get(name, {}) | changes.get(name, {}) for name in PLANTED}
    return planted(told, seeds=SEEDS, spread=1e-4)


def a_claim(kind: Kind, paper: float | str = "> 0") -> Claim:
    return Claim("name", "text", "source", kind, paper, lambda results: Estimate(NAN, NAN, NAN, 0), ())


@pytest.mark.parametrize(
    ("ours", "far"),
    [(33.0, 0), (36.3, 1), (29.7, 1), (39.6, 2), (47.85, 4.5), (0.0, CAP), (1e6, CAP), (NAN, CAP)],
)
def test_a_number_is_as_far_as_its_difference_in_tenths(ours, far):
    assert distance(a_claim(Kind.NUMBER, 33.0), Estimate(ours, ours, ours, 5)) == pytest.approx(far)


@pytest.mark.parametrize(("share", "far"), [(1, 0), (0.8, 0), (0.6, 1), (0.4, 2), (0, 4)])
def test_a_share_is_as_far_as_it_falls_short_of_four_fifths(share, far):
    ours = estimates.share([True] * round(5 * share) + [False] * round(5 * (1 - share)))
    assert distance(a_claim(Kind.SHARE, "yes"), ours) == far


@pytest.mark.parametrize(
    ("value", "low", "high", "n", "far"),
    [
        (1, 0.1, 2, 5, 0),  # the interval excludes 0
        (1, -1, 3, 5, 1),  # the right sign
        (0, -1, 1, 5, 1),
        (-1, -2, 0, 5, 2),  # one half of the interval on the wrong side
        (-2, -3, -1, 5, 3),
        (-9, -9.1, -8.9, 5, CAP),
        (-1, -1, -1, 5, CAP),  # all runs on the wrong side alike
        (1, 1, 1, 1, 1),  # one run alone shows nothing
        (1, 1, 1, 0, CAP),
    ],
)
def test_an_ordering_is_as_far_as_it_lies_on_the_wrong_side(value, low, high, n, far):
    assert distance(a_claim(Kind.ORDERING), Estimate(value, low, high, n)) == pytest.approx(far)


def test_every_claim_is_in_one_group_or_named_as_not_counted():
    grouped = [name for names in GROUPS.values() for name in names]
    assert len(grouped) == len(set(grouped))
    assert set(grouped) | set(UNCOUNTED) == {claim.name for claim in CLAIMS}
    assert set(grouped) == {claim.name for claim in COUNTED}
    assert set(CORE) <= set(grouped)
    assert group_of("tau") == "frequency"
    assert group_of("crossover") == ""


def test_a_group_counts_once_however_many_claims_it_has():
    distances = dict.fromkeys((claim.name for claim in COUNTED), 0.0)
    one = total(distances | dict.fromkeys(GROUPS["peak"], 2.0))
    many = total(distances | dict.fromkeys(GROUPS["speed"], 2.0))
    assert one == pytest.approx(2 / len(GROUPS))
    assert many == pytest.approx(one)


def test_the_paper_itself_scores_nothing():
    found = score(plant(), range(SEEDS))
    far = found.claims[found.claims["distance"] > 0.2]  # the paper rounds
    assert far.empty, far
    assert found.value == pytest.approx(0, abs=0.02)
    assert found.within
    low, high = found.interval
    assert 0 <= low <= high < 0.1


@pytest.mark.parametrize(
    ("changes", "by"),
    [
        ({"regularized": {"peak_contraction": 0.363}}, 1 / len(GROUPS)),
        ({"regularized": {"peak_contraction": 3.3}}, CAP / len(GROUPS)),
        ({"regularized": {"wave_order": 0.1}}, 4 / len(GROUPS)),
        ({"unregularized": {"unused_muscles": 0}}, 4 / len(GROUPS)),
        ({"regularized": {"waves_per_tau": 0.0286}}, 1 / len(GROUPS)),
    ],
)
def test_the_score_moves_with_the_distance_of_a_claim(changes, by):
    paper, moved = score(plant(), range(SEEDS)), score(plant(**changes), range(SEEDS))
    assert moved.value - paper.value == pytest.approx(by, rel=0.02)
    lower, low, high = paper.better_by(moved)
    assert lower == pytest.approx(by, rel=0.02)
    assert 0 < low <= high


def test_a_failed_core_claim_is_not_within_tolerance_whatever_the_score():
    found = score(plant(regularized={"wave_order": 0.1}), range(SEEDS))
    assert found.value < 1
    assert found.core_failures == ("wave",)
    assert not found.within


def test_failed_runs_count_against_shares_and_silence_costs_the_cap():
    paper = plant()
    kept = paper.runs[~((paper.runs["experiment"] == "regularized") & (paper.runs["seed"] < 2))]
    found = score(Results(kept, paper.evaluations), range(SEEDS))
    claims = found.claims.set_index("claim")
    assert claims.loc["nearest_neighbour", "ours"] == pytest.approx(0.6)
    assert claims.loc["speed", "n"] == 3
    silent = score(Results(pd.DataFrame(), pd.DataFrame()), range(SEEDS))
    assert silent.claims.set_index("claim").loc["speed", "distance"] == CAP
    assert not silent.within


def test_resamples_pair_the_seeds_of_two_readings():
    runs = plant()
    seeds = runs.runs["seed"]
    runs.runs["peak_contraction"] = 0.33 * (1 + 0.05 * seeds)
    worse = Results(runs.runs.assign(peak_contraction=runs.runs["peak_contraction"] * 1.01), runs.evaluations)
    one, other = score(runs, range(SEEDS)), score(worse, range(SEEDS))
    assert np.ptp(one.resamples) > 0.05
    assert np.ptp(other.resamples - one.resamples) < 0.02  # the same runs are drawn for both
    again = score(runs, range(SEEDS))
    assert np.array_equal(one.resamples, again.resamples)


def test_readings_within_tolerance_come_first_by_free_constants_then_score():
    frame = pd.DataFrame(
        [("far, sourced", False, 0, 0.3), ("near, free", True, 7, 0.2), ("near, sourced", True, 2, 0.9),
         ("near, sourced, better", True, 2, 0.8), ("further", False, 0, 3.0)],
        columns=["reading", "within", "free", "score"],
    )  # fmt: skip
    ranked = rank(frame)
    assert ranked["reading"].tolist() == [
        "near, sourced, better", "near, sourced", "near, free", "far, sourced", "further",
    ]  # fmt: skip
    assert ranked["rank"].tolist() == [1, 2, 3, 4, 5]


def test_another_rule_for_the_same_distances():
    readings = pd.DataFrame({"reading": ["default", "b", "c"], "score": [0.5, 1.0, 2.0]})
    claims = pd.DataFrame(
        [(reading, claim, group_of(claim), far)
         for reading, far in (("default", 0.5), ("b", 1.0), ("c", 2.0)) for claim in ("wave", "tau")],
        columns=["reading", "claim", "group", "distance"],
    )  # fmt: skip
    rules = rescored(readings, claims)
    assert rules["default_rank"].tolist() == [1] * len(rules)
    assert rules["rho"].iloc[0] == pytest.approx(1)


def test_the_interval_of_a_score_is_that_of_its_resamples():
    found = Score(1.0, np.linspace(0, 1, 101), pd.DataFrame({"claim": [], "distance": []}))
    assert found.interval == pytest.approx((0.025, 0.975))
