"""Crawlers seen through a keyhole as a vector environment of Stable-Baselines3."""

from typing import Any

from stable_baselines3.common.monitor import Monitor

from crawler_bench.envs.crawler import CrawlerEnv
from crawler_bench.envs.keyhole_envs import KeyholeEnv
from crawler_bench.envs.keyholes import ONE_HOT, Frames, KeyholeBatch, space
from crawler_bench.envs.monitors import EnvMakers, unwrap
from crawler_bench.envs.sb3 import CrawlerVecEnv


class KeyholeVecEnv(CrawlerVecEnv):
    """K crawlers for an agent of Stable-Baselines3, seen through a keyhole; otherwise a `CrawlerVecEnv`.

    Args:
        keyhole: "one-hot", "strain" or "state"; where `make_vec_env` makes it, that of its id.
        arguments: of `CrawlerVecEnv`.

    Raises:
        ValueError: as `CrawlerVecEnv` does, or if the crawlers are seen through several keyholes.
    """

    def __init__(self, *arguments: Any, keyhole: str = ONE_HOT, **named: Any) -> None:
        self.keyhole = keyhole
        super().__init__(*arguments, **named)
        self.crawlers: KeyholeBatch = KeyholeBatch.through(self.keyhole, self.crawlers)
        self.observation_space = space(self.keyhole, self.crawlers.n_segments)

    def _unwrap(self, makers: EnvMakers) -> tuple[list[CrawlerEnv], list[Monitor]]:
        crawlers, monitors = unwrap(makers, KeyholeEnv)
        if len(keyholes := {each.keyhole for each in crawlers}) > 1:
            raise ValueError(f"crawlers are stepped together through one keyhole, not {sorted(keyholes)}")
        self.keyhole = next(iter(keyholes), self.keyhole)
        return crawlers, monitors

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
