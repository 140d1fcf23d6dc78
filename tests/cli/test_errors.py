"""Whatever goes wrong is said in one line: exit 2 for wrong usage, 1 for failure."""

import shutil
from pathlib import Path

import pytest

from crawler_bench.config.schema import RunConfig, override
from crawler_bench.runs.folders.checksums import seal
from crawler_bench.runs.training import train
from tests.cli.command import complaint, crawler_bench

MISUSED = """
nothing | no such command 'nothing'; see `crawler-bench --help`
train qlearning --sed 3 | no such option: --sed
train qlearning --seed x | invalid value for '--seed'
train qlearning --preset tiny | 'tiny' is not one of 'paper', 'smoke'; see `crawler-bench train --help`
evaluate | missing argument
train | name an agent
train nope | no agent is called 'nope'; known are qlearning
train qlerning | did you mean 'qlearning'?
train nowhere:Agent | 'nowhere:Agent' cannot be imported
train json:dumps | an agent is a class with learn, predict, save, load
train qlearning --set decisions=1e30 | decisions must be a whole number
train qlearning --set decisions=1.5 | decisions must be a whole number (given: 1.5)
train qlearning --set regularisation=1 | did you mean 'regularization'?
train qlearning --set regularization=.nan | environment.regularization must be a finite number
train qlearning --set regularization=-1 | environment.regularization must be at least 0
train qlearning --set mode=calm | evaluation.mode must be 'deterministic' or 'stochastic'
train qlearning --set n_segments=1 | a whole number of at least 2
train qlearning --set crawlers=4 | qlearning learns from one crawler
train qlearning --set settings.temperature=1 | knows no 'temperature'
train qlearning --config nowhere.yaml | nowhere.yaml cannot be read
train qlearning --config paper/regularised | did you mean 'paper/regularized'?
train dqn --config paper/regularized | says `agent: qlearning`, the command line dqn
train qlearning --seeds 9-3 | --seeds '9-3': seeds are a number of them
train qlearning --seeds= | --seeds '': seeds are a number of them
train qlearning --seeds 3,3 | --seeds '3,3': 3 stands twice
train qlearning --seed 1 --seeds 3 | exclude each other
train qlearning --out other/thesis.tex | thesis.tex is a file; --out needs a folder
evaluate regularized --out other/thesis.tex | thesis.tex is a file; --out needs a folder
render regularized --out other/thesis.tex | thesis.tex is a file; --out needs a folder
tune qlearning --out other/thesis.tex | thesis.tex is a file; --out needs a folder
benchmark --out other/thesis.tex | thesis.tex is a file; --out needs a folder
evaluate nowhere | nowhere does not exist
evaluate other | other is not a finished run
evaluate nowhere.json | nowhere.json does not exist
render regularised | did you mean 'regularized'?
render other | other is not a finished run
reproduce --preset smoke --out other | other is not empty
reproduce --claim wav | no claim is called 'wav'; did you mean 'wave'?
reproduce --preset smoke --set nope=1 | unknown key 'nope'
reproduce --seeds= | --seeds ''
readings --only head_muscle=react | did you mean 'head_muscle=reaction'
readings --check 2 --out other | `crawler-bench readings` makes one
readings --out other | other is not empty
benchmark --only weve | did you mean 'wave'
benchmark --seeds= | --seeds ''
tune nope | no configuration is called 'nope'
watch nowhere | nowhere does not exist
watch regularized --seconds=-1 | invalid value for '--seconds'
verify nowhere | nowhere is no folder
verify other | other holds no finished results or runs
certify --results other | other holds no ceilings.csv
train --continue other | other has no checkpoint to go on from
train qlearning --continue other | --continue takes all but
train qlearning --save-every 10 | qlearning is no agent of Stable-Baselines3
reproduce-cell 12345678 --results other | other/runs.csv cannot be read
"""


@pytest.fixture
def desk(tmp_path, monkeypatch) -> Path:
    """An own folder to stand in, with a precious file."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "thesis.tex").write_text("precious")
    return tmp_path


@pytest.mark.parametrize("line", MISUSED.strip().splitlines())
def test_wrong_usage_is_answered_in_one_line(line, desk):
    words, _, said = line.partition(" | ")
    code, complained = complaint(*words.split())
    assert said in complained
    assert code == 2
    assert {path.name for path in desk.rglob("*.*")} == {"thesis.tex"}


REFUSED_BY_THE_AGENT = """
settings.discount=3 | discount = 3
settings.discount=x | discount
settings.compiled=x | compiled
"""


@pytest.mark.parametrize("line", REFUSED_BY_THE_AGENT.strip().splitlines())
def test_what_an_agent_refuses_is_said_in_one_line(line, desk):
    setting, _, said = line.partition(" | ")
    assert said in complaint("train", "qlearning", "--set", setting)[1]


STRANGE = """
from pathlib import Path
from agents.reference import Random
class Strange(Random):
    @classmethod
    def load(cls, path, env=None):
        raise KeyError(Path(path).read_text())
"""


@pytest.mark.parametrize("agent", ["qlearning", "strange:Strange", "ppo"])
def test_a_damaged_agent_is_a_failure_that_names_file_and_run(agent, tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(tmp_path))
    (tmp_path / "strange.py").write_text(STRANGE)
    folder = train(override(RunConfig(), {"agent": agent, "decisions": 0}, "test"), 0, tmp_path / "runs")
    (damaged,) = folder.glob("agent*")
    damaged.write_bytes(damaged.read_bytes()[:100])
    code, said = complaint("evaluate", folder)
    assert code == 1
    assert f"{damaged} was changed after it was written; remove the run {folder}" in said
    seal(folder, folder.name)
    code, said = complaint("evaluate", folder, "--trust")
    assert code == 1
    assert f"{damaged} cannot be loaded" in said
    assert f"remove the run {folder}" in said


def test_a_policy_file_that_is_none_is_a_failure(tmp_path):
    (tmp_path / "mine.json").write_text('{"seed": 0, "run": {"decisions": -1}, "tables": {}}')
    code, said = complaint("render", tmp_path / "mine.json")
    assert code == 1
    assert "mine.json is not a policy: run: decisions must be at least 0 (given: -1)" in said


def test_a_run_that_is_none_is_a_failure(tmp_path):
    folder = train(override(RunConfig(), {"agent": "random", "decisions": 0}, "test"), 0, tmp_path)
    other = tmp_path / "other"
    shutil.copytree(folder, other)
    (other / "config.yaml").write_text("seed: 0\nrun: {decisions: 1.5}\n")
    seal(other, "other")
    code, said = complaint("evaluate", other)
    assert code == 1
    assert "decisions must be a whole number (given: 1.5)" in said


def test_an_interruption_says_that_nothing_is_lost(monkeypatch):
    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("crawler_bench.config.files.registered_agents", interrupt)
    code, said = complaint("list")
    assert (code, "interrupted; the same command goes on" in said) == (130, True)


def test_a_bug_keeps_its_traceback(monkeypatch):
    monkeypatch.setattr("crawler_bench.config.files.registered_agents", lambda: {}[0])
    with pytest.raises(KeyError):
        crawler_bench("list")
