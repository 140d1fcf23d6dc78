"""The commands that compare agents, as a user types them."""

from pathlib import Path

import gymnasium as gym
import pandas as pd
import pytest
from typer.testing import CliRunner

from crawler_bench import ENV_ID, cli, record
from crawler_bench.config.schema import ConfigError

SHORT = "starts=2 warm_up=5 duration=40 settle=10 gait=40 evaluation.noise=[0,0.1] decisions=2000".split()
SHORTLY = ("--jobs", 1, "--quiet")
SETTINGS = [word for each in SHORT for word in ("--set", each)]


def crawler_bench(*words):
    return CliRunner().invoke(cli.app, [str(word) for word in words])


def benchmark(folder: Path, *words):
    folders = ("--runs", folder / "runs", "--out", folder / "out")
    return crawler_bench("benchmark", *words, *folders, *SHORTLY, "--seeds", 2, *SETTINGS)


@pytest.fixture(scope="module")
def compared(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("compared")
    theirs = record(gym.make(ENV_ID), folder / "runs" / "theirs-3")
    theirs.reset(seed=0)
    for t in range(1200):
        theirs.step(t % 10)
    theirs.close()
    done = benchmark(folder, "--only", "wave", "--only", "qlearning")
    assert done.exit_code == 0, done.output
    assert "runs together took" in done.output
    return folder


def test_the_entries_that_were_asked_for_are_compared(compared):
    runs = pd.read_csv(compared / "out" / "runs.csv", dtype={"policy": str}).query("agent != 'theirs'")
    assert runs.groupby("agent")["seed"].unique().map(list).to_dict() == {"qlearning": [0, 1], "wave": [0, 1]}
    assert set(runs["regularization"]) == {0, 0.01}
    assert set(runs.loc[runs["agent"] == "qlearning", "decisions"]) == {2000}
    assert set(runs.loc[runs["agent"] == "wave", "decisions"]) == {0}


def test_what_another_loop_recorded_among_the_runs_stands_in_the_tables(compared):
    runs = pd.read_csv(compared / "out" / "runs.csv").query("agent == 'theirs'")
    assert runs[["mode", "seed", "decisions"]].to_numpy().tolist() == [["as acted", 3, 1200]]
    assert "theirs" in (compared / "out" / "tables" / "comparison.md").read_text()


def test_a_cell_is_made_again_by_its_hash(compared):
    summary = pd.read_csv(compared / "out" / "summary.csv", dtype={"hash": str})
    cell = summary[(summary["agent"] == "qlearning") & (summary["metric"] == "speed")].iloc[0]
    done = crawler_bench("reproduce-cell", f"#{cell['hash']}", "--results", compared / "out", *SHORTLY)
    assert done.exit_code == 0, done.output
    assert "1 equal" in done.output
    summary.loc[cell.name, ["value", "low", "high"]] = 1.0, 0.9, 1.1
    (compared / "changed").mkdir()
    for path in (compared / "out").iterdir():
        if path.suffix == ".csv" or path.is_dir():
            (compared / "changed" / path.name).symlink_to(path)
    (compared / "changed" / "summary.csv").unlink()
    summary.to_csv(compared / "changed" / "summary.csv", index=False)
    done = crawler_bench("reproduce-cell", cell["hash"], "--results", compared / "changed", *SHORTLY)
    assert isinstance(done.exception, RuntimeError)
    assert "1 different" in done.output


def test_shared_policies_are_evaluated_and_filmed(compared, tmp_path):
    policy = next((compared / "out" / "policies").glob("wave-eps0-*.json"))
    done = crawler_bench("evaluate", policy, "--set", "starts=1", "--out", tmp_path)
    assert done.exit_code == 0, done.output
    row = pd.read_csv(tmp_path / "runs.csv", dtype={"policy": str}).iloc[0]
    assert (row["policy"], row["run"]) == ("0123456789", policy.stem)
    done = crawler_bench("render", policy, "--out", tmp_path / "film", "--quiet")
    assert done.exit_code == 0, done.output
    assert {path.name for path in (tmp_path / "film").iterdir()} == {
        "gait.png", "gait.svg", "gait.gif", "gait.mp4"
    }  # fmt: skip


def test_repeated_it_runs_nothing_again(compared, monkeypatch):
    monkeypatch.setattr("crawler_bench.runs.training.make_agent", None)
    before = (compared / "out" / "runs.csv").read_bytes()
    assert benchmark(compared, "--only", "wave", "--only", "qlearning").exit_code == 0
    assert (compared / "out" / "runs.csv").read_bytes() == before


def test_a_file_gets_the_budget_of_all_and_the_regularization_that_is_asked_for(tmp_path):
    (tmp_path / "mine.yaml").write_text("agent: qlearning\nsettings: {learning_rate: 0.2}\n")
    words = ("--only", "qlearning", "--agent", tmp_path / "mine.yaml", "--set", "regularization=0.02")
    done = benchmark(tmp_path, *words)
    assert done.exit_code == 0, done.output
    runs = pd.read_csv(tmp_path / "out" / "runs.csv", dtype={"policy": str})
    assert set(runs["regularization"]) == {0.02}
    assert set(runs["decisions"]) == {2000}
    assert runs.groupby("agent").size().to_dict() == {"mine": 2, "qlearning": 2}


def test_what_cannot_be_compared_is_said_before_anything_is_computed(tmp_path):
    for words, said in (
        (("--only", "weve"), "did you mean 'wave'"),
        (("--agent", "wave"), "wave would be compared twice"),
        (("--agent", "nobody"), "no agent is called 'nobody'"),
        (("--agent", "nowhere.yaml"), "nowhere.yaml cannot be read"),
    ):
        done = benchmark(tmp_path, *words)
        assert isinstance(done.exception, ConfigError | ValueError)
        assert said in str(done.exception)
    assert not (tmp_path / "runs").exists()


def test_a_search_writes_its_trials_and_its_best(tmp_path):
    folders = ("--runs", tmp_path / "runs", "--out", tmp_path)
    done = crawler_bench("tune", "qlearning", "--preset", "smoke", *folders, *SHORTLY)
    assert done.exit_code == 0, done.output
    assert len(pd.read_csv(tmp_path / "qlearning" / "trials.csv")) == 6
    assert "learning_rate" in (tmp_path / "qlearning" / "qlearning-tuned.yaml").read_text()
    assert len(pd.read_csv(tmp_path / "qlearning" / "importance.csv")) == 2
