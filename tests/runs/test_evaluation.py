"""What is measured of a policy, and how one run becomes one row."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from crawler_bench.config.schema import RunConfig, override
from crawler_bench.gait import metrics
from crawler_bench.gait.rollout import rollout
from crawler_bench.runs.evaluation import measure, read_evaluation
from crawler_bench.runs.results import summarize, typical_run
from crawler_bench.runs.store import NotARunError
from crawler_bench.runs.sweep import Cell, Outcome

TIMES = {"starts": 3, "warm_up": 20, "duration": 100, "settle": 50, "gait": 100, "evaluation.noise": [0, 0.1]}
RUN = override(RunConfig(agent="random", decisions=0), TIMES, "test")
STALLS_AT_TIMES = np.eye(10)[[5, 4, 9, 1, 9, 0, 6, 5, 8, 2]]  # from the first start and the last


def crawl(table, start: int, duration: float, noise: float = 0.0):
    numbers = {"warm_up": 20, "duration": duration, "noise": noise}
    return rollout(RUN.parameters, table, start=(RUN.evaluation.seed, start), policy_seed=7, **numbers)


@pytest.fixture(scope="module")
def mixed():
    return measure(RUN, 7, STALLS_AT_TIMES, RUN.evaluation)


def test_a_speed_is_that_of_the_duration_whatever_follows():
    table = 0.5 * np.eye(10) + 0.05
    starts = measure(RUN, 7, table, RUN.evaluation).starts
    for row in starts.to_dict("records"):
        assert row["speed"] == metrics.speed(crawl(table, int(row["start"]), 100, row["noise"]))
    assert starts["speed"].nunique() == len(starts) == 6


def test_the_gait_is_that_of_the_first_start_that_does_not_stall(mixed):
    assert mixed.starts["stalled"][:3].tolist() == [True, False, True]
    expected = crawl(STALLS_AT_TIMES, 1, 150).after(50)
    np.testing.assert_array_equal(mixed.gait.displacement, expected.displacement)


def test_a_row_tells_all_starts_from_those_that_move(mixed):
    row, quiet = summarize(mixed, pd.DataFrame()), mixed.starts[:3]
    assert row["speed"] == pytest.approx(quiet["speed"].mean())
    assert row["speed_moving"] == quiet["speed"][1]
    assert row["stall_share"] == pytest.approx(2 / 3)
    cycles = pd.DataFrame({"start": [1, 1], "cycle": [0, 1], "duration": [1.0, 3.0]})
    assert summarize(replace(mixed, cycles=cycles), pd.DataFrame())["waves_per_tau"] == 0.5


def test_the_end_of_learning_is_its_last_tenth(mixed):
    points = np.arange(1.0, 101)
    learning = pd.DataFrame({"decisions": points, "time": points, "distance": np.maximum(0, points - 91)})
    row = summarize(mixed, learning.assign(gradient_updates=3))
    assert row["speed_learning_end"] == 1
    assert row["speed_learning"] == pytest.approx(0.09)
    assert (row["decisions"], row["gradient_updates"]) == (100, 3)


def outcomes(rows) -> tuple[pd.DataFrame, list[Outcome]]:
    names = [f"run-{seed}" for seed in range(len(rows))]
    runs = pd.DataFrame(rows, columns=["policy", "reward"]).assign(seed=range(len(rows)), run=names)
    found = [Outcome(Cell("e", RUN, seed), Path(name), Path(name)) for seed, name in enumerate(names)]
    return runs, found


def test_the_run_to_show_is_the_median_one_of_the_commonest_policy():
    runs, found = outcomes([("a", 9.0), ("b", 3.0), ("b", 1.0), ("c", 8.0), ("b", 2.0)])
    assert typical_run(runs, found).cell.seed == 4
    assert typical_run(runs, found[:4]).cell.seed == 2  # the lower one of two
    with pytest.raises(RuntimeError, match="nothing to show"):
        typical_run(runs, [Outcome(found[0].cell, None, None, "failed")])


def test_the_run_to_show_has_the_cycle_that_most_have(tmp_path):
    """Every run has its own policy; the median by reward is the one with an odd cycle."""
    found = [Outcome(Cell("a", RUN, seed), tmp_path / f"run-{seed}", None, "") for seed in range(5)]
    runs = pd.DataFrame({
        "run": [f"run-{seed}" for seed in range(5)], "seed": range(5), "policy": [*"abcde"],
        "reward": [1.0, 2.0, 3.0, 4.0, 5.0], "cycle_duration": [25.3, 25.34, 33.9, np.nan, 25.3],
    })  # fmt: skip
    assert typical_run(runs, found).cell.seed == 1  # of those the nearest to the middle by reward


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04", b"nonsense"])
@pytest.mark.parametrize("name", ["gait.npz", "table.csv", "starts.csv"])
def test_a_damaged_evaluation_is_named_in_one_line(tmp_path, mixed, name, content):
    np.savetxt(tmp_path / "table.csv", mixed.table, delimiter=",")
    for each in ("starts", "cycles", "nodes"):
        getattr(mixed, each).to_csv(tmp_path / f"{each}.csv", index=False)
    np.savez_compressed(tmp_path / "gait.npz", **vars(mixed.gait))
    assert read_evaluation(tmp_path).table.shape == (10, 10)
    (tmp_path / name).write_bytes(content)
    with pytest.raises(NotARunError, match="is damaged") as caught:
        read_evaluation(tmp_path)
    assert "\n" not in str(caught.value)
