"""What docs/comparing.md says one can do, done as it says."""

import re
import subprocess
import sys
from pathlib import Path

import gymnasium as gym
import pandas as pd
import yaml
from stable_baselines3 import PPO
from stable_baselines3.common.env_util import make_vec_env

import crawler_bench
from crawler_bench.config.files import AGENTS_GROUP

ROOT = Path(__file__).parents[2]
DOCUMENT = (ROOT / "docs" / "comparing.md").read_text()
SHORT = "starts=2 warm_up=5 duration=40 settle=10 gait=40 evaluation.noise=[0,0.1] decisions=3000".split()


def block(language: str, holding: str) -> str:
    found = [text for text in re.findall(rf"```{language}\n(.*?)```", DOCUMENT, re.DOTALL) if holding in text]
    assert len(found) == 1
    return found[0]


def test_ones_own_agent_appears_in_the_tables(tmp_path, monkeypatch):
    """From a folder outside the project, with nothing but the file."""
    monkeypatch.delenv("PYTHONPATH", raising=False)
    (tmp_path / "hill.py").write_text(block("python", "class Hill"))
    settings = [word for each in SHORT for word in ("--set", each)]
    words = "benchmark --agent hill:Hill --only wave --seeds 2 --jobs 2 --out out".split()
    code = f"import sys; sys.path.append({str(ROOT)!r}); from crawler_bench.cli import main; main()"
    command = [sys.executable, "-c", code, *words, *settings]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=500)
    assert done.returncode == 0, done.stderr
    assert "hill" in done.stdout
    runs = pd.read_csv(tmp_path / "out" / "runs.csv", dtype={"policy": str})
    assert sorted(runs["agent"]) == ["hill"] * 4 + ["wave"] * 4
    decisions = runs.set_index("agent")["decisions"]
    assert (decisions["hill"] == 3072).all()  # six rounds of 512 reach the budget of 3000
    assert (decisions["wave"] == 0).all()
    assert "hill" in (tmp_path / "out" / "tables" / "comparison.md").read_text()
    assert {"hill.yaml", "wave.yaml"} == {path.name for path in (tmp_path / "out" / "entries").iterdir()}


def test_the_environment_works_from_the_zoo_s_format():
    """As rl-baselines3-zoo reads it: the environment by name, the rest to the algorithm."""
    content = yaml.safe_load(block("yaml", "n_timesteps"))
    ((name, settings),) = content.items()
    assert name == crawler_bench.ENV_ID
    assert name in gym.registry
    assert settings.pop("n_timesteps") == 500_000
    env = make_vec_env(name, n_envs=settings.pop("n_envs"), seed=0, env_kwargs=settings.pop("env_kwargs"))
    agent = PPO(env=env, seed=0, n_epochs=1, **settings | {"n_steps": 32}).learn(256)
    assert agent.num_timesteps == 256


def test_the_entry_point_group_is_ours():
    assert f'"{AGENTS_GROUP}"' in block("toml", "entry-points")
