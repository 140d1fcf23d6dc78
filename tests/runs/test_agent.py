"""Agents by name: what is not one is refused in one line, before anything is computed."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from crawler_bench.config.files import AGENTS
from crawler_bench.config.schema import ConfigError, Experiment, RunConfig, override
from crawler_bench.runs import agent as module
from crawler_bench.runs.agent import agent_class, is_stable_baselines
from crawler_bench.runs.sweep import run_experiments
from crawler_bench.runs.training import make_agent, make_env

ROOT = Path(module.__file__).parents[2]
AGENT = """
class {name}:
    def __init__(self, env, seed=None): pass
    def learn(self, total_timesteps{learn}): pass
    def predict(self, observation, deterministic=True): return observation, None
    def save(self, path): pass
    @classmethod
    def load(cls, path, env=None): return cls(env)
"""


def agent_code(name: str = "Mine", learn: str = ", callback=None, progress_bar=False") -> str:
    return AGENT.format(name=name, learn=learn)


@pytest.fixture
def mine(tmp_path, monkeypatch):
    """A module with agents, by the name `mine_agents`."""
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, "mine_agents", raising=False)
    return tmp_path / "mine_agents.py"


def complaint(name: str) -> str:
    with pytest.raises(ConfigError) as caught:
        agent_class(name)
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("qlerning", "no agent is called 'qlerning'; did you mean 'qlearning'?"),
        ("nowhere_at_all:Agent", "cannot be imported: No module named 'nowhere_at_all'"),
        ("agents.qlearning:Missing", "cannot be imported"),
        ("../x:Y", "not of the form module:Class"),
        ("x:", "not of the form module:Class"),
        (
            "json:dumps",
            "like Stable-Baselines3's; this is a function",
        ),
        ("subprocess:Popen", "an agent has learn, predict, save, load; it has no learn"),
    ],
)
def test_what_is_no_agent_is_said_in_one_line(name, said):
    assert said in complaint(name)


@pytest.mark.parametrize(
    ("code", "said"),
    [
        (agent_code().replace("def load", "def lode"), "it has no load"),
        (agent_code(learn=""), "its learn must accept callback and progress_bar"),
        ("1 / 0", "cannot be imported: ZeroDivisionError: division by zero"),
        ("class Mine", "cannot be imported: SyntaxError"),
    ],
)
def test_an_agent_that_lacks_something_is_said_in_one_line(mine, code, said):
    mine.write_text(code)
    assert said in complaint("mine_agents:Mine")


def test_anyones_class_with_the_interface_is_an_agent(mine):
    mine.write_text(agent_code(learn=", **settings"))
    assert agent_class("mine_agents:Mine").__name__ == "Mine"


def test_stable_baselines_agents_are_told_by_their_bases():
    found = {name: is_stable_baselines(agent_class(name)) for name in (*AGENTS, "sb3_contrib:QRDQN")}
    assert {name for name, yes in found.items() if yes} == {
        "dqn", "ppo", "a2c", "qrdqn", "recurrent-ppo", "sb3_contrib:QRDQN"
    }  # fmt: skip


def test_several_crawlers_need_an_agent_that_learns_from_several():
    with pytest.raises(ConfigError, match="crawlers = 4: qlearning learns from one crawler"):
        make_env(override(RunConfig(), {"crawlers": 4}, "test"))
    deep = override(RunConfig(), {"crawlers": 4, "agent": "ppo"}, "test")
    assert make_agent(deep, make_env(deep), 0).n_envs == 4  # type: ignore[attr-defined]


def test_a_missing_agent_stops_experiments_before_anything_is_computed(tmp_path):
    runs = [RunConfig(agent="random", decisions=0), RunConfig(agent="nowhere_at_all:Agent")]
    with pytest.raises(ConfigError, match="nowhere_at_all"):
        run_experiments([Experiment(name="e", run=run, seeds=1) for run in runs], tmp_path / "runs", jobs=1)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("code", ["", "class QLearning: pass"])
def test_another_package_called_agents_is_told_apart(tmp_path, code):
    (tmp_path / "agents").mkdir()
    for name in ("__init__", "qlearning"):
        (tmp_path / "agents" / f"{name}.py").write_text(code)
    # From this folder, which the path begins with, as a user's own would.
    ask = "from crawler_bench.runs.agent import agent_class; agent_class('qlearning')"
    environment = os.environ | {"PYTHONPATH": os.pathsep.join((str(tmp_path), str(ROOT)))}
    done = subprocess.run(
        [sys.executable, "-c", ask],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert "ConfigError" in done.stderr
    assert "it may be openai-agents" in done.stderr
