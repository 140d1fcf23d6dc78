"""`train`: configurations by name or file, their seeds and grid, and what it says while it works."""

import shlex
import sys
from pathlib import Path

import pytest

from crawler_bench import cli
from crawler_bench.cli.options import Preset
from crawler_bench.cli.terminal import console
from crawler_bench.cli.train import experiment_to_train
from crawler_bench.config.files import config_names, find_config, load_experiment
from tests.cli.command import crawler_bench


def wanted(agent=None, config=None, *, preset=Preset.paper, seed=None, seeds=None, set_=None):
    """Runs that a command line asks for, each with its seed."""
    return list(experiment_to_train(agent, config, preset, seed, seeds, set_).runs())


@pytest.fixture
def mine(tmp_path) -> str:
    (tmp_path / "mine.yaml").write_text(
        "decisions: 500\nseeds: 4-5\ngrid: {environment.regularization: [0, 0.5]}\n"
    )
    return str(tmp_path / "mine.yaml")


def test_a_configuration_is_found_by_its_name_from_anywhere(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in config_names():
        assert find_config(name).is_file()
    experiment = load_experiment(find_config("paper/regularized"))
    assert wanted(config="paper/regularized") == list(experiment.runs())


def test_seeds_and_grid_of_a_configuration_count(mine):
    found = [(run.environment.regularization, seed) for run, seed in wanted("random", mine)]
    assert found == [(0, 4), (0, 5), (0.5, 4), (0.5, 5)]
    assert [seed for _, seed in wanted("random", mine, seed=7)] == [7, 7]
    assert [seed for _, seed in wanted("random", mine, seeds="2")] == [0, 1, 0, 1]
    assert {
        run.environment.regularization for run, _ in wanted("random", mine, set_=["regularization=2"])
    } == {2}


def test_without_a_configuration_there_is_one_run():
    ((run, seed),) = wanted("random")
    assert (run.agent, seed) == ("random", 0)


def test_an_agent_may_be_left_out_or_repeated(mine):
    assert {run.agent for run, _ in wanted(config="paper/untrained")} == {"random"}
    assert wanted("random", "paper/untrained") == wanted(config="paper/untrained")
    assert wanted("agents.reference:Random", "paper/untrained") == wanted(config="paper/untrained")
    assert {run.agent for run, _ in wanted("wave", mine)} == {"wave"}


def test_the_settings_of_a_configuration_without_an_agent_are_for_the_one_that_is_named(tmp_path):
    (tmp_path / "mine.yaml").write_text("settings: {learning_rate: 0.001}\n")
    ((run, _),) = wanted("ppo", str(tmp_path / "mine.yaml"))
    assert (run.agent, run.settings) == ("ppo", {"learning_rate": 0.001})


def test_decisions_that_are_asked_for_are_taken_where_the_configuration_learns_nothing():
    assert {run.decisions for run, _ in wanted(config="paper/untrained", set_=["decisions=7"])} == {7}


def test_the_smoke_preset_is_small_here_as_elsewhere():
    runs = wanted("qlearning", preset=Preset.smoke)
    (full, _), *_ = wanted("qlearning")
    assert len(runs) == 2
    assert runs[0][0].decisions < full.decisions / 10
    assert runs[0][0].evaluation.duration < full.evaluation.duration


def test_train_says_its_plan_and_every_phase(mine, tmp_path, monkeypatch):
    monkeypatch.setattr(console, "PATIENCE", 0.0)
    words = ("train", "qlearning", "--config", mine, "--seed", 4, "--set", "decisions=3000", "--out")
    code, out, err = crawler_bench(*words, tmp_path / "runs")
    assert code == 0, err
    names = [Path(line).name.rpartition("-")[0] for line in out.splitlines()]
    assert names == ["qlearning-eps0-seed04", "qlearning-eps0.5-seed04"]
    said = err.splitlines()
    assert said[0] == f"training qlearning, run folders in {tmp_path / 'runs'}"
    assert said[1] == "2 runs: 2 to train (0 finished), 3,000 decisions each, about 1 s"
    assert "training 2/2 (seed 4)" in said
    assert "training 1/2 (seed 4): 1,000/3,000 decisions" in said  # what came before may be compiling
    assert any(line.startswith("training 1/2 (seed 4): 2,000/3,000 decisions, about") for line in said)
    again = crawler_bench(*words, tmp_path / "runs")
    assert again[1] == out
    assert again[2].splitlines()[1:] == ["2 runs: all finished"]


def test_a_quiet_train_prints_its_folder_alone(tmp_path):
    words = ("--set", "decisions=0", "--out", tmp_path, "--quiet")
    code, out, err = crawler_bench("train", "random", *words)
    assert (code, err, len(out.splitlines())) == (0, "", 1)


def test_a_run_keeps_a_command_that_makes_it_again(tmp_path, monkeypatch):
    words = ["train", "random", "--set=decisions=0", "--out", str(tmp_path), "--quiet"]
    monkeypatch.setattr(sys, "argv", ["/here/crawler_bench/cli/__main__.py", *words])  # as `python -m` does
    with pytest.raises(SystemExit):
        cli.main()
    (kept,) = tmp_path.rglob("command.txt")
    assert shlex.split(kept.read_text()) == ["crawler-bench", *words]
