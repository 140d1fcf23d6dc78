"""An environment that records itself, for learning loops that know nothing of ours.

`crawler_bench.record(env, folder)` counts, in windows of WINDOW decisions, how far the crawler has come, what
it earned, and which neuron was turned ON at which index. Every environment appends to a file of its own, so
several, in one process or many, may share a folder; a killed loop loses at most a window.
"""

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv, VectorWrapper

from crawler_bench.envs.crawler import CrawlerEnv
from crawler_bench.envs.transition import Task

WINDOW = 1000  # decisions
ABOUT = "recorded.json"  # what was recorded
COUNTERS = ("decisions", "time", "distance", "reward", "episodes")  # columns of a file, then the counts
MOST_ENVIRONMENTS = 10_000
_PENALTIES = [Task._fields.index(name) for name in ("penalty", "penalty_rate")]
_NOISE = Task._fields.index("noise")


def record(env: Any, folder: str | Path, agent: str = "", seed: int | None = None) -> Any:
    """Make a crawler record what a learner does with it, for `crawler-bench benchmark --runs`.

    Args:
        env: of `gym.make` or `gym.make_vec`, with any of our ids and any wrappers.
        folder: of this run; made if missing. Several environments of one run share it.
        agent: its name in the tables; by default that of the folder, without a number at its end.
        seed: of the run; by default the number at the end of the folder's name, or 0.

    Returns:
        The environment, wrapped.

    Raises:
        TypeError: if it is no crawler.
    """
    log = _Log(env, Path(folder), agent, seed)
    return _RecordedVector(env, log) if isinstance(env, VectorEnv) else _Recorded(env, log)


class _Log:
    """One file of a recording."""

    def __init__(self, env: Any, folder: Path, agent: str, seed: int | None) -> None:
        crawler = env.unwrapped
        bodies = getattr(crawler, "crawlers", None)
        if not (isinstance(crawler, CrawlerEnv) or bodies is not None):
            raise TypeError(f"record needs a crawler of ours, not {crawler}")
        self.crawler, self.bodies = crawler, bodies
        parameters = crawler.parameters if bodies is None else bodies.parameters[0]
        task = crawler.task[0] if bodies is None else bodies._tasks[0]
        penalty, rate = (float(task[place]) for place in _PENALTIES)
        about = {
            "agent": agent, "seed": seed, "keyhole": getattr(crawler, "keyhole", "index"),
            "parameters": asdict(parameters), "noise": float(task[_NOISE]),
            "regularization": penalty or rate / parameters.decision_interval,
        }  # fmt: skip
        folder.mkdir(parents=True, exist_ok=True)
        (folder / ABOUT).write_text(json.dumps(about, indent=1) + "\n")
        self.path = _claim(folder)
        n = parameters.n_segments
        names = [f"a_{o}_{a}" for o in range(n) for a in range(n)]
        self.path.write_text(",".join([*COUNTERS, *names]) + "\n")
        self.counts = np.zeros((n, n), dtype=np.int64)
        self.decisions, self.written, self.reward, self.episodes = 0, 0, 0.0, 0
        self.interval = parameters.decision_interval

    @property
    def observed(self) -> Any:
        """Index of the most contracted segment that was last sensed, whatever the keyhole shows of it."""
        odometer = self.crawler.odometer if self.bodies is None else self.bodies.odometers
        return np.atleast_1d(np.asarray(odometer["observation"], dtype=np.int64)).copy()

    def add(self, observed: Any, action: Any, reward: Any, ended: Any) -> None:
        """Count a decision of every crawler."""
        np.add.at(self.counts, (observed, np.atleast_1d(np.asarray(action, dtype=np.int64))), 1)
        self.decisions += observed.size
        self.reward += float(np.sum(reward))
        self.episodes += int(np.sum(ended))
        if self.decisions - self.written >= WINDOW:
            self.write()

    def write(self) -> None:
        """Append a window."""
        if self.decisions == self.written:
            return
        time, distance = self._lifetime()
        row = [self.decisions, time, distance, self.reward, self.episodes, *self.counts.ravel().tolist()]
        with self.path.open("a") as file:
            file.write(",".join(map(repr, row)) + "\n")
        self.written = self.decisions
        self.counts[:] = 0

    def _lifetime(self) -> tuple[float, float]:
        if self.bodies is None:
            time, distance = self.crawler.lifetime
            return float(time), float(distance)
        odometers = self.bodies.odometers
        time = float(odometers["lifetime_intervals"].sum()) * self.interval
        return time, float(odometers["lifetime_distance"].sum())


def _claim(folder: Path) -> Path:
    """A file that no other environment of this recording has."""
    for number in range(MOST_ENVIRONMENTS):
        path = folder / f"crawler-{number:04d}.csv"
        try:
            path.open("x").close()
        except FileExistsError:
            continue
        return path
    raise OSError(f"{folder} holds {MOST_ENVIRONMENTS} recordings: choose another folder")


class _Recorded(gym.Wrapper[Any, Any, Any, Any]):
    """A single crawler that records itself."""

    def __init__(self, env: Any, log: _Log) -> None:
        super().__init__(env)
        self.log = log

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Step, and count."""
        observed = self.log.observed
        made = self.env.step(action)
        self.log.add(observed, action, made[1], made[2] or made[3])
        return made

    def close(self) -> None:
        """Write what is left, and close."""
        self.log.write()
        super().close()


class _RecordedVector(VectorWrapper):
    """A vector of crawlers that records itself."""

    def __init__(self, env: Any, log: _Log) -> None:
        super().__init__(env)
        self.log = log
        self._resets_next = env.metadata.get("autoreset_mode") is AutoresetMode.NEXT_STEP
        self._ended = np.zeros(env.num_envs, dtype=np.bool_)

    def reset(self, **named: Any) -> tuple[Any, dict[str, Any]]:
        """Reset; nothing is left to be reset by the next step."""
        self._ended[:] = False
        return self.env.reset(**named)

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Step, and count; a step that resets a crawler decides nothing."""
        observed, decided = self.log.observed, ~self._ended
        made = self.env.step(actions)
        ended = np.logical_or(made[2], made[3])
        self.log.add(
            observed[decided], np.asarray(actions)[decided], np.asarray(made[1])[decided], ended[decided]
        )
        if self._resets_next:
            self._ended = ended
        return made

    def close(self, **named: Any) -> None:
        """Write what is left, and close."""
        self.log.write()
        super().close(**named)
