"""Many crawlers as a vector environment of Stable-Baselines3, stepped in one compiled call.

Only this module of the environments and `monitors` need Stable-Baselines3.
"""

import copy
from collections.abc import Sequence
from typing import Any, cast

import gymnasium as gym
import numpy as np
from gymnasium.envs.registration import EnvSpec
from numpy.typing import NDArray
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import VecEnv
from stable_baselines3.common.vec_env.base_vec_env import VecEnvIndices

from crawler_bench import KEYHOLE_IDS
from crawler_bench.envs.batch import CENTROID, REWARD, CrawlerBatch
from crawler_bench.envs.crawler import CrawlerEnv
from crawler_bench.envs.keyholes import INDEX
from crawler_bench.envs.monitors import EnvMakers, EpisodeReports, unwrap
from crawler_bench.envs.specification import with_longest_episode
from crawler_bench.envs.transition import make_task, most_decisions
from crawler_bench.physics.parameters import CrawlerParameters

Info = dict[str, Any]
Numbers = float | Sequence[float]
Settings = tuple[Numbers, Numbers, Numbers, Numbers]
SETTINGS = ("regularization", "noise", "episode_distance", "time_limit")


class CrawlerVecEnv(VecEnv):
    """K crawlers for an agent of Stable-Baselines3; see `CrawlerEnv` for what each of them is.

    `parameters` and the four numbers of the task may be given once for all or as a sequence, one for each
    crawler; the number of segments must be the same. Crawler i with seed s gives the numbers of a
    `CrawlerEnv` with seed s.

    `make_vec_env("crawler_bench/Crawler-v0", n_envs=64, vec_env_cls=CrawlerVecEnv)` makes one, too.

    The crawlers are rows of arrays and not objects: `get_attr` and `set_attr` know `parameters` and `spec`
    (to read) and the numbers of the task, and keep whatever else is set; `env_method` knows Gymnasium's
    `get_wrapper_attr`, `set_wrapper_attr` and `has_wrapper_attr`, which do the same.

    An info is empty except where an episode ended: then it holds `terminal_observation`,
    `TimeLimit.truncated` (True: a crawler has no terminal state), and `end`, `time` and `centroid` as the
    info of `CrawlerEnv` does; `episode`, too, if `make_vec_env` has made it.

    Args:
        num_envs: K, or the K functions from which `make_vec_env` makes it; these then say all the rest.
        parameters: of the bodies.
        regularization: epsilon of eq. 11, at least 0.
        noise: largest error of a sensed strain, at least 0.
        episode_distance: L, above 0.
        time_limit: tau_theta, above 0.
        render_mode: None or "rgb_array"; `render` tiles the pictures, `render("human")` shows them.

    Raises:
        ValueError: if an argument is not possible, or a function makes no crawler or one with wrappers of its
            own.
    """

    keyhole = INDEX

    def __init__(
        self,
        num_envs: int | EnvMakers = 8,
        parameters: CrawlerParameters | Sequence[CrawlerParameters] | None = None,
        regularization: float | Sequence[float] = 0.01,
        noise: float | Sequence[float] = 0.0,
        episode_distance: float | Sequence[float] = 8.83,
        time_limit: float | Sequence[float] = 4000.0,
        render_mode: str | None = None,
    ) -> None:
        given: Settings = (regularization, noise, episode_distance, time_limit)
        self._reports: EpisodeReports | None = None
        if isinstance(num_envs, Sequence):
            crawlers, monitors = self._unwrap(num_envs)
            parameters = [each.parameters for each in crawlers]
            given = cast(Settings, tuple(map(list, zip(*(each.settings for each in crawlers), strict=True))))
            num_envs, render_mode = len(crawlers), crawlers[0].render_mode if crawlers else None
            self._reports = EpisodeReports(monitors) if monitors else None
        if render_mode not in (None, "rgb_array"):
            raise ValueError(f"render_mode = {render_mode!r} is not possible: it must be None or 'rgb_array'")
        chosen = parameters if parameters is not None else CrawlerParameters()
        self.crawlers = CrawlerBatch(chosen, num_envs, *given)
        self._attributes: list[dict[str, Any]] = [
            {"render_mode": render_mode, "parameters": each} for each in self.crawlers.parameters
        ]
        for name, value in zip(SETTINGS, given, strict=True):
            values = value if isinstance(value, Sequence | np.ndarray) else [value] * num_envs
            for attributes, each in zip(self._attributes, values, strict=True):
                attributes[name] = float(each)
        self._seeded = False
        self._actions: NDArray[Any] = np.zeros(num_envs, dtype=np.int64)
        n = self.crawlers.n_segments
        super().__init__(num_envs, gym.spaces.Discrete(n), gym.spaces.Discrete(n))

    def _unwrap(self, makers: EnvMakers) -> tuple[list[CrawlerEnv], list[Monitor]]:
        return unwrap(makers, CrawlerEnv)

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
        if self._reports is not None:
            self._reports.begin()
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
            ResetNeeded: before the first reset.
        """
        crawlers = self.crawlers
        n_ended = crawlers.decide(self._actions)
        rewards, dones = crawlers.outcome[:, REWARD].copy(), crawlers.ended.copy()
        infos: list[Info] = [{} for _ in range(self.num_envs)]
        if n_ended:
            for i in dones.nonzero()[0].tolist():
                infos[i] = self._last_info(i)
            crawlers.begin(dones)
        if self._reports is not None:
            self._reports.step(rewards, dones, infos)
        return crawlers.observation.copy(), rewards.astype(np.float32), dones, infos

    def _last_info(self, i: int) -> Info:
        crawlers = self.crawlers
        intervals = float(crawlers.odometers["episode_intervals"][i])
        return {
            "terminal_observation": crawlers.observation[i],
            "TimeLimit.truncated": True,
            "end": int(crawlers.end[i]),
            "time": intervals * crawlers.parameters[i].decision_interval,
            "centroid": float(crawlers.outcome[i, CENTROID]),
        }

    def get_images(self) -> Sequence[NDArray[np.uint8]]:
        """A picture of each crawler, (height, width, 3)."""
        return self.crawlers.draw()

    @property
    def lifetime(self) -> tuple[float, float]:
        """Time and distance that all crawlers together have crawled since they were made, through resets."""
        odometers = self.crawlers.odometers
        intervals = np.array([each.decision_interval for each in self.crawlers.parameters])
        time = float((odometers["lifetime_intervals"] * intervals).sum())
        return time, float(odometers["lifetime_distance"].sum())

    def close(self) -> None:
        """Close the files of the monitors, if there are any."""
        if self._reports is not None:
            self._reports.close()

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        """Values of an attribute of the crawlers.

        Raises:
            AttributeError: if one has none of this name.
        """
        chosen = list(self._get_indices(indices))
        if attr_name == "spec":
            return [self._spec(self._attributes[i]) for i in chosen]
        if any(attr_name not in self._attributes[i] for i in chosen):
            raise AttributeError(f"a crawler of a batch has no attribute {attr_name!r}")
        return [self._attributes[i][attr_name] for i in chosen]

    def _spec(self, attributes: dict[str, Any]) -> EnvSpec | None:
        """What `gym.make` needs to make such a crawler."""
        spec = copy.deepcopy(gym.spec(KEYHOLE_IDS[self.keyhole]))
        spec.kwargs |= {name: attributes[name] for name in ("parameters", *SETTINGS, "render_mode")}
        return with_longest_episode(spec, most_decisions(attributes["parameters"], attributes["time_limit"]))

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        """Set an attribute of the crawlers; a setting of the task holds from the next step on.

        Raises:
            AttributeError: if it is `parameters` or `spec`, which cannot change.
        """
        if attr_name in ("parameters", "spec"):
            raise AttributeError(f"the {attr_name} of a crawler cannot change: make another CrawlerVecEnv")
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
        """Get, set or look for an attribute, as with Gymnasium's wrappers; there are no other methods.

        Raises:
            AttributeError: if it is another method, or an attribute that is not there or cannot change.
        """
        if method_name not in ("get_wrapper_attr", "set_wrapper_attr", "has_wrapper_attr"):
            raise AttributeError(f"a crawler of a batch has no method {method_name!r}")
        chosen = list(self._get_indices(indices))
        name, *value = method_args
        if method_name == "get_wrapper_attr":
            return self.get_attr(name, chosen)
        if method_name == "has_wrapper_attr":
            return [self.has_attr(name)] * len(chosen)
        self.set_attr(name, value[0], chosen)
        return [True] * len(chosen)

    def env_is_wrapped(
        self, wrapper_class: type[gym.Wrapper[Any, Any, Any, Any]], indices: VecEnvIndices = None
    ) -> list[bool]:
        """No crawler is wrapped; where `make_vec_env` asks for a `Monitor`, its reports are given."""
        monitored = self._reports is not None and issubclass(Monitor, wrapper_class)
        return [monitored for _ in self._get_indices(indices)]
