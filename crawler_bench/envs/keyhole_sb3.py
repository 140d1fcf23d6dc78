"""Crawlers seen through a keyhole as a vector environment of Stable-Baselines3."""

from collections.abc import Sequence
from typing import Any

from crawler_bench.envs.keyholes import ONE_HOT, Frames, KeyholeBatch, space
from crawler_bench.envs.sb3 import CrawlerVecEnv
from crawler_bench.physics.parameters import CrawlerParameters


class KeyholeVecEnv(CrawlerVecEnv):
    """K crawlers for an agent of Stable-Baselines3, seen through a keyhole; otherwise a `CrawlerVecEnv`."""

    def __init__(
        self,
        num_envs: int = 8,
        parameters: CrawlerParameters | Sequence[CrawlerParameters] | None = None,
        regularization: Any = 0.01,
        noise: Any = 0.0,
        episode_distance: Any = 2.0,
        time_limit: Any = 1000.0,
        keyhole: str = ONE_HOT,
        **named: Any,
    ) -> None:
        task = (regularization, noise, episode_distance, time_limit)
        super().__init__(num_envs, parameters, *task, **named)
        chosen = parameters if parameters is not None else CrawlerParameters()
        self.crawlers: KeyholeBatch = KeyholeBatch(keyhole, chosen, num_envs, *task)
        self.observation_space = space(keyhole, self.crawlers.n_segments)

    def reset(self) -> Any:
        """Put every crawler to rest and look at it: (K, size) float32."""
        super().reset()
        return self.crawlers.view.copy()

    def step_wait(self) -> tuple[Any, Any, Any, list[Any]]:
        """Decide as `CrawlerVecEnv.step_wait` does, and look; the last look of an episode is in its info."""
        _, rewards, dones, infos = super().step_wait()
        seen: Frames = self.crawlers.view.copy()
        for i in dones.nonzero()[0]:
            infos[i]["terminal_observation"] = self.crawlers.final_view[i]
        return seen, rewards, dones, infos
