"""A Q-learning agent as a JSON file that holds all it takes to go on to the bit."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import gymnasium as gym
import numpy as np

from crawler_bench.envs.crawler import CrawlerEnv

if TYPE_CHECKING:
    from agents.qlearning import QLearning

SETTINGS = ("learning_rate", "discount", "initial_q", "seed", "end_is_terminal")


def save(agent: "QLearning", path: str | Path) -> None:
    """Write everything that decides the future, a crawler in mid-episode included."""
    environment = agent.env.unwrapped if agent.env is not None else None
    content = {
        "agent": "qlearning",
        **{name: getattr(agent, name) for name in SETTINGS},
        "num_timesteps": agent.num_timesteps,
        "policy": agent.policy.tolist(),
        "q_table": agent.q_table.tolist(),
        "generators": [agent.rng.bit_generator.state, agent.prediction_rng.bit_generator.state],
        "observation": agent.observation,
        "environment": environment.get_state() if isinstance(environment, CrawlerEnv) else None,
    }
    Path(path).write_text(json.dumps(content, indent=1) + "\n")


def load(kind: "type[QLearning]", path: str | Path, env: gym.Env[Any, Any] | None) -> "QLearning":
    """Read what `save` wrote; with a crawler as `env`, it is put where the saved one was.

    Raises:
        ValueError: if the file holds no such agent.
    """
    try:
        content = {"end_is_terminal": False} | json.loads(Path(path).read_text())
        agent = kind(None, **{name: content[name] for name in SETTINGS})
        agent.q_table = np.array(content["q_table"], dtype=np.float64)
        agent.num_timesteps = content["num_timesteps"]
        agent.rng.bit_generator.state, agent.prediction_rng.bit_generator.state = content["generators"]
        observation, snapshot = content["observation"], content["environment"]
    except (json.JSONDecodeError, UnicodeDecodeError, KeyError, TypeError) as error:
        raise ValueError(f"{path} is not a saved Q-learning agent ({error!r})") from None
    if env is not None:
        agent.set_env(env)
        if snapshot is not None and isinstance(env.unwrapped, CrawlerEnv):
            env.reset()  # wrappers want one before the first step
            env.unwrapped.set_state(snapshot)
            agent.observation = observation
    return agent
