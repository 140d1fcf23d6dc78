"""What `make_vec_env` of Stable-Baselines3 hands over: functions that make monitored crawlers, one each.

Crawlers that are stepped together are stepped past their wrappers. So those that change nothing are taken
off, and for a `Monitor` its reports are made here: `info["episode"]`, and a row in its file.
"""

import time
from collections.abc import Callable, Sequence
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.wrappers import OrderEnforcing, PassiveEnvChecker
from numpy.typing import NDArray
from stable_baselines3.common.monitor import Monitor

from crawler_bench.envs.crawler import CrawlerEnv

EnvMakers = Sequence[Callable[[], gym.Env[Any, Any]]]


def unwrap(makers: EnvMakers, kind: type[CrawlerEnv]) -> tuple[list[Any], list[Monitor]]:
    """Make the environments and take their wrappers off.

    Args:
        makers: one for each crawler.
        kind: the class that each is to be of.

    Returns:
        The crawlers, and the monitor of each or, if none is monitored, none.

    Raises:
        ValueError: if one is no such crawler or has a wrapper that would be gone, if two are the same, or
            only some are monitored.
    """
    crawlers: list[Any] = []
    monitors: list[Monitor] = []
    for make in makers:
        env = make()
        while isinstance(env, OrderEnforcing | PassiveEnvChecker | Monitor):
            if isinstance(env, Monitor):
                monitors.append(env)
            env = env.env
        if type(env) is not kind:
            raise ValueError(f"crawlers are stepped together without {env}: use DummyVecEnv for that")
        crawlers.append(env)
    if len(set(map(id, crawlers))) < len(crawlers):
        raise ValueError("every function must make a crawler of its own")
    if monitors and len(monitors) != len(crawlers):
        raise ValueError("either every crawler is monitored, once, or none")
    return crawlers, monitors


class EpisodeReports:
    """Return, length and time of each episode, as `Monitor` reports them.

    Args:
        monitors: one for each crawler; their files, keywords and lists of episodes are used.
    """

    def __init__(self, monitors: Sequence[Monitor]) -> None:
        self._monitors = monitors
        self._returns = np.zeros(len(monitors))
        self._lengths = np.zeros(len(monitors), dtype=np.int64)

    def begin(self) -> None:
        """All episodes begin.

        Raises:
            RuntimeError: if one has not ended whose monitor does not allow that.
        """
        for monitor, length in zip(self._monitors, self._lengths, strict=True):
            if length and not monitor.allow_early_resets:
                raise RuntimeError(
                    "a monitor with allow_early_resets=False wants episodes to end before a reset"
                )
        self._returns[:], self._lengths[:] = 0.0, 0

    def step(
        self, rewards: NDArray[np.float64], dones: NDArray[np.bool_], infos: Sequence[dict[str, Any]]
    ) -> None:
        """Count a decision of each crawler, and report the episodes that ended in their infos."""
        self._returns += rewards
        self._lengths += 1
        for i in dones.nonzero()[0].tolist():
            self._report(self._monitors[i], float(self._returns[i]), int(self._lengths[i]), infos[i])
        self._returns[dones], self._lengths[dones] = 0.0, 0

    def _report(self, monitor: Monitor, episode_return: float, length: int, info: dict[str, Any]) -> None:
        elapsed = time.time() - monitor.t_start
        monitor.episode_returns.append(episode_return)
        monitor.episode_lengths.append(length)
        monitor.episode_times.append(elapsed)
        monitor.total_steps += length
        report = {"r": round(episode_return, 6), "l": length, "t": round(elapsed, 6)}
        report |= {key: info[key] for key in monitor.info_keywords}
        if monitor.results_writer is not None:
            monitor.results_writer.write_row(report)
        info["episode"] = report

    def close(self) -> None:
        """Close the monitors and their files."""
        for monitor in self._monitors:
            monitor.close()
