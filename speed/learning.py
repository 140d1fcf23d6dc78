"""Learners: decisions per second, and what share of the time the environment takes."""

import time
from collections.abc import Callable
from typing import Any

import gymnasium as gym
from numpy.typing import NDArray
from stable_baselines3 import DQN, PPO
from stable_baselines3.common.vec_env import VecEnv, VecEnvWrapper

import crawler_bench
from agents.qlearning import QLearning
from crawler_bench.envs.sb3 import CrawlerVecEnv
from speed.measure import MAKES_NO_SENSE, Effort, Row, Side, compare, summarize
from speed.nothing import NothingVecEnv

OVER_NOTHING = 0.95
N_ENVS = 8
ALGORITHMS: dict[str, Any] = {"PPO": PPO, "DQN": DQN}
UNIT = "decisions"


def tabular(effort: Effort) -> list[Row]:
    """Tabular Q-learning in its compiled loop against the plain one, which steps the environment."""
    compiled, plain = (
        Side(f"tabular Q-learning, {name}", _learner(on))
        for name, on in (("compiled", True), ("plain", False))
    )
    return [compare(compiled, plain, UNIT, effort)]


def _learner(compiled: bool) -> Callable[[int], Any]:
    agent = QLearning(gym.make(crawler_bench.ENV_ID), seed=0, compiled=compiled)
    return agent.learn


def over_nothing(effort: Effort) -> list[Row]:
    """Learners of Stable-Baselines3 on crawlers, and on an environment that costs nothing."""
    rows = []
    for name in ALGORITHMS:
        n = _decisions(name, N_ENVS, effort)
        pairs = []
        for repeat in range(effort.learning_rounds):
            speeds = [_learn(name, kind(N_ENVS), n, effort, repeat)["per_second"] for kind in _KINDS]
            pairs.append((speeds[0], speeds[1]))
        what, peer = f"SB3 {name}, {N_ENVS} crawlers", f"SB3 {name}, {N_ENVS} environments that do nothing"
        rows.append(summarize(what, peer, UNIT, pairs, OVER_NOTHING))
    return rows


_KINDS: tuple[Callable[[int], VecEnv], ...] = (CrawlerVecEnv, NothingVecEnv)


def shares(effort: Effort) -> list[dict[str, Any]]:
    """A row for each algorithm and number of crawlers: speed, gradient updates, the environment's share."""
    return [
        {"learner": f"SB3 {name}", "crawlers": n_envs}
        | _learn(name, CrawlerVecEnv(n_envs), _decisions(name, n_envs, effort), effort, 0)
        for name in ALGORITHMS
        for n_envs in (1, 8, 64)
    ]


def _decisions(name: str, n_envs: int, effort: Effort) -> int:
    """How many decisions to learn from: of PPO one rollout, of DQN about as long."""
    if name == "PPO":
        return n_envs * (32 if effort.quick else 2048)
    return 400 if effort.quick else 4000 * n_envs


def _learn(name: str, env: VecEnv, n_decisions: int, effort: Effort, seed: int) -> dict[str, float]:
    timed = _Timed(env)
    settings = {"n_steps": 32, "batch_size": 32} if name == "PPO" and effort.quick else {}
    agent = ALGORITHMS[name]("MlpPolicy", timed, seed=seed, device="cpu", **settings)
    updates = [0]
    agent.policy.optimizer.register_step_post_hook(lambda *_: updates.__setitem__(0, updates[0] + 1))
    start = time.process_time()
    agent.learn(n_decisions)
    taken = time.process_time() - start
    made = agent.num_timesteps
    return {
        "decisions": made,
        "gradient_updates": updates[0],
        "per_second": made / taken if taken > 0 else MAKES_NO_SENSE,
        "environment_share": timed.seconds / taken,
    }


class _Timed(VecEnvWrapper):
    """Counts the time that the environment takes."""

    def __init__(self, venv: VecEnv) -> None:
        super().__init__(venv)
        self.seconds = 0.0

    def reset(self) -> Any:
        return self.venv.reset()

    def step_async(self, actions: NDArray[Any]) -> None:
        start = time.process_time()
        self.venv.step_async(actions)
        self.seconds += time.process_time() - start

    def step_wait(self) -> Any:
        start = time.process_time()
        result = self.venv.step_wait()
        self.seconds += time.process_time() - start
        return result
