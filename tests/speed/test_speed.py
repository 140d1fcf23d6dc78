"""The speed measurements: that they measure what is asked and write it; never how long anything takes."""

import json
import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from crawler_bench.report import blocks, speed
from speed.loops import solve_tridiagonal
from speed.measure import summarize

ROOT = Path(blocks.__file__).parents[2]
COLUMNS = {
    "ratios": ["what", "peer", "unit", "per_second", "peer_per_second", "ratio", "ratio_min", "ratio_max",
               "repeats", "goal", "note"],
    "learning": ["learner", "crawlers", "decisions", "gradient_updates", "per_second", "environment_share"],
    "counts": ["what", "diagonal policy", "random actions"],
    "segments": ["integrator", "segments", "seconds"],
    "batch": ["integrator", "size", "seconds"],
    "values": ["what", "value", "unit", "goal"],
}  # fmt: skip
SOLVE, ONE = "general tridiagonal solve, n = 11", "one crawler in steps of dt"
CARTPOLE, SWIMMER = "Gymnasium CartPole-v1, gym.make", "EnvPool Swimmer-v5, 16"
GOALS = {
    ("step of a crawler, diagonal policy", SOLVE): 0.5,
    ("step of a crawler, random actions", SOLVE): 0.5,
    ("crawler, exact, diagonal policy", SOLVE): 2.0,
    ("crawler, exact, random actions", SOLVE): 2.0,
    ("batch of 256, exact", SOLVE): 2.0,
    ("decision, exact, recorded diagonal actions", "in steps of dt"): 4.0,
    ("decision, exact, random actions", "in steps of dt"): 4.0,
    ("batch of 256, exact", ONE): 4.0,
    ("batch of 256, step", ONE): 4.0,
    ("gym.make, recorded diagonal actions", CARTPOLE): 0.8,
    ("gym.make, random", CARTPOLE): 0.8,
    ("SB3 PPO, 8 crawlers", "SB3 PPO, 8 environments that do nothing"): 0.95,
    ("SB3 DQN, 8 crawlers", "SB3 DQN, 8 environments that do nothing"): 0.95,
    ("exponent of the cost against N, step, N >= 50", ""): 1.1,
    ("exponent of the cost against N, exact, N >= 50", ""): 1.1,
    ("memory of a crawler in a batch", ""): 16384.0,
    ("memory of a CrawlerEnv", ""): 16384.0,
} | ({("gym.make_vec of 256", SWIMMER): 30.0} if find_spec("envpool") else {})


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("results") / "performance"
    words = [sys.executable, "-m", "speed", "--quick", "--out", str(out)]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    done = subprocess.run(words, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return out


def test_every_table_has_its_columns(folder: Path) -> None:
    for name, columns in COLUMNS.items():
        table = pd.read_csv(folder / f"{name}.csv")
        assert list(table.columns) == columns
        assert len(table) > 0


def test_every_goal_has_its_row(folder: Path) -> None:
    found = {}
    for name in ("ratios", "values"):
        table = pd.read_csv(folder / f"{name}.csv").assign(**({} if name == "ratios" else {"peer": ""}))
        table = table[table["goal"].notna()]
        found |= dict(zip(zip(table["what"], table["peer"], strict=True), table["goal"], strict=True))
    assert found == GOALS


def test_what_was_measured_was_measured_several_times(folder: Path) -> None:
    ratios = pd.read_csv(folder / "ratios.csv")
    done = ratios[ratios["repeats"] > 0]
    assert (done[["per_second", "peer_per_second", "ratio_min"]] > 0).all().all()
    assert (done["ratio_min"] <= done["ratio"]).all()
    assert (done["ratio"] <= done["ratio_max"]).all()
    assert ratios[ratios["repeats"] == 0]["note"].notna().all()


def test_scaling_covers_its_sizes(folder: Path) -> None:
    segments, batch = (pd.read_csv(folder / f"{name}.csv") for name in ("segments", "batch"))
    assert sorted(set(segments["segments"])) == [2, 5, 10, 20, 50, 100, 200, 500, 1000]
    assert (min(batch["size"]), max(batch["size"])) == (1, 4096)
    assert set(segments["integrator"]) == set(batch["integrator"]) == {"step", "exact"}


def test_gradient_updates_are_counted(folder: Path) -> None:
    learning = pd.read_csv(folder / "learning.csv")
    assert sorted(set(learning["crawlers"])) == [1, 8, 64]
    assert (learning["gradient_updates"] > 0).all()
    ppo = learning[learning["learner"] == "SB3 PPO"]
    assert (ppo["gradient_updates"] == 10 * ppo["decisions"] / 32).all()


def test_figures_and_manifest_are_there(folder: Path) -> None:
    for name in ("ratios", "segments", "batch"):
        assert (folder / f"{name}.png").stat().st_size > 1000
        assert (folder / f"{name}.svg").stat().st_size > 1000
    manifest = json.loads((folder / "manifest.json").read_text())
    assert manifest["quick"] is True
    assert set(manifest["peers"]) == {"envpool", "mujoco"}


def test_the_documentation_is_made_of_it(folder: Path) -> None:
    made = blocks.blocks(folder.parent / "paper")
    for name in [name for name in made if name.startswith("performance")]:
        assert made[name]().startswith("| ")
    assert all(what in made["performance"]() for what, _ in GOALS)


def test_without_results_the_documentation_says_so(tmp_path: Path) -> None:
    made = speed.blocks(tmp_path)
    assert {block() for block in made.values()} == {speed.NOT_MEASURED}


def test_the_solver_that_is_the_peer_solves() -> None:
    rng = np.random.default_rng(0)
    lower, upper = rng.uniform(0.5, 1.0, (2, 11))
    diagonal, side = rng.uniform(2.5, 3.0, 11), rng.standard_normal((1, 11))
    matrix = np.diag(diagonal) + np.diag(lower[1:], -1) + np.diag(upper[:-1], 1)
    expected = np.linalg.solve(matrix, side[0])[0]
    assert solve_tridiagonal(lower, diagonal, upper, side, 3) == pytest.approx(3 * expected, rel=1e-12)


def test_a_ratio_is_the_median_of_ratios() -> None:
    row = summarize("a", "b", "steps", [(2.0, 1.0), (9.0, 1.0), (3.0, 4.0)], 1.5)
    assert (row.per_second, row.peer_per_second) == (3.0, 1.0)
    assert (row.ratio, row.ratio_min, row.ratio_max, row.repeats) == (2.0, 0.75, 9.0, 3)
