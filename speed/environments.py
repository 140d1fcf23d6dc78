"""Environments: steps per second through the interface that a learner uses."""

import warnings
from collections.abc import Callable
from importlib.util import find_spec
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

import crawler_bench
from speed.crawlers import diagonal_actions, random_actions
from speed.measure import MAKES_NO_SENSE, Effort, Row, Side, compare, missing

STEP_OVER_CARTPOLE = 0.8
OVER_SWIMMER = 30.0
BATCH = 256
UNIT = "steps"
INSTALL = "not installed: pip install crawler-bench[bench]"


def single(effort: Effort) -> list[Row]:
    """One environment through gym.make."""
    cartpole = Side("Gymnasium CartPole-v1, gym.make", _replayed(*_balanced_cartpole()))
    rows = []
    for name, actions in (("recorded diagonal actions", diagonal_actions()), ("random", random_actions())):
        what = f"gym.make, {name}"
        ours = Side(what, _replayed(gym.make(crawler_bench.ENV_ID), actions.tolist()))
        rows.append(compare(ours, cartpole, UNIT, effort, STEP_OVER_CARTPOLE))
    if find_spec("mujoco") is None:
        return [*rows, missing(rows[0].what, "MuJoCo Swimmer-v5, gym.make", UNIT, INSTALL)]
    swimmer = gym.make("Swimmer-v5")
    moves = list(np.random.default_rng(0).uniform(-1, 1, (1000, 2)))
    peer = Side("MuJoCo Swimmer-v5, gym.make", _replayed(swimmer, moves))
    ours = Side(rows[0].what, _replayed(gym.make(crawler_bench.ENV_ID), diagonal_actions().tolist()))
    return [*rows, compare(ours, peer, UNIT, effort)]


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


def vector(effort: Effort) -> list[Row]:
    """Many environments in one call."""
    ours = Side(f"gym.make_vec of {BATCH}", _crawlers(), BATCH)
    cartpoles = gym.make_vec("CartPole-v1", num_envs=BATCH)
    cartpoles.reset(seed=0)
    pushes = np.random.default_rng(0).integers(2, size=(64, BATCH))
    peer = Side(f"Gymnasium CartPole's vector class, {BATCH}", _stepped(cartpoles, pushes), BATCH)
    rows = [compare(ours, peer, UNIT, effort)]
    peers = (("Swimmer-v5", 16, float, OVER_SWIMMER), ("CartPole-v1", BATCH, np.int32, MAKES_NO_SENSE))
    for task, size, kind, goal in peers:
        name = f"EnvPool {task}, {size}"
        if find_spec("envpool") is None:
            rows.append(missing(ours.name, name, UNIT, INSTALL))
            continue
        rows.append(compare(ours, Side(name, _envpool(task, size, kind), size), UNIT, effort, goal))
    return rows


def _crawlers() -> Callable[[int], None]:
    env = gym.make_vec(crawler_bench.ENV_ID, num_envs=BATCH)
    env.reset(seed=0)
    return _stepped(env, np.random.default_rng(0).integers(10, size=(64, BATCH)))


def _stepped(env: Any, actions: NDArray[Any]) -> Callable[[int], None]:
    def work(n_calls: int) -> None:
        for i in range(n_calls):
            env.step(actions[i % len(actions)])

    return work


def _envpool(task: str, size: int, kind: Any) -> Callable[[int], None]:
    import envpool

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # its spaces are rounded to single precision
        env = envpool.make(task, env_type="gymnasium", num_envs=size, num_threads=1)
        env.reset()
    rng = np.random.default_rng(0)
    moves = rng.uniform(-1, 1, (64, size, 2)) if kind is float else rng.integers(2, size=(64, size))
    return _stepped(env, moves.astype(kind))
