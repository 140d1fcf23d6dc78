"""The summary of a benchmark against numbers worked out by hand."""

import numpy as np
import pandas as pd
import pytest

from crawler_bench.benchmark.curves import decisions_to_final, noise_area, noise_curves
from crawler_bench.benchmark.summary import METRICS, measure_runs, metric, summarize_benchmark
from crawler_bench.statistics import estimates
from tests.benchmark.frames import NAN, curve, evaluated, run, runs_of

SPEEDS = [1.0, 2, 3, 4, 5, 6, 7, 100]


def summarize(rows, evaluations=None, curves=None):
    summary = summarize_benchmark(
        pd.DataFrame(rows),
        evaluated(rows) if evaluations is None else evaluations,
        pd.DataFrame() if curves is None else curves,
        lambda agent, mode, regularization, name: f"{agent}-{mode}-{regularization:g}-{name}",
    )
    return summary.set_index(["agent", "mode", "regularization", "metric"])


def of(summary, name, agent="a", mode="deterministic", regularization=0.0):
    return summary.loc[(agent, mode, regularization, name)]


def test_a_row_a_cell_with_everything_in_it():
    rows = [run(agent, level, seed) for agent in ("b", "a") for level in (0.0, 0.01) for seed in range(3)]
    summary = summarize(rows)
    assert list(summary.columns) == ["value", "low", "high", "n", "hash"]
    assert len(summary) == 4 * (len(METRICS) + 2)  # two amplitudes of noise
    assert summary.index.is_unique
    assert list(summary.index.unique("agent")) == ["b", "a"]  # as the runs stand
    assert of(summary, "speed", "b", regularization=0.01)["hash"] == "b-deterministic-0.01-speed"
    for name in summary.index.unique("metric"):
        assert metric(name).name == name


@pytest.mark.parametrize(
    ("name", "column"),
    [("speed", "speed"), ("speed_moving", "speed_moving"), ("speed_learning", "speed_learning_end"),
     ("reward", "reward"), ("cycle_duration", "cycle_duration"), ("cycles", "cycles"),
     ("wave_order", "wave_order"), ("peak_contraction", "peak_contraction"),
     ("strain_gradient", "strain_gradient"), ("unused_muscles", "unused_muscles"),
     ("power_per_distance", "power_per_distance"), ("off_diagonal", "off_diagonal"),
     ("gradient_updates", "gradient_updates")],
)  # fmt: skip
def test_interquartile_means_with_their_intervals(name, column):
    found = of(summarize(runs_of("a", column, SPEEDS)), name)
    wanted = estimates.estimate(SPEEDS)
    assert found["value"] == pytest.approx(4.5)  # of 3, 4, 5, 6
    assert (found["value"], found["low"], found["high"], found["n"]) == (
        wanted.value, wanted.low, wanted.high, 8,
    )  # fmt: skip


def test_rare_stalls_are_not_trimmed_away():
    found = of(summarize(runs_of("a", "stall_share", [0.0] * 8 + [1.0, 0.5])), "stall_share")
    assert found["value"] == pytest.approx(0.15)
    assert found["low"] < 0.15 < found["high"]


def test_a_share_of_runs_counts_runs_without_any_gait():
    """Wilson's interval; a wave from head to tail is none from tail to head, and NaN is no wave."""
    found = of(summarize(runs_of("a", "wave_order", [0.9, 0.7, 0.8, -0.9, 0.2, NAN])), "wave_share")
    wanted = estimates.share([True, True, True, False, False, False])
    assert (found["value"], found["low"], found["high"], found["n"]) == (0.5, wanted.low, wanted.high, 6)


def test_the_share_exactly_on_the_diagonal():
    assert (
        of(summarize(runs_of("a", "off_diagonal", [0.0, 0.0, 0.1, 0.005])), "diagonal_share")["value"] == 0.5
    )


def test_missing_values_are_not_counted():
    found = of(summarize(runs_of("a", "cycle_duration", [40.0, NAN, 42, NAN])), "cycle_duration")
    assert (found["value"], found["n"]) == (41, 2)
    nothing = of(summarize(runs_of("a", "cycle_duration", [NAN, NAN])), "cycle_duration")
    assert nothing["n"] == 0
    assert nothing[["value", "low", "high"]].isna().all()


def test_equal_runs_close_the_interval():
    summary = summarize(runs_of("wave", "speed", [0.00565] * 10, reward=0.00113))
    for name in ("speed", "reward", "noise_area", "regret", "stall_share", "speed_noise_0.4"):
        found = of(summary, name, "wave")
        assert found["low"] == found["value"] == found["high"]
        assert found["n"] == 10
    assert of(summary, "regret", "wave")["value"] == 0


def test_regret_is_to_the_best_of_the_same_regularization():
    rows = [
        *runs_of("good", "reward", [3.0, 5.0]), *runs_of("bad", "reward", [1.0, 2.0]),
        *runs_of("bad", "reward", [30.0, 20.0], regularization=0.01),
    ]  # fmt: skip
    summary = summarize(rows)
    assert of(summary, "regret", "bad")["value"] == pytest.approx(2.5)
    assert of(summary, "regret", "bad")["low"] >= 2
    assert of(summary, "regret", "good")["value"] == 0
    assert of(summary, "regret", "bad", regularization=0.01)["value"] == 0


def test_speed_under_noise_is_a_mean_over_starts():
    rows = runs_of("a", "speed", [1.0, 1.0])
    noisy = evaluated(rows, {"a": {0.0: 1.0, 0.1: 4.0}}, starts=2)
    noisy.loc[(noisy["start"] == 1) & (noisy["noise"] == 0.1), "speed"] = 2.0
    summary = summarize(rows, noisy)
    assert of(summary, "speed_noise_0.1")["value"] == 3
    assert metric("speed_noise_0.1").heading == "speed at s = 0.1 (L/tau)"


def test_the_area_under_the_noise_curve_weighs_amplitudes_by_their_distance():
    rows = [run("a"), run("b")]
    noisy = noise_curves(
        evaluated(rows, {"a": {0.0: 4.0, 0.1: 2.0, 0.4: 0.0}, "b": {0.0: 3.0, 0.1: 3.0, 0.4: 3.0}})
    )
    area = noise_area(noisy)
    assert area.loc["a"].item() == pytest.approx((0.1 * 3 + 0.3 * 1) / 0.4)
    assert area.loc["b"].item() == pytest.approx(3)


def test_the_area_needs_the_whole_curve():
    rows = [run("a"), run("b")]
    noisy = noise_curves(evaluated(rows, {"a": {0.0: 4.0, 0.1: 2.0}, "b": {0.0: 3.0, 0.1: 2.0, 0.4: 3.0}}))
    assert noise_area(noisy).isna().tolist() == [True, False]
    assert noise_area(noise_curves(evaluated(rows, {"a": {0.0: 4.0}, "b": {0.0: 3.0}}))).isna().all()


def decisions(speed):
    speed = np.asarray(speed, dtype=float)
    return decisions_to_final(10.0 * np.arange(1, speed.size + 1), speed)


def test_ninety_percent_of_a_ramp():
    """The final speed is the mean of 91 to 100, 95.5: 90 % are 85.95 (89 % are 85.0, 91 % are 86.9)."""
    assert decisions(range(1, 101)) == 860


def test_a_step_is_smoothed_over_five_windows():
    """Around the step the smoothed speed is 0.2, 0.4, 0.6, 0.8 and, two windows after it, 1."""
    assert decisions([0] * 10 + [1] * 10) == 130


def test_an_early_burst_does_not_count():
    assert decisions([0.4] * 5 + [1] * 5 + [0.4] * 10 + [1] * 20) == 230


@pytest.mark.parametrize(
    "speed",
    [[], [0] * 20, [-1] * 20, [1] * 20 + [0.5] * 20, [0] * 20 + [1] * 18 + [0, 0], [NAN] * 20],
    ids=["no curve", "stands still", "goes back", "loses speed", "does not hold it", "unknown"],
)
def test_what_never_learns(speed):
    assert np.isnan(decisions(speed))


def test_what_is_as_fast_from_the_start_gets_the_first_window():
    assert decisions([1.0] * 20) == 10
    assert decisions([1.05] * 10 + [1.0] * 10) == 10


def test_unknown_windows_are_passed_over():
    assert decisions([NAN] + [0] * 9 + [1] * 10) == 130
    assert decisions([0] * 10 + [1, NAN] + [1] * 8) == 130


def test_a_learning_curve_belongs_to_both_modes():
    rows = [run("a", seed=seed, mode=mode) for mode in ("deterministic", "stochastic") for seed in (0, 1)]
    curves = pd.concat([curve("a", seed=seed, speed=[0.0] * 10 + [1.0] * 10) for seed in (0, 1)])
    other = curve("a", 0.01, 0, speed=[0.0] * 20)
    summary = summarize([*rows, run("still")], curves=pd.concat([curves, other]))
    for mode in ("deterministic", "stochastic"):
        found = of(summary, "decisions_to_final", mode=mode)
        assert (found["value"], found["n"]) == (130, 2)
    assert of(summary, "decisions_to_final", "still")["n"] == 0


def test_nothing_is_added_to_the_runs_that_were_given():
    rows = pd.DataFrame(runs_of("a", "speed", SPEEDS))
    before = rows.copy()
    measured = measure_runs(rows, evaluated(rows.to_dict("records")))
    assert len(measured) == len(rows)
    pd.testing.assert_frame_equal(rows, before)
