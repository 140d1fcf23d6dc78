"""DQN and PPO of Stable-Baselines3, set up for the crawler: one torch thread, scaled rewards, gamma of [M20].

A decision earns about a thousandth of a rest length, far below the rewards of order one that the defaults of
deep agents assume; so both see rewards multiplied by REWARD_SCALE, which changes no optimal policy. All else
that a configuration does not set is Stable-Baselines3's default; Adam runs as one fused kernel and
distributions do not check their own arguments, which changes the time and not the learning.
"""

from typing import Any

import gymnasium as gym
import numpy as np
import stable_baselines3
import torch
from stable_baselines3.common.vec_env import DummyVecEnv, VecEnv, VecEnvWrapper
from stable_baselines3.common.vec_env.base_vec_env import VecEnvStepReturn

REWARD_SCALE = 100.0
DISCOUNT = 0.95  # gamma of [M20], as the table has


class ScaledRewards(VecEnvWrapper):
    """Multiplies every reward by a constant."""

    def __init__(self, venv: VecEnv, scale: float) -> None:
        super().__init__(venv)
        self.scale = np.float32(scale)

    def reset(self) -> Any:
        """Reset all environments."""
        return self.venv.reset()

    def step_wait(self) -> VecEnvStepReturn:
        """Step, and scale the rewards."""
        observations, rewards, dones, infos = self.venv.step_wait()
        return observations, rewards * self.scale, dones, infos


class Deep:
    """What both share; stands before an algorithm of Stable-Baselines3 in the bases of a class.

    Args:
        env: one environment or a vector of them.
        seed: everything random in agent and environment derives from it.
        policy: Stable-Baselines3's name of the network.
        policy_kwargs: of the network, over the fused optimizer.
        reward_scale: factor on rewards while learning.
        gamma: discount.
        device: of torch.
        settings: any of the algorithm's own.
    """

    def __init__(
        self,
        env: gym.Env[Any, Any] | VecEnv | None = None,
        seed: int | None = None,
        *,
        policy: Any = "MlpPolicy",
        policy_kwargs: dict[str, Any] | None = None,
        reward_scale: float = REWARD_SCALE,
        gamma: float = DISCOUNT,
        device: str = "cpu",
        **settings: Any,
    ) -> None:
        torch.set_num_threads(1)  # the networks are small, and each core has a process of its own
        torch.distributions.Distribution.set_default_validate_args(False)
        self.reward_scale = reward_scale
        fused = {"optimizer_kwargs": {"fused": True}}
        super().__init__(
            policy=policy,
            env=self._scaled(env),
            seed=_spread(seed),
            gamma=gamma,
            device=device,
            policy_kwargs=fused | (policy_kwargs or {}),
            **settings,
        )  # type: ignore[call-arg]

    def _scaled(self, env: gym.Env[Any, Any] | VecEnv | None) -> VecEnv | None:
        if env is None or isinstance(env, ScaledRewards):
            return env
        single = env
        vector = env if isinstance(env, VecEnv) else DummyVecEnv([lambda: single])  # type: ignore[list-item,return-value]
        return ScaledRewards(vector, self.reward_scale)

    def set_env(self, env: Any, force_reset: bool = True) -> None:
        """Learn in as many other environments from now on."""
        super().set_env(self._scaled(env), force_reset)  # type: ignore[misc]

    @classmethod
    def load(cls, path: Any, env: Any = None, **settings: Any) -> Any:
        """Read a saved agent; `env` is scaled as the one it was trained in."""
        torch.set_num_threads(1)
        agent = super().load(path, env=None, **settings)  # type: ignore[misc]
        if env is not None:
            agent.set_env(env)
        return agent


def _spread(seed: int | None) -> int | None:
    """Spread seeds: Stable-Baselines3 seeds crawler i with seed + i, so close seeds would share crawlers."""
    return None if seed is None else int(np.random.SeedSequence(seed).generate_state(1)[0])


class DQN(Deep, stable_baselines3.DQN):  # type: ignore[misc]
    """Q-learning with a network in place of the table [Mnih et al. 2015]."""


class PPO(Deep, stable_baselines3.PPO):  # type: ignore[misc]
    """Policy gradients with a clipped objective; its policy is stochastic [Schulman et al. 2017]."""
