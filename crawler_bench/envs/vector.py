"""Many crawlers as a Gymnasium vector environment."""

from collections.abc import Sequence
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from crawler_bench.envs.batch import CENTROID, DISPLACED, GRADIENT, REWARD, CrawlerBatch
from crawler_bench.envs.transition import END_NAMES, RUNNING
from crawler_bench.physics.parameters import CrawlerParameters

Info = dict[str, Any]


class CrawlerVectorEnv(VectorEnv[Any, Any, Any]):
    """K crawlers, stepped in one compiled call; see `CrawlerEnv` for what each of them is.

    Every argument of `CrawlerEnv` but the render mode may be given once for all or as a sequence, one for
    each crawler; the number of segments must be the same. Crawler i with seed s gives the numbers of a
    `CrawlerEnv` with seed s. A crawler whose episode ends is reset within the same step (autoreset mode
    SAME_STEP): its last observation and info stand in `infos["final_obs"]` and `infos["final_info"]`.

    `gym.make_vec("crawler_bench/Crawler-v0", num_envs=256)` makes one.
    """

    metadata: dict[str, Any] = {"autoreset_mode": AutoresetMode.SAME_STEP, "render_modes": []}  # noqa: RUF012

    def __init__(
        self,
        num_envs: int = 1,
        parameters: CrawlerParameters | Sequence[CrawlerParameters] | None = None,
        regularization: float | Sequence[float] = 0.01,
        noise: float | Sequence[float] = 0.0,
        episode_distance: float | Sequence[float] = 2.0,
        time_limit: float | Sequence[float] = 1000.0,
        render_mode: str | None = None,
    ) -> None:
        if render_mode is not None:
            raise ValueError("a vector of crawlers is not rendered; render a single CrawlerEnv")
        self.num_envs = num_envs
        self.render_mode = None
        self.crawlers = CrawlerBatch(
            parameters if parameters is not None else CrawlerParameters(), num_envs,
            regularization, noise, episode_distance, time_limit,
        )  # fmt: skip
        n = self.crawlers.n_segments
        self.single_observation_space = gym.spaces.Discrete(n)
        self.single_action_space = gym.spaces.Discrete(n)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._intervals = np.array([each.decision_interval for each in self.crawlers.parameters])
        self._seeded = False

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.int64], Info]:
        """Put every crawler to rest.

        Args:
            seed: one for each crawler, or the first of K successive ones, or None to go on drawing.
            options: no meaning here.
        """
        if seed is None and not self._seeded:
            seed = int(np.random.SeedSequence().generate_state(1)[0])
        if seed is not None:
            seeds = (
                list(range(seed, seed + self.num_envs)) if isinstance(seed, int | np.integer) else list(seed)
            )
            if len(seeds) != self.num_envs:
                raise ValueError(f"{len(seeds)} seeds for {self.num_envs} crawlers")
            self.crawlers.seed(seeds)
            self._seeded = True
        self.crawlers.begin()
        return self.crawlers.observation.copy(), self._infos()

    def step(
        self, actions: Any
    ) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], Info]:
        """Hold one neuron of each crawler ON for a decision interval.

        Raises:
            ValueError: if the actions are not K neurons, 0 to N - 1.
        """
        crawlers = self.crawlers
        n_ended = crawlers.decide(actions)
        crawlers.report()
        truncated = crawlers.end != RUNNING
        rewards, infos = crawlers.outcome[:, REWARD].copy(), self._infos()
        if n_ended:
            final_observation = crawlers.observation.copy()
            crawlers.begin_ended()
            infos = self._infos() | {
                "final_obs": final_observation, "_final_obs": truncated,
                "final_info": infos, "_final_info": truncated,
            }  # fmt: skip
        terminated = np.zeros(self.num_envs, dtype=bool)
        return crawlers.observation.copy(), rewards, terminated, truncated, infos

    def _infos(self) -> Info:
        crawlers = self.crawlers
        nodes, outcome = crawlers.nodes, crawlers.outcome.copy()
        return {
            "time": crawlers.odometers["episode_intervals"] * self._intervals,
            "centroid": outcome[:, CENTROID],
            "displacement": outcome[:, DISPLACED],
            "strain_gradient": outcome[:, GRADIENT],
            "strain": nodes["strain"][:, :-1].copy(),
            "muscle_force": nodes["force"].copy(),
            "node_velocity": nodes["velocity"].copy(),
            "power": nodes["power"].copy(),
            "end": _ENDS[crawlers.end],
        }


_ENDS = np.array(END_NAMES, dtype=object)
