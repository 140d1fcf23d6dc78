"""Sweeps: resumable, the same however they are run, and honest about failures."""

import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from crawler_bench.config.schema import RunConfig, override
from crawler_bench.runs import evaluation, store, sweep, training
from crawler_bench.runs.folders import checksums, claims
from crawler_bench.runs.results import read_outcomes
from crawler_bench.runs.sweep import Cell, run_cells

ROOT = Path(store.__file__).parents[2]
SHORT = {"starts": 2, "warm_up": 5, "duration": 40, "settle": 5, "evaluation.noise": [0, 0.1]}
RUN = override(RunConfig(), {"agent": "agents.qlearning:QLearning", "decisions": 2000} | SHORT, "test")
UNREGULARIZED = override(RUN, {"regularization": 0}, "test")
RANDOM = override(RUN, {"agent": "agents.reference:Random", "decisions": 0}, "test")
CELLS = [
    Cell("regularized", RUN, 0),
    Cell("unregularized", UNREGULARIZED, 0),
    Cell("regularized", RUN, 1),
    Cell("unregularized", UNREGULARIZED, 1),
    Cell("untrained", RANDOM, 0),
]


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A sweep that ran to its end, in this process."""
    root = tmp_path_factory.mktemp("finished")
    return root, run_cells(CELLS, root, jobs=1, quiet=True)


def contents(root: Path) -> dict[str, bytes]:
    """Every file that must not depend on how a sweep was run."""
    return {
        str(path.relative_to(root)): path.read_bytes()
        for path in root.rglob("*")
        if path.is_file() and path.name not in (store.MANIFEST, "command.txt") and path.suffix != ".npz"
    }


def manifests(root: Path) -> dict[Path, int]:
    """When each piece of work was finished."""
    return {path: path.stat().st_mtime_ns for path in root.rglob(store.MANIFEST)}


def test_every_cell_is_trained_and_evaluated(finished):
    root, outcomes = finished
    assert [outcome.cell for outcome in outcomes] == CELLS
    for outcome in outcomes:
        assert not outcome.error, outcome.log
        assert outcome.folder == store.run_folder(root, outcome.cell.config, outcome.cell.seed)
        assert store.read_run(outcome.folder) == (outcome.cell.config, outcome.cell.seed)
        names = {path.name for path in outcome.folder.iterdir()}
        assert {"config.yaml", "command.txt", "manifest.json", "learning.csv", "agent.json"} < names
        assert {path.name for path in outcome.evaluation.iterdir()} == {
            "table.csv", "starts.csv", "cycles.csv", "nodes.csv", "gait.npz", "manifest.json"
        }  # fmt: skip
    assert len(manifests(root)) == 2 * len(CELLS)


def test_finished_cells_are_only_looked_up(finished, monkeypatch):
    root, outcomes = finished
    before = manifests(root)
    monkeypatch.setattr(training, "make_agent", None)  # whoever trains or measures again, fails
    monkeypatch.setattr(evaluation, "measure", None)
    again = run_cells(CELLS, root, jobs=1, quiet=True)
    assert again == outcomes
    assert manifests(root) == before


def test_many_runs_are_looked_for_aloud(finished, monkeypatch, capsys):
    monkeypatch.setattr(sweep, "MANY", len(CELLS) - 1)
    run_cells(CELLS, finished[0], jobs=1)
    said = capsys.readouterr().err.splitlines()
    assert said[0] == f"looking for the finished ones of {len(CELLS)} runs"
    assert said[1].startswith(f"{len(CELLS)} runs in ")


def test_another_evaluation_does_not_train_again(finished, monkeypatch):
    root, outcomes = finished
    before = manifests(root)
    monkeypatch.setattr(training, "make_agent", None)
    changed = override(RUN, {"evaluation.starts": 1}, "test")
    (outcome,) = run_cells([Cell("regularized", changed, 0)], root, jobs=1, quiet=True)
    assert outcome.folder == outcomes[0].folder
    assert outcome.evaluation != outcomes[0].evaluation
    after = manifests(root)
    assert set(after) - set(before) == {outcome.evaluation / store.MANIFEST}
    assert before.items() <= after.items()


def test_results_are_one_row_a_run(finished):
    _, outcomes = finished
    runs, evaluations, cycles = read_outcomes(outcomes)
    assert list(runs["experiment"]) == [cell.experiment for cell in CELLS]
    assert list(runs["seed"]) == [0, 0, 1, 1, 0]
    assert list(runs["regularization"]) == [0.01, 0, 0.01, 0, 0.01]
    assert list(runs["agent"]) == ["qlearning"] * 4 + ["random"]
    assert len(evaluations) == len(CELLS) * 2 * 2
    assert set(evaluations["noise"]) == {0, 0.1}
    for row in runs.to_dict("records"):
        chosen = (evaluations["experiment"] == row["experiment"]) & (evaluations["seed"] == row["seed"])
        quiet = evaluations[chosen & (evaluations["noise"] == 0)]
        assert row["speed"] == pytest.approx(quiet["speed"].mean())
        assert row["stall_share"] == quiet["stalled"].astype(float).mean()
        mine = cycles[(cycles["experiment"] == row["experiment"]) & (cycles["seed"] == row["seed"])]
        assert row["cycles"] == len(mine)


def test_the_learning_curve_ends_at_the_last_decision(finished):
    _, outcomes = finished
    curve = pd.read_csv(outcomes[0].folder / "learning.csv", dtype={"policy": str})
    assert curve["decisions"].iloc[-1] == RUN.decisions
    assert curve["time"].iloc[-1] == pytest.approx(RUN.decisions * RUN.parameters.decision_interval)
    with np.load(outcomes[0].folder / "snapshots.npz") as arrays:
        assert arrays["q_table"].shape == (arrays["decisions"].size, 10, 10)
        policy = "".join(map(str, arrays["q_table"][-1].argmax(axis=1)))
    assert curve["policy"].iloc[-1] == policy


def test_results_do_not_depend_on_the_number_of_jobs(finished, tmp_path):
    root, _ = finished
    run_cells(CELLS, tmp_path, jobs=2, quiet=True)
    expected, found = contents(root), contents(tmp_path)
    assert found
    assert {name: expected[name] for name in found} == found


BROKEN = """
from agents.reference import Random
class Broken(Random):
    def learn(self, total_timesteps, callback=None, progress_bar=False):
        raise ZeroDivisionError("no luck today")
"""


def test_a_failing_cell_is_reported_and_stops_nothing(finished, tmp_path, monkeypatch, capsys):
    monkeypatch.syspath_prepend(str(tmp_path))
    (tmp_path / "broken_agent.py").write_text(BROKEN)
    broken = [override(RUN, {"agent": f"broken_agent:{name}"}, "test") for name in ("Broken", "Missing")]
    unknown = override(RANDOM, {"settings.temperature": 1}, "test")
    cells = [Cell("broken", config, 0) for config in (*broken, unknown)]
    outcomes = run_cells([*cells, CELLS[4]], tmp_path / "runs", jobs=1)
    said = capsys.readouterr().err
    reasons = ["ZeroDivisionError: no luck today", "Missing", "temperature"]
    for outcome, reason in zip(outcomes, reasons, strict=False):
        assert reason in outcome.error
        assert reason in said
        assert "Traceback" in outcome.log
        assert outcome.folder is outcome.evaluation is None
    assert said.count("FAILED broken seed 0") == 3
    assert outcomes[3].error == ""
    assert [path.name for path in (tmp_path / "runs").iterdir()] == [outcomes[3].folder.name]
    runs, _, _ = read_outcomes(outcomes)
    assert list(runs["experiment"]) == ["untrained"]


def test_a_damaged_agent_is_named_in_one_line(finished, tmp_path):
    folder = tmp_path / "run"
    shutil.copytree(finished[1][0].folder, folder)
    agent = folder / "agent.json"
    agent.write_text(agent.read_text()[:1000])
    with pytest.raises(store.NotARunError, match=r"agent\.json was changed"):
        evaluation.evaluate(folder, RUN.evaluation.model_copy(update={"seed": 99}))
    checksums.seal(folder, "run")
    with pytest.raises(store.NotARunError, match=r"agent\.json cannot be loaded: is not a saved Q-learning"):
        evaluation.evaluate(folder, RUN.evaluation.model_copy(update={"seed": 99}))


def damage_evaluation(outcome) -> None:
    (outcome.evaluation / "starts.csv").write_text("noise,start,speed,reward,stalled\n0,0,1e300,1,False\n")


def damage_curve(outcome) -> None:
    path = outcome.folder / "learning.csv"
    path.write_text(path.read_text().rpartition("\n")[0].rpartition("\n")[0])


def remove_config(outcome) -> None:
    (outcome.folder / store.CONFIG).unlink()


def empty_agent(outcome) -> None:
    (outcome.folder / "agent.json").write_text("")


@pytest.mark.parametrize("harm", [damage_evaluation, damage_curve, remove_config, empty_agent])
def test_a_damaged_cell_is_done_again_with_one_line(finished, tmp_path, capsys, harm):
    root = tmp_path / "runs"
    shutil.copytree(finished[0], root)
    cells = [CELLS[4], CELLS[0]]
    before = run_cells(cells, root, jobs=1, quiet=True)
    harm(before[1])
    if harm is not remove_config:
        with pytest.raises(store.NotARunError, match="was changed after it was written"):
            read_outcomes(before)
    capsys.readouterr()
    outcomes = run_cells(cells, root, jobs=1)
    said = [line for line in capsys.readouterr().err.splitlines() if "made again" in line]
    assert len(said) == 1
    assert said[0].startswith("regularized seed 0: ")
    expected = contents(finished[0])
    assert contents(outcomes[1].folder).items() <= {
        name.partition("/")[2]: content for name, content in expected.items()
        if name.startswith(outcomes[1].folder.name)
    }.items()  # fmt: skip


def test_swapped_runs_and_evaluations_are_noticed(finished, tmp_path):
    root = tmp_path / "runs"
    shutil.copytree(finished[0], root)
    pair = [CELLS[0], CELLS[2]]
    for part in ("folder", "evaluation"):
        one, two = (getattr(outcome, part) for outcome in run_cells(pair, root, jobs=1, quiet=True))
        one.rename(tmp_path / "aside")
        two.rename(one)
        (tmp_path / "aside").rename(two)
        outcomes = run_cells(pair, root, jobs=1, quiet=True)
        assert [len(outcome.notes) for outcome in outcomes] == [1, 1]
        assert contents(outcomes[0].evaluation) == contents(finished[1][0].evaluation)


def test_what_another_command_works_on_is_left_to_it_and_looked_up_at_the_end(tmp_path, capsys):
    cells = [CELLS[4], Cell("untrained", RANDOM, 1)]
    theirs = store.run_folder(tmp_path, RANDOM, 0)
    held, ours = threading.Event(), store.run_folder(tmp_path, RANDOM, 1)

    def work():
        with claims.claim(theirs):
            held.set()
            while not list(ours.glob("evaluation-*")):  # we go on with the other cell meanwhile
                time.sleep(0.01)

    other = threading.Thread(target=work, daemon=True)
    other.start()
    held.wait()
    outcomes = run_cells(cells, tmp_path, jobs=1)
    assert not any(outcome.error for outcome in outcomes)
    said = capsys.readouterr().err
    assert "waiting for another command, which works on 1 of the runs" in said
    assert said.index("seed 1:") < said.index("waiting") < said.index("seed 0:")


def test_a_cell_that_kills_its_worker_is_a_failure_and_not_a_loop(tmp_path, capsys):
    dying = override(RANDOM, {"agent": "tests.runs.machines.dying:Dies"}, "test")
    outcomes = run_cells([Cell("dying", dying, 0), CELLS[4]], tmp_path / "runs", jobs=2)
    assert "died twice" in outcomes[0].error
    assert "FAILED dying seed 0" in capsys.readouterr().err
    assert not outcomes[1].error
    assert [path.name for path in (tmp_path / "runs").iterdir() if path.is_dir()] == [outcomes[1].folder.name]


def test_nothing_finished_is_nothing_read():
    assert all(frame.empty for frame in read_outcomes([]))


SWEEP = """
import sys
from pathlib import Path
from tests.runs.test_sweep import CELLS, run_cells
run_cells(CELLS, Path(sys.argv[1]), jobs=1, quiet=True)
"""


def test_a_killed_sweep_goes_on_as_if_nothing_had_happened(finished, tmp_path):
    complete, _ = finished
    root = tmp_path / "runs"
    process = subprocess.Popen(
        [sys.executable, "-c", SWEEP, str(root)], cwd=ROOT, env=os.environ | {"PYTHONPATH": str(ROOT)},
        start_new_session=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    try:
        deadline = time.monotonic() + 60
        while not list(root.glob("[!.]*")):
            assert process.poll() is None, "the sweep ended before any run was there"
            assert time.monotonic() < deadline
            time.sleep(0.002)
    finally:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
    before = manifests(root)
    assert len(before) < 2 * len(CELLS)  # killed in the middle
    outcomes = run_cells(CELLS, root, jobs=1, quiet=True)
    assert not any(outcome.error for outcome in outcomes)
    assert before.items() <= manifests(root).items()
    expected = contents(complete)
    found = {name: content for name, content in contents(root).items() if ".partial-" not in name}
    assert len(found) == 7 * len(CELLS)
    assert {name: expected[name] for name in found} == found
