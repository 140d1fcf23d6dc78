"""One decision in an environment of Gymnasium or in a vector of one of Stable-Baselines3, told alike."""

from typing import TYPE_CHECKING, Any, NamedTuple, Union

import gymnasium as gym
import numpy as np

from crawler_bench.envs.crawler import CrawlerEnv

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
    return env.reset()[0]  # type: ignore[index]


def step(env: Environment, action: int) -> Step:
    """Act, and begin another episode where one has ended."""
    if isinstance(env, gym.Env):
        outcome, reward, terminated, truncated, info = env.step(action)
        observation = reset(env) if terminated or truncated else outcome
        return Step(outcome, observation, float(reward), terminated, truncated, info)
    observations, rewards, dones, infos = env.step(np.array([action]))
    done, info = bool(dones[0]), infos[0]
    truncated = done and bool(info.get("TimeLimit.truncated", False))
    outcome = info["terminal_observation"] if done else observations[0]  # type: ignore[index]
    return Step(outcome, observations[0], float(rewards[0]), done and not truncated, truncated, info)  # type: ignore[index]


def crawler_in(env: Environment | None) -> CrawlerEnv | None:
    """The crawler in an environment, or in a vector of one that steps it as an object."""
    inner: Any = env.unwrapped if env is not None else None
    if inner is not None and not isinstance(inner, gym.Env) and hasattr(inner, "envs"):
        inner = inner.envs[0].unwrapped
    return inner if isinstance(inner, CrawlerEnv) else None


def shape_of(env: Environment) -> tuple[int, int]:
    """Numbers of observations and actions; raises a ValueError unless they are Discrete."""
    observations, actions = env.observation_space, env.action_space
    if not (isinstance(observations, gym.spaces.Discrete) and isinstance(actions, gym.spaces.Discrete)):
        raise ValueError(f"a table needs Discrete spaces; this environment has {observations} and {actions}")
    return int(observations.n), int(actions.n)


def start_of(space: Any) -> int:
    """The lowest value of a Discrete space."""
    return int(space.start)
