"""Policies that know nothing or everything: what learning has to be held against."""

import json
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import ArrayLike, NDArray


class FixedPolicy:
    """A policy that never learns, with the interface of a Stable-Baselines3 agent.

    Args:
        env: an environment with Discrete spaces; only their sizes are used.
        seed: of the policy's own generator.

    Attributes:
        action_probabilities: (observations, actions), each row sums to 1.
    """

    def __init__(self, env: gym.Env[Any, Any], seed: int | None = None) -> None:
        observations, actions = env.observation_space, env.action_space
        if not (isinstance(observations, gym.spaces.Discrete) and isinstance(actions, gym.spaces.Discrete)):
            raise ValueError(f"{type(self).__name__} needs Discrete spaces, not {observations} and {actions}")
        self.env = env
        self.num_timesteps = 0
        self.rng = np.random.default_rng(seed)
        self.action_probabilities = self._probabilities(int(observations.n), int(actions.n))

    def _probabilities(self, n_observations: int, n_actions: int) -> NDArray[np.float64]:
        raise TypeError("use Random, Still or Wave")

    def learn(self, total_timesteps: int, callback: Any = None, progress_bar: bool = False) -> "FixedPolicy":
        """Count the decisions and learn nothing."""
        self.num_timesteps += total_timesteps
        return self

    def predict(
        self,
        observation: ArrayLike,
        state: tuple[NDArray[Any], ...] | None = None,
        episode_start: NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[NDArray[np.int64], tuple[NDArray[Any], ...] | None]:
        """Draw an action for one observation or a batch of them; `deterministic` changes nothing."""
        seen = np.asarray(observation, dtype=np.int64)
        n_actions = self.action_probabilities.shape[1]
        chosen = [self.rng.choice(n_actions, p=self.action_probabilities[o]) for o in seen.ravel()]
        return np.array(chosen, dtype=np.int64).reshape(seen.shape), state

    def save(self, path: str | Path) -> None:
        """Write the policy as JSON."""
        content = {"num_timesteps": self.num_timesteps, "generator": self.rng.bit_generator.state}
        Path(path).write_text(json.dumps(content, indent=1) + "\n")

    @classmethod
    def load(cls, path: str | Path, env: gym.Env[Any, Any]) -> "FixedPolicy":
        """Read what `save` wrote."""
        content = json.loads(Path(path).read_text())
        agent = cls(env)
        agent.num_timesteps = content["num_timesteps"]
        agent.rng.bit_generator.state = content["generator"]
        return agent


class Random(FixedPolicy):
    """Every neuron equally likely, whatever the crawler senses: the untrained crawler."""

    def _probabilities(self, n_observations: int, n_actions: int) -> NDArray[np.float64]:
        return np.full((n_observations, n_actions), 1.0 / n_actions)


class Still(FixedPolicy):
    """Always the same neuron, that of the middle: the body settles and, but for a creep, stands still."""

    def _probabilities(self, n_observations: int, n_actions: int) -> NDArray[np.float64]:
        return np.tile(np.eye(n_actions)[n_actions // 2], (n_observations, 1))


class Wave(FixedPolicy):
    """Nearest-neighbour wiring, written by hand: each segment passes its contraction on towards the head."""

    def _probabilities(self, n_observations: int, n_actions: int) -> NDArray[np.float64]:
        if n_observations != n_actions:
            raise ValueError("the wave needs as many actions as observations")
        return np.eye(n_actions)
