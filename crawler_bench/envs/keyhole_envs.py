"""The crawler through a keyhole, as a Gymnasium environment and as a vector of them; see `keyholes`."""

from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector.utils import batch_space

from crawler_bench.envs.crawler import CrawlerEnv
from crawler_bench.envs.keyholes import (
    NOISE,
    ONE_HOT,
    STRAIN,
    Frames,
    KeyholeBatch,
    draw_errors,
    look,
    space,
)
from crawler_bench.envs.vector import CrawlerVectorEnv


class KeyholeEnv(CrawlerEnv):
    """The crawler, seen through a keyhole; physics, reward, ends and infos are those of `CrawlerEnv`.

    Args:
        keyhole: "one-hot", "strain" or "state".
        arguments: of `CrawlerEnv`.
    """

    def __init__(self, *arguments: Any, keyhole: str = ONE_HOT, **named: Any) -> None:
        super().__init__(*arguments, **named)
        self.keyhole = keyhole
        self.observation_space: gym.Space[Any] = space(keyhole, self.parameters.n_segments)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, Any]:
        """Put the crawler to rest and look at it."""
        gym.Env.reset(self, seed=seed)
        before = self.generator_state.copy()
        index, info = super().reset(options=options)
        return self._look(index, before, 1.0), info

    def step(self, action: Any) -> tuple[Any, float, bool, bool, Any]:
        """Decide as `CrawlerEnv.step` does, and look."""
        before, intervals = self.generator_state.copy(), float(self.odometer["episode_intervals"])
        index, reward, terminated, truncated, info = super().step(action)
        observed = float(self.odometer["episode_intervals"]) - intervals
        return self._look(index, before, observed), reward, terminated, truncated, info

    def _look(self, index: Any, before: Any, observed: float) -> Frames:
        errors = np.zeros((1, self.parameters.n_segments))
        if self.keyhole == STRAIN:
            draw_errors(before[None], np.array([observed]), self.task[0][NOISE : NOISE + 1], errors)
        shown: Frames = look(self.keyhole, np.array([int(index)]), self.nodes[None], errors)[0]
        return shown


class KeyholeVectorEnv(CrawlerVectorEnv):
    """K crawlers seen through a keyhole, stepped in one compiled call; otherwise a `CrawlerVectorEnv`.

    Args:
        keyhole: "one-hot", "strain" or "state".
        arguments: of `CrawlerVectorEnv`.
    """

    def __init__(self, *arguments: Any, keyhole: str = ONE_HOT, **named: Any) -> None:
        super().__init__(*arguments, **named)
        self.keyhole = keyhole
        self.crawlers: KeyholeBatch = KeyholeBatch.through(keyhole, self.crawlers)
        self.single_observation_space = space(keyhole, self.crawlers.n_segments)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)

    def reset(self, **named: Any) -> tuple[Any, Any]:
        """Put every crawler to rest and look at it."""
        _, infos = super().reset(**named)
        return self.crawlers.view.copy(), infos

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, Any]:
        """Decide as `CrawlerVectorEnv.step` does, and look."""
        _, rewards, terminated, truncated, infos = super().step(actions)
        if "final_obs" in infos:
            ended = infos["_final_obs"].nonzero()[0]
            for i in ended:
                infos["final_obs"][i] = self.crawlers.final_view[i]
        return self.crawlers.view.copy(), rewards, terminated, truncated, infos
