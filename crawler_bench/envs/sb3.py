"""Many crawlers as a vector environment of Stable-Baselines3, stepped in one compiled call.

This is the only module of the environments that needs Stable-Baselines3.
"""

from collections.abc import Sequence
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv
from stable_baselines3.common.vec_env.base_vec_env import VecEnvIndices

from crawler_bench.envs.batch import REWARD, CrawlerBatch
from crawler_bench.envs.transition import END_NAMES, make_task
from crawler_bench.physics.parameters import CrawlerParameters

Info = dict[str, Any]
SETTINGS = ("regularization", "noise", "episode_distance", "time_limit")


class CrawlerVecEnv(VecEnv):
    """K crawlers for an agent of Stable-Baselines3; see `CrawlerEnv` for what each of them is.

    Every argument may be given once for all or as a sequence, one for each crawler; the number of segments
    must be the same. Crawler i with seed s gives the numbers of a `CrawlerEnv` with seed s.

    The crawlers are rows of arrays and not objects: `get_attr` and `set_attr` know `parameters` (to read) and
    the other arguments, and keep whatever else is set; there are no methods for `env_method`.

    An info is empty except where an episode ended: then it holds `terminal_observation`,
    `TimeLimit.truncated` (True: a crawler has no terminal state) and `end`, "distance" or "time".
    """

    def __init__(
        self,
        num_envs: int = 8,
        parameters: CrawlerParameters | Sequence[CrawlerParameters] | None = None,
        regularization: float | Sequence[float] = 0.01,
        noise: float | Sequence[float] = 0.0,
        episode_distance: float | Sequence[float] = 2.0,
        time_limit: float | Sequence[float] = 1000.0,
    ) -> None:
        given = (regularization, noise, episode_distance, time_limit)
        chosen = parameters if parameters is not None else CrawlerParameters()
        self.crawlers = CrawlerBatch(chosen, num_envs, *given)
        self._attributes: list[dict[str, Any]] = [
            {"render_mode": None, "parameters": each} for each in self.crawlers.parameters
        ]
        for name, value in zip(SETTINGS, given, strict=True):
            values = value if isinstance(value, Sequence | np.ndarray) else [value] * num_envs
            for attributes, each in zip(self._attributes, values, strict=True):
                attributes[name] = float(each)
        self._seeded = False
        self._actions: NDArray[Any] = np.zeros(num_envs, dtype=np.int64)
        n = self.crawlers.n_segments
        super().__init__(num_envs, gym.spaces.Discrete(n), gym.spaces.Discrete(n))

    def reset(self) -> NDArray[np.int64]:
        """Put every crawler to rest.

        Returns:
            (K,) observations.
        """
        if self._seeds[0] is None and not self._seeded:
            self.seed(int(np.random.SeedSequence().generate_state(1)[0]))
        if self._seeds[0] is not None:
            self.crawlers.seed(self._seeds)
            self._seeded = True
        self._reset_seeds()
        self._reset_options()  # they have no meaning here
        self.crawlers.begin()
        return self.crawlers.observation.copy()

    def step_async(self, actions: NDArray[Any]) -> None:
        """Choose the neuron of each crawler that is ON in the next decision interval."""
        self._actions = actions

    def step_wait(self) -> tuple[NDArray[np.int64], NDArray[np.float32], NDArray[np.bool_], list[Info]]:
        """Hold the chosen neurons ON for a decision interval; reset every crawler whose episode ended.

        Returns:
            Observations, rewards and ends of episodes, (K,) each, and K infos.

        Raises:
            ValueError: if the actions are not K neurons, 0 to N - 1.
        """
        crawlers = self.crawlers
        n_ended = crawlers.decide(self._actions)
        rewards, dones = crawlers.outcome[:, REWARD].astype(np.float32), crawlers.end.astype(np.bool_)
        infos: list[Info] = [{} for _ in range(self.num_envs)]
        if n_ended:
            for i in dones.nonzero()[0]:
                infos[i] = {
                    "terminal_observation": crawlers.observation[i],
                    "TimeLimit.truncated": True,
                    "end": END_NAMES[crawlers.end[i]],
                }
            crawlers.begin_ended()
        return crawlers.observation.copy(), rewards, dones, infos

    @property
    def lifetime(self) -> tuple[float, float]:
        """Time and distance that all crawlers together have crawled since they were made, through resets."""
        odometers = self.crawlers.odometers
        intervals = np.array([each.decision_interval for each in self.crawlers.parameters])
        time = float((odometers["lifetime_intervals"] * intervals).sum())
        return time, float(odometers["lifetime_distance"].sum())

    def close(self) -> None:
        """Nothing is open."""

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        """Values of an attribute of the crawlers.

        Raises:
            AttributeError: if one has none of this name.
        """
        chosen = list(self._get_indices(indices))
        if any(attr_name not in self._attributes[i] for i in chosen):
            raise AttributeError(f"a crawler of a batch has no attribute {attr_name!r}")
        return [self._attributes[i][attr_name] for i in chosen]

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        """Set an attribute of the crawlers; a setting of the task holds from the next step on.

        Raises:
            AttributeError: if it is `parameters`, which cannot change.
        """
        if attr_name == "parameters":
            raise AttributeError("the parameters of a crawler cannot change: make another CrawlerVecEnv")
        tasks = {}
        for i in self._get_indices(indices):
            attributes = self._attributes[i] | {attr_name: value}
            if attr_name in SETTINGS:
                attributes[attr_name] = float(value)
                settings = (attributes[name] for name in SETTINGS)
                tasks[i] = make_task(attributes["parameters"], *settings)
            self._attributes[i] = attributes
        self.crawlers.set_tasks(tasks)

    def env_method(
        self, method_name: str, *method_args: Any, indices: VecEnvIndices = None, **method_kwargs: Any
    ) -> list[Any]:
        """There are none.

        Raises:
            AttributeError: always.
        """
        raise AttributeError(f"a crawler of a batch has no method {method_name!r}")

    def env_is_wrapped(
        self, wrapper_class: type[gym.Wrapper[Any, Any, Any, Any]], indices: VecEnvIndices = None
    ) -> list[bool]:
        """No crawler is wrapped."""
        return [False for _ in self._get_indices(indices)]
