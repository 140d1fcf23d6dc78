"""What a sweep says: what there is to do, which phase it is in, and how long the rest takes."""

import re
import time
from io import StringIO

import pytest
from rich.console import Console

from crawler_bench.config.schema import RunConfig, override
from crawler_bench.runs import evaluation, progress, store
from crawler_bench.runs.progress import SweepProgress, format_duration
from crawler_bench.runs.sweep import Cell, run_cells
from crawler_bench.runs.training import train

SHORT = {"starts": 1, "warm_up": 1, "duration": 10, "settle": 1, "gait": 10, "evaluation.noise": [0]}
RUN = override(RunConfig(), {"agent": "random", "decisions": 0} | SHORT, "test")
LONG = override(RUN, {"decisions": 10**6}, "test")


@pytest.fixture
def root(tmp_path):
    """Of three runs, one is trained and measured, one is trained."""
    first, _ = (train(RUN, seed, tmp_path) for seed in (0, 1))
    evaluation.evaluate(first)
    return tmp_path


def sweep_of(root, *seeds, run=RUN, jobs=2) -> SweepProgress:
    return SweepProgress([(run, seed) for seed in seeds], root, jobs)


def test_the_plan_counts_what_is_finished_and_says_where(root):
    plan = sweep_of(root, 0, 1, 2).plan()
    assert f"3 runs in {root}" in plan
    assert "1 to train (2 finished), 2 to measure (1), 2 at a time, about 1 s" in plan
    assert sweep_of(root, 0).plan() == f"1 run in {root}: all trained and measured"


def test_the_phases_follow_the_folders(root):
    sweep = sweep_of(root, 0, 1, 2)
    assert sweep.now() == "training 2/3, measuring 1/3"
    evaluation.evaluate(train(RUN, 2, root))
    sweep._poll()
    assert sweep.now() == "measuring 2/3"
    sweep.give_up(RUN, 1)
    assert sweep.counts == (3, 3, 3)


def test_time_left_counts_only_what_is_left(root, monkeypatch):
    monkeypatch.setattr(progress, "PER_CRAWL", 100.0)
    clock = [0.0]
    monkeypatch.setattr(time, "monotonic", lambda: clock[0])
    sweep = sweep_of(root, 0, 1, 2, 3, 4, jobs=1)
    assert sweep.seconds_left() == pytest.approx(400)  # of four: what is finished takes no time
    clock[0] = 30.0
    sweep.give_up(RUN, 1)
    assert sweep.seconds_left() == pytest.approx(90)  # three more, each as the one


def test_finished_runs_say_how_long_the_next_takes(root, monkeypatch):
    monkeypatch.setattr(progress, "PER_DECISION", 1e-3)
    assert "about 17 min" in sweep_of(root, 9, run=LONG, jobs=1).plan()
    folder = train(override(RUN, {"decisions": 1000}, "test"), 5, root)
    manifest = folder / store.MANIFEST
    manifest.write_text(
        re.sub(r'"wall_clock_seconds": [\d.]+', '"wall_clock_seconds": 8.0', manifest.read_text())
    )
    assert "about 2.2 h" in sweep_of(root, 9, run=LONG, jobs=1).plan()


def test_a_sweep_says_its_plan_first_and_its_phases_while_it_runs(root, monkeypatch, capsys):
    run_cells([Cell("here", RUN, seed) for seed in (0, 1)], root, jobs=1)
    first, *_ = capsys.readouterr().err.splitlines()
    assert first.startswith("2 runs in")
    monkeypatch.setattr(progress, "POLL", 0.01)
    monkeypatch.setattr(progress, "PATIENCE", 0.0)
    out = StringIO()
    sweep = sweep_of(root, 0, 7)
    with sweep.shown(Console(file=out)):
        train(RUN, 7, root)
        deadline = time.monotonic() + 10
        while "measuring" not in out.getvalue() and time.monotonic() < deadline:
            time.sleep(0.01)
    assert re.match(r"measuring 1/2, about 1 s left\n", out.getvalue())


def test_an_evaluation_beside_a_changed_agent_is_not_taken_for_its_own(tmp_path):
    run = override(RUN, {"agent": "qlearning", "decisions": 1000}, "test")
    folder = train(run, 0, tmp_path)
    before = evaluation.evaluate(folder)
    other = train(run, 1, tmp_path)
    (folder / "agent.json").write_text((other / "agent.json").read_text())
    after = evaluation.evaluate(folder)
    assert after != before
    tables = [evaluation.read_evaluation(place).table.tolist() for place in (before, after)]
    assert tables[0] != tables[1]
    assert tables[1] == evaluation.read_evaluation(evaluation.evaluate(other)).table.tolist()


@pytest.mark.parametrize(("seconds", "said"), [(0.2, "1 s"), (89, "89 s"), (720, "12 min"), (12600, "3.5 h")])
def test_durations_are_said_as_one_would(seconds, said):
    assert format_duration(seconds) == said
