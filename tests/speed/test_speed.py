"""The speed measurements: that they measure what is asked and keep it; never how long anything takes."""

import json
import subprocess
import sys
import time
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from crawler_bench.report import blocks
from crawler_bench.report import speed as report
from speed import command, learning, start_up
from speed.history import History
from speed.loops import solve_tridiagonal
from speed.measure import Effort, Measurement, Side, compare, summarize
from speed.physics import diagonal_actions

ROOT = Path(report.__file__).parents[2]
GOAL_FAILS = Measurement("ratio", "crawler", 0.4, "steps", "snail", at_least=0.5)
GOAL_MET = Measurement("value", "memory", 16.0, "bytes", at_most=16.0)
MANIFEST = {
    "finished": "2026-01-01T00:00:00+00:00", "git": {"commit": "0123456789abcdef", "dirty": False},
    "machine": {"cpu": "abacus", "cores": 1}, "packages": {"numpy": "2.0"}, "python": "3.11",
    "wall_clock_seconds": 1.0,
}  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A quick measurement in a process of its own, as the command is called."""
    out = tmp_path_factory.mktemp("results") / "speed"
    words = [sys.executable, "-m", "speed", "--quick", "--out", str(out)]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return out


def test_every_kind_is_measured(folder: Path) -> None:
    measured = History(folder).measurements()
    assert (measured["value"] > 0).all()
    sizes = {kind: sorted(set(rows["size"])) for kind, rows in measured.groupby("kind")}
    assert sizes["segments"] == [10, 50, 200, 1000]
    assert sizes["batch"] == [1, 16, 256, 4096]
    ratios = measured[measured["kind"] == "ratio"]
    assert (ratios["low"] <= ratios["value"]).all()
    assert (ratios["value"] <= ratios["high"]).all()
    assert (ratios["per_second"] > 0).all()
    assert ratios["against"].str.contains("Swimmer").any() == bool(find_spec("mujoco"))


def test_the_commit_measured_has_a_row(folder: Path) -> None:
    (row,) = History(folder).commits().to_dict("records")
    manifest = json.loads((folder / "manifest.json").read_text())
    assert manifest["quick"] is True
    assert (row["date"], row["cpu"]) == (manifest["finished"], manifest["machine"]["cpu"])
    assert row["commit"] == (manifest["git"]["commit"][:10] if manifest["git"] else "")


def test_figures_are_drawn(folder: Path) -> None:
    for name in ("ratios", "segments", "batch", "history"):
        assert (folder / f"{name}.png").stat().st_size > 1000
        assert (folder / f"{name}.svg").stat().st_size > 1000


def test_the_documentation_is_made_of_it(folder: Path) -> None:
    made = blocks.blocks(folder.parent / "paper")
    for name in [name for name in made if name.startswith("speed")]:
        assert made[name]().startswith("| ")


def test_without_results_the_documentation_says_so(tmp_path: Path) -> None:
    made = report.blocks(tmp_path)
    assert {block() for block in made.values()} == {report.NOT_MEASURED}


@pytest.fixture
def measure(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    """The whole command with given measurements, in this process: exit code."""
    monkeypatch.setattr(command, "use_one_core", lambda pin: None)
    monkeypatch.setattr(command.figures, "draw", lambda history, folder: None)

    def run(*measured: Measurement, quick: bool = False) -> int:
        monkeypatch.setattr(command, "PARTS", (given := lambda effort: list(measured),))
        given.__name__ = "given"
        return command.main(["--out", str(tmp_path), *["--quick"] * quick])

    return run


def test_a_goal_that_fails_ends_the_command_and_is_named(measure, capsys) -> None:
    assert measure(GOAL_MET) == 0
    assert capsys.readouterr().err == ""
    assert measure(GOAL_FAILS, GOAL_MET) == 1
    assert capsys.readouterr().err == "goal failed: crawler against snail: 0.4, to be >= 0.5\n"


def test_a_quick_measurement_names_what_fails_and_ends_well(measure, capsys) -> None:
    assert measure(GOAL_FAILS, quick=True) == 0
    assert "crawler against snail" in capsys.readouterr().err


def test_what_was_measured_before_stays(measure, tmp_path: Path) -> None:
    files = [tmp_path / "commits.csv", tmp_path / "measurements.csv"]
    measure(GOAL_MET)
    before = [path.read_text() for path in files]
    measure(GOAL_FAILS, GOAL_MET)
    after = [path.read_text() for path in files]
    assert all(new.startswith(old) for new, old in zip(after, before, strict=True))
    assert [len(text.splitlines()) for text in after] == [1 + 2, 1 + 3]


def test_other_columns_are_not_appended_to(tmp_path: Path) -> None:
    (tmp_path / "commits.csv").write_text("date,commit\n2026-01-01,abc\n")
    with pytest.raises(ValueError, match="other columns"):
        History(tmp_path).append(MANIFEST, [GOAL_MET])
    assert (tmp_path / "commits.csv").read_text() == "date,commit\n2026-01-01,abc\n"


def test_the_latest_commit_is_the_one_shown(tmp_path: Path) -> None:
    history = History(tmp_path)
    history.append(MANIFEST, [GOAL_FAILS])
    history.append(MANIFEST | {"finished": "2026-02-01T00:00:00+00:00"}, [GOAL_MET])
    assert list(history.latest()["what"]) == ["memory"]
    shown = report.blocks(tmp_path)
    assert "memory (bytes)" in shown["speed"]()
    assert "crawler" not in shown["speed"]()
    assert shown["speed commits"]().count("`0123456`") == 2


@pytest.mark.parametrize(
    ("value", "goals", "met"),
    [(2.0, {"at_least": 2.0}, True), (1.9, {"at_least": 2.0}, False), (2.0, {"at_most": 2.0}, True),
     (2.1, {"at_most": 2.0}, False), (2.1, {}, True), (float("nan"), {"at_most": 2.0}, False),
     (float("nan"), {"at_least": 2.0}, False)],
)  # fmt: skip
def test_a_goal_is_met_or_not(value, goals, met) -> None:
    assert Measurement("value", "it", value, "s", **goals).goal_met is met


def spin(calls: int) -> None:
    """Use a millisecond of CPU time per call."""
    end = time.process_time() + 1e-3 * calls
    while time.process_time() < end:
        pass


def test_both_sides_of_a_pair_are_timed_and_counted_in_their_units() -> None:
    row = compare(Side("threes", spin, 3.0), Side("ones", spin), "units", Effort(0.02, 3, 0, True), 2.0)
    assert row.value == pytest.approx(3.0, rel=0.3)
    assert row.per_second == pytest.approx(3000.0, rel=0.3)
    assert (row.what, row.against, row.at_least) == ("threes", "ones", 2.0)


def test_a_ratio_is_the_median_of_ratios() -> None:
    row = summarize("a", "b", "steps", [(2.0, 1.0), (9.0, 1.0), (3.0, 4.0)], 1.5)
    assert (row.value, row.low, row.high, row.per_second) == (2.0, 0.75, 9.0, 3.0)


def test_the_solver_that_is_the_peer_solves() -> None:
    rng = np.random.default_rng(0)
    lower, upper = rng.uniform(0.5, 1.0, (2, 11))
    diagonal, side = rng.uniform(2.5, 3.0, 11), rng.standard_normal((1, 11))
    matrix = np.diag(diagonal) + np.diag(lower[1:], -1) + np.diag(upper[:-1], 1)
    expected = np.linalg.solve(matrix, side[0])[0]
    total = solve_tridiagonal(lower, diagonal, upper, side, np.empty((2, 11)), 3)
    assert total == pytest.approx(3 * expected, rel=1e-12)


def test_the_recorded_diagonal_crawls_from_tail_to_head() -> None:
    actions = diagonal_actions(2000)[1000:]
    moved = np.diff(actions)
    steps = moved[moved != 0]
    kinds, counts = np.unique(steps, return_counts=True)
    assert kinds[counts.argmax()] == -1
    assert counts.max() > 3 * np.sort(counts)[-2]
    assert set(actions) == set(range(10))


def test_the_time_of_an_environment_is_added_up(monkeypatch: pytest.MonkeyPatch) -> None:
    step = learning.CrawlerVecEnv.step_wait
    monkeypatch.setattr(learning.CrawlerVecEnv, "step_wait", lambda env: (spin(10), step(env))[1])
    env, plain = learning.TimedVecEnv(learning.CrawlerVecEnv(2)), learning.CrawlerVecEnv(2)
    for each in (env, plain):
        each.seed(0)
        each.reset()
    spin(10)  # not in the environment
    before = time.process_time()
    stepped = [env.step(np.array([i, 1]))[0] for i in range(5)]
    taken = time.process_time() - before
    assert 0.05 <= env.seconds <= taken
    assert np.array_equal(stepped, [plain.step(np.array([i, 1]))[0] for i in range(5)])


def test_the_time_of_a_process_is_its_own_and_its_cache_is_the_one_given(tmp_path: Path) -> None:
    code = (
        "import os, pathlib; pathlib.Path(os.environ['CRAWLER_BENCH_CACHE'], 'seen').touch(); sum(range({}))"
    )
    short, long = (start_up.cpu_seconds("-c", code.format(n), cache=tmp_path) for n in (1, 30_000_000))
    assert (tmp_path / "seen").is_file()
    assert 0.0 < short < long


def test_what_is_committed_has_every_commit_measured() -> None:
    history = History(ROOT / "results" / "speed")
    commits, measured = history.commits(), history.measurements()
    assert list(measured["date"].unique()) == list(commits["date"])
    assert commits["date"].is_monotonic_increasing
    assert not commits["dirty"].any()
    assert isinstance(history.latest(), pd.DataFrame)
