"""Verdicts at the borders of their rules, and every claim of the paper on results with planted answers."""

import numpy as np
import pytest

from crawler_bench.paper.claims import CLAIMS, find_claim, noise_crossover
from crawler_bench.paper.verdicts import Claim, Kind, Results, Verdict, judge, judge_claims
from crawler_bench.statistics.estimates import Estimate
from tests.paper.planted import SEEDS, planted

REPRODUCED, PARTLY, NOT = Verdict.REPRODUCED, Verdict.PARTLY, Verdict.NOT
NAN = float("nan")


def a_claim(kind: Kind, paper: float | str = "> 0", measure=None) -> Claim:
    return Claim("name", "text", "source", kind, paper, measure, ())


@pytest.mark.parametrize("paper", [100.0, -100.0])
@pytest.mark.parametrize(
    ("excess", "verdict"),
    [
        (0, REPRODUCED), (10, REPRODUCED), (-10, REPRODUCED), (10.01, PARTLY), (-10.01, PARTLY),
        (25, PARTLY), (-25, PARTLY), (25.01, NOT), (-25.01, NOT), (-200, NOT),
    ],
)  # fmt: skip
def test_a_number_is_judged_by_its_relative_distance(paper, excess, verdict):
    ours = Estimate(paper + excess, -1e9, 1e9, 10)
    assert judge(a_claim(Kind.NUMBER, paper), ours) is verdict


@pytest.mark.parametrize(
    ("value", "low", "verdict"),
    [
        (1, 1e-12, REPRODUCED),
        (1, 0, PARTLY),
        (1, -1, PARTLY),
        (1e-12, -1, PARTLY),
        (0, -1, NOT),
        (-1, -2, NOT),
    ],
)
def test_an_ordering_is_judged_by_its_interval(value, low, verdict):
    assert judge(a_claim(Kind.ORDERING), Estimate(value, low, 2, 10)) is verdict


@pytest.mark.parametrize(
    ("value", "verdict"),
    [(1, REPRODUCED), (0.8, REPRODUCED), (0.79, PARTLY), (0.5, PARTLY), (0.49, NOT), (0, NOT)],
)
def test_a_share_is_judged_by_its_value(value, verdict):
    assert judge(a_claim(Kind.SHARE, "yes"), Estimate(value, 0, 1, 10)) is verdict


@pytest.mark.parametrize("kind", [Kind.NUMBER, Kind.ORDERING, Kind.SHARE])
@pytest.mark.parametrize(
    "ours", [Estimate(NAN, NAN, NAN, 0), Estimate(NAN, NAN, NAN, 3), Estimate(1, 1, 1, 0)]
)
def test_without_data_there_is_no_verdict(kind, ours):
    assert judge(a_claim(kind, 1.0), ours) is Verdict.MISSING


def test_an_open_claim_is_not_judged():
    assert judge(a_claim(Kind.OPEN), Estimate(0.1, 0, 1, 10)) is Verdict.OPEN
    assert judge(a_claim(Kind.OPEN), Estimate(NAN, NAN, NAN, 0)) is Verdict.OPEN


def test_one_run_alone_shows_no_ordering():
    assert judge(a_claim(Kind.ORDERING), Estimate(1, 1, 1, 1)) is not REPRODUCED


EXPECTED = {
    "wave": 1, "wave_unregularized": 1, "localized": 1, "nearest_neighbour": 1, "diagonal_entries": 100,
    "peak_contraction": 33, "wave_speed": 0.026, "speed": 0.0056, "tau": 17.3333,
    "speed_third_instar": 0.131765,
    "speed_first_instar_slow": 10.9804, "speed_first_instar_fast": 32.9412, "speed_observed": 12.0588,
    "faster": 0.00056, "faster_by": 10, "faster_moving": 0.00112, "faster_moving_by": 20,
    "faster_learning": 0.0011, "faster_learning_by": 20, "unused_muscles": 1, "pairs": 1,
    "larger_gradient": 0.3, "larger_range": 0.1, "smaller_range": -0.1, "power_periodic": 1,
    "power_periodic_unregularized": 1, "power_maximum": 0.75, "power_duration": 0.6, "shorter_cycle": 12,
    "faster_low_noise": 0.0004, "slower_high_noise": 0.0036, "crossing": 1, "crossover": 0.075,
    "maintains_speed": 1, "loses_speed": 0.0042, "uncoordinated": 1, "learning_pays": 0.0046,
    "learning_pays_unregularized": 0.00516, "alpha_gamma": 1,
}  # fmt: skip
NOT_REPRODUCED = {"faster_moving_by", "faster_learning_by", "smaller_range"}  # as planted

# Claims that two gaits with exchanged names meet as well: both have what is claimed.
SURVIVE = {
    "wave", "wave_unregularized", "power_periodic", "power_periodic_unregularized", "speed_observed",
    "learning_pays", "learning_pays_unregularized", "uncoordinated", "alpha_gamma", "smaller_range",
}  # fmt: skip
SPEEDS = {"speed", "speed_third_instar", "speed_first_instar_slow", "speed_first_instar_fast"}  # 10 % apart
SWAPPED = {"regularized": "unregularized", "unregularized": "regularized"}
CLAIM_NAMES = [claim.name for claim in CLAIMS]


def test_every_claim_has_its_own_name_and_is_planted():
    assert sorted(CLAIM_NAMES) == sorted(EXPECTED)
    assert [find_claim(name).name for name in CLAIM_NAMES] == CLAIM_NAMES
    with pytest.raises(ValueError, match="no claim is called 'x'; known are wave"):
        find_claim("x")


@pytest.mark.parametrize("name", CLAIM_NAMES)
def test_a_claim_measures_what_is_planted(name):
    claim = find_claim(name)
    ours = claim.measure(planted())
    assert ours.value == pytest.approx(EXPECTED[name], rel=1e-3)
    assert ours.low <= ours.value <= ours.high
    assert ours.n == SEEDS
    verdict = judge(claim, ours)
    expected = Verdict.OPEN if claim.kind is Kind.OPEN else NOT if name in NOT_REPRODUCED else REPRODUCED
    assert verdict is expected


@pytest.mark.parametrize("name", CLAIM_NAMES)
def test_a_claim_does_not_survive_exchanged_gaits(name):
    claim = find_claim(name)
    ours = claim.measure(planted(names=SWAPPED))
    verdict = judge(claim, ours)
    if name in SURVIVE:
        assert verdict is REPRODUCED
    elif name in SPEEDS:
        assert ours.value == pytest.approx(1.1 * EXPECTED[name], rel=1e-3)
    elif claim.kind is not Kind.OPEN:
        assert verdict is NOT
    if claim.kind is Kind.ORDERING and len(claim.experiments) == 2 and "untrained" not in claim.experiments:
        assert ours.value == pytest.approx(-EXPECTED[name], rel=1e-3)


@pytest.mark.parametrize("name", ["uncoordinated", "learning_pays"])
def test_claims_about_the_untrained_do_not_survive_exchange_with_the_trained(name):
    claim = find_claim(name)
    names = {"regularized": "untrained", "untrained": "regularized"}
    assert judge(claim, claim.measure(planted(names=names))) is NOT


@pytest.mark.parametrize(
    ("claim", "experiment", "column", "fails", "holds"),
    [
        ("pairs", "unregularized", "pairs_together", 1, 2),
        ("unused_muscles", "unregularized", "unused_muscles", 0, 1),
        ("power_periodic", "regularized", "power_periodicity", 0.7, 0.9),
        ("power_periodic_unregularized", "unregularized", "power_periodicity", 0.7, 0.9),
        ("localized", "regularized", "contracted_segments", 2.2, 1.8),
        ("alpha_gamma", "alpha_gamma", "diagonal_distance", 3, 2),
    ],
)
def test_thresholds_of_shares(claim, experiment, column, fails, holds):
    for value, share in ((fails, 0), (holds, 1)):
        assert find_claim(claim).measure(planted({experiment: {column: value}})).value == share


def test_a_wave_towards_the_tail_is_none_and_no_lack_of_one():
    backwards = planted({name: {"wave_order": -0.9} for name in ("regularized", "untrained")})
    assert find_claim("wave").measure(backwards).value == 0
    assert find_claim("uncoordinated").measure(backwards).value == 0


def test_curves_that_never_cross():
    apart = planted({"unregularized": {"noisy": (0.01,) * 5}})
    assert find_claim("crossing").measure(apart).value == 0
    crossing, share = noise_crossover(apart)
    assert np.isnan(crossing.value)
    assert share == 0


def without(results: Results, experiment: str) -> Results:
    runs, evaluations = results.runs, results.evaluations
    return Results(
        runs[runs["experiment"] != experiment], evaluations[evaluations["experiment"] != experiment]
    )


@pytest.mark.parametrize("name", CLAIM_NAMES)
def test_a_claim_about_an_experiment_without_runs_has_no_data(name):
    claim = find_claim(name)
    for experiment in claim.experiments:
        ours = claim.measure(without(planted(), experiment))
        assert ours.n == 0
        assert judge(claim, ours) in (Verdict.MISSING, Verdict.OPEN)


@pytest.mark.parametrize("name", CLAIM_NAMES)
def test_a_claim_about_an_amplitude_that_was_not_measured_has_no_data(name):
    results = planted()
    quiet = Results(results.runs, results.evaluations[results.evaluations["noise"] == 0])
    claim = find_claim(name)
    ours = claim.measure(quiet)
    missing = {"faster_low_noise", "slower_high_noise", "loses_speed", "maintains_speed"}
    assert (judge(claim, ours) is Verdict.MISSING) == (name in missing)


def test_only_seeds_that_both_gaits_have_are_compared():
    results = planted()
    lost = (results.runs["experiment"] == "regularized") & (results.runs["seed"] == 0)
    ours = find_claim("faster").measure(Results(results.runs[~lost], results.evaluations))
    assert ours.n == SEEDS - 1


def test_the_table_of_claims_has_its_columns_and_commands():
    frame = judge_claims(planted(), CLAIMS, " --preset smoke")
    assert list(frame.columns) == [
        "claim", "source", "paper", "ours", "low", "high", "n", "verdict", "command"
    ]  # fmt: skip
    assert len(frame) == len(CLAIMS)
    assert set(frame["verdict"]) <= {verdict.value for verdict in Verdict}
    for claim, command in zip(CLAIMS, frame["command"], strict=True):
        assert command == f"crawler-bench reproduce --claim {claim.name} --preset smoke"
