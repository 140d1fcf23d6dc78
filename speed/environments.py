"""Environments: steps per second through the interface that a learner uses."""

import sys
from collections.abc import Callable
from importlib.util import find_spec
from math import nan
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

import crawler_bench
from speed.measure import Effort, Measurement, Side, compare
from speed.physics import diagonal_actions, random_actions

STEP_OVER_CARTPOLE = 0.8
STEP_OVER_SWIMMER = 4.0
BATCH_OVER_ONE = 8.0
BATCH = 256
UNIT = "steps"


def single(effort: Effort) -> list[Measurement]:
    """One environment through gym.make."""
    cartpole = Side("Gymnasium CartPole-v1, gym.make", _replayed(*_balanced_cartpole()))
    diagonal = _crawler("recorded diagonal actions", diagonal_actions(effort.decisions))
    rows = [
        compare(ours, cartpole, UNIT, effort, STEP_OVER_CARTPOLE)
        for ours in (diagonal, _crawler("random", random_actions(effort.decisions)))
    ]
    if find_spec("mujoco") is None:
        print("not measured: MuJoCo is missing, `pip install crawler-bench[speed]`", file=sys.stderr)
        return rows
    moves = list(np.random.default_rng(0).uniform(-1, 1, (1000, 2)))
    swimmer = Side("MuJoCo Swimmer-v5, gym.make", _replayed(gym.make("Swimmer-v5"), moves))
    return [*rows, compare(diagonal, swimmer, UNIT, effort, STEP_OVER_SWIMMER)]


def _crawler(name: str, actions: NDArray[np.int64]) -> Side:
    return Side(f"gym.make, {name}", _replayed(gym.make(crawler_bench.ENV_ID), actions.tolist()))


def _balanced_cartpole() -> tuple[gym.Env[Any, Any], list[int]]:
    """CartPole with actions that keep its pole up, so that it is not reset again and again."""
    env = gym.make("CartPole-v1")
    observation, _ = env.reset(seed=0)
    actions: list[int] = []
    for _ in range(500):
        actions.append(int(observation[2] + 0.3 * observation[3] > 0))
        observation, _, terminated, truncated, _ = env.step(actions[-1])
        if terminated or truncated:
            break
    return env, actions


def _replayed(env: gym.Env[Any, Any], actions: list[Any]) -> Callable[[int], None]:
    """A function of the number of steps; every pass through the actions starts from the same reset."""

    def work(n_steps: int) -> None:
        for first in range(0, n_steps, len(actions)):
            env.reset(seed=0)
            for action in actions[: n_steps - first]:
                _, _, terminated, truncated, _ = env.step(action)
                if terminated or truncated:
                    env.reset()

    return work


def vector(effort: Effort) -> list[Measurement]:
    """Many environments in one call."""
    rng = np.random.default_rng(0)
    crawlers = gym.make_vec(crawler_bench.ENV_ID, num_envs=BATCH)
    ours = Side(f"gym.make_vec of {BATCH}", _stepped(crawlers, rng.integers(10, size=(64, BATCH))), BATCH)
    pushes = rng.integers(2, size=(64, BATCH))
    cartpoles = Side(
        f"Gymnasium CartPole's vector class, {BATCH}",
        _stepped(gym.make_vec("CartPole-v1", num_envs=BATCH), pushes), BATCH,
    )  # fmt: skip
    one = _crawler("random", random_actions(effort.decisions))
    peers = ((one, BATCH_OVER_ONE), (cartpoles, nan))
    return [compare(ours, peer, UNIT, effort, goal) for peer, goal in peers]


def _stepped(env: Any, actions: NDArray[Any]) -> Callable[[int], None]:
    env.reset()

    def work(n_calls: int) -> None:
        for i in range(n_calls):
            env.step(actions[i % len(actions)])

    return work
