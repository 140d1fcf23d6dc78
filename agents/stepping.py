"""One decision in an environment of Gymnasium or in a vector of one of Stable-Baselines3, told alike."""

from typing import TYPE_CHECKING, Any, NamedTuple, Union

import gymnasium as gym
import numpy as np

if TYPE_CHECKING:  # it loads torch, which a table does not need
    from stable_baselines3.common.vec_env import VecEnv

Environment = Union[gym.Env[Any, Any], "VecEnv"]


class Step(NamedTuple):
    """What came of an action."""

    outcome: Any  # the observation that it led to
    observation: Any  # the one to act on next: the same, or the first of a new episode
    reward: float
    terminated: bool
    truncated: bool
    info: dict[str, Any]


def require_single(env: Environment) -> None:
    """Raise a ValueError unless a vector environment is one of one."""
    if not isinstance(env, gym.Env) and env.num_envs != 1:
        raise ValueError(f"a table learns from one environment at a time, not from {env.num_envs}")


def reset(env: Environment, seed: int | None = None) -> Any:
    """Begin an episode and return its first observation; a seed of None leaves the generator as it is."""
    if isinstance(env, gym.Env):
        return env.reset(seed=seed)[0]
    if seed is not None:
        env.seed(seed)
    return env.reset()[0]  # type: ignore[index,call-overload]


def step(env: Environment, action: int) -> Step:
    """Act, and begin another episode where one has ended."""
    if isinstance(env, gym.Env):
        outcome, reward, terminated, truncated, info = env.step(action)
        observation = reset(env) if terminated or truncated else outcome
        return Step(outcome, observation, float(reward), terminated, truncated, info)
    observations, rewards, dones, infos = env.step(np.array([action]))
    done, info = bool(dones[0]), infos[0]
    truncated = done and bool(info.get("TimeLimit.truncated", False))
    outcome = info["terminal_observation"] if done else observations[0]  # type: ignore[index,call-overload]
    return Step(outcome, observations[0], float(rewards[0]), done and not truncated, truncated, info)  # type: ignore[index,call-overload]
