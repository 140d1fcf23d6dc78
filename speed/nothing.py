"""An environment that costs nothing, to see what a learner takes for itself."""

from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv


class NothingVecEnv(VecEnv):
    """K environments with the spaces of a crawler that answer with what was prepared.

    Args:
        num_envs: K.
        n: observations and actions.
    """

    def __init__(self, num_envs: int, n: int = 10) -> None:
        super().__init__(num_envs, gym.spaces.Discrete(n), gym.spaces.Discrete(n))
        drawn = np.random.default_rng(0).integers(n, size=(64, num_envs))
        self._observations: list[NDArray[np.int64]] = list(drawn)
        self._rewards = np.zeros(num_envs, dtype=np.float32)
        self._dones = np.zeros(num_envs, dtype=bool)
        self._infos: list[dict[str, Any]] = [{} for _ in range(num_envs)]
        self._calls = 0

    def reset(self) -> NDArray[np.int64]:
        """The first observations."""
        return self._observations[0]

    def step_async(self, actions: NDArray[Any]) -> None:
        """Ignore the actions."""

    def step_wait(self) -> tuple[NDArray[np.int64], NDArray[np.float32], NDArray[np.bool_], list[Any]]:
        """The next observations, no reward, no end."""
        self._calls += 1
        return self._observations[self._calls % 64], self._rewards, self._dones, self._infos

    def close(self) -> None:
        """Nothing is open."""

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """Only a render mode, None."""
        if attr_name != "render_mode":
            raise AttributeError(attr_name)
        return [None for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """There is nothing to set."""

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any) -> list[Any]:
        """There are none."""
        raise AttributeError(method_name)

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """None is wrapped."""
        return [False for _ in self._get_indices(indices)]
