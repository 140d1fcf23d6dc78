"""Learners: decisions per second, and what share of the time the environment takes."""

import time
from math import nan
from typing import Any

import gymnasium as gym
from numpy.typing import NDArray
from stable_baselines3 import DQN, PPO
from stable_baselines3.common.vec_env import VecEnv, VecEnvWrapper

import crawler_bench
from agents.qlearning import QLearning
from crawler_bench.envs.sb3 import CrawlerVecEnv
from speed.measure import Effort, Measurement, Side, compare

SHARE = 5.0  # % of a learner's time, with `JUDGED` crawlers
JUDGED = 8
UNIT = "% of the time in the environment"
ALGORITHMS: dict[str, Any] = {"PPO": PPO, "DQN": DQN}


def tabular(effort: Effort) -> list[Measurement]:
    """Tabular Q-learning in its compiled loop against the plain one, which steps the environment."""
    compiled, plain = (
        Side(
            f"tabular Q-learning, {name}",
            QLearning(gym.make(crawler_bench.ENV_ID), seed=0, compiled=name == "compiled").learn,
        )
        for name in ("compiled", "plain")
    )
    return [compare(compiled, plain, "decisions", effort)]


def shares(effort: Effort) -> list[Measurement]:
    """The environment's share of the time that learners of Stable-Baselines3 take, and their speed.

    The share is timed inside the run itself. To time the same learner on an environment that costs nothing
    instead would need far more repeats: learners vary by more from run to run than the share is large.
    """
    rows = []
    for name in ALGORITHMS:
        for n_envs in (JUDGED,) if effort.quick else (1, JUDGED, 64):
            share, per_second = _learn(name, n_envs, effort)
            goal = SHARE if n_envs == JUDGED else nan
            rows.append(
                Measurement(
                    "learning", f"SB3 {name}", share, UNIT, size=n_envs, per_second=per_second, at_most=goal
                )
            )
    return rows


def _learn(name: str, n_envs: int, effort: Effort) -> tuple[float, float]:
    """Share of the environment in %, decisions per second."""
    env = TimedVecEnv(CrawlerVecEnv(n_envs))
    if name == "PPO":  # one rollout
        settings = {"n_steps": 32 if effort.quick else 2048, "batch_size": 32 if effort.quick else 64}
        n_decisions = n_envs * settings["n_steps"]
    else:
        settings, n_decisions = {}, 400 if effort.quick else 4000 * n_envs
    agent = ALGORITHMS[name]("MlpPolicy", env, seed=0, device="cpu", **settings)
    start = time.process_time()
    agent.learn(n_decisions)
    taken = time.process_time() - start
    return 100.0 * env.seconds / taken, agent.num_timesteps / taken


class TimedVecEnv(VecEnvWrapper):
    """Adds up the CPU time that the environment takes."""

    def __init__(self, venv: VecEnv) -> None:
        super().__init__(venv)
        self.seconds = 0.0

    def reset(self) -> Any:
        """Reset, which is not timed."""
        return self.venv.reset()

    def step_async(self, actions: NDArray[Any]) -> None:
        """Hand the actions over."""
        start = time.process_time()
        self.venv.step_async(actions)
        self.seconds += time.process_time() - start

    def step_wait(self) -> Any:
        """Step all crawlers."""
        start = time.process_time()
        result = self.venv.step_wait()
        self.seconds += time.process_time() - start
        return result
