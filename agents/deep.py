"""Deep agents in the form that their libraries give them.

DQN, PPO and A2C are Stable-Baselines3's, QR-DQN and recurrent PPO are sb3-contrib's. Three things are the
crawler's: gamma is that of [M20]; rewards are multiplied by REWARD_SCALE while learning, because a decision
earns about a thousandth of a rest length, far below the rewards of order one that these defaults assume (no
optimal policy changes); and torch runs in one thread. All else that a configuration does not set is the
library's default, the optimizer's included.
"""

from typing import Any

import gymnasium as gym
import numpy as np
import sb3_contrib
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
    """What all share; comes before an algorithm of Stable-Baselines3 in the bases of a class.

    Args:
        env: one environment or a vector of them.
        seed: everything random in agent and environment derives from it.
        reward_scale: factor on rewards while learning.
        gamma: discount.
        device: of torch.
        settings: any of the algorithm's own; `policy`, the name of the network, is by default the class's
            USUAL_POLICY.
    """

    USUAL_POLICY = "MlpPolicy"

    def __init__(
        self,
        env: gym.Env[Any, Any] | VecEnv | None = None,
        seed: int | None = None,
        *,
        reward_scale: float = REWARD_SCALE,
        gamma: float = DISCOUNT,
        device: str = "cpu",
        **settings: Any,
    ) -> None:
        torch.set_num_threads(1)  # the networks are small, and each core has a process of its own
        torch.distributions.Distribution.set_default_validate_args(False)
        self.reward_scale = reward_scale
        super().__init__(
            env=self._scaled(env),
            seed=_spread(seed),
            gamma=gamma,
            device=device,
            **{"policy": self.USUAL_POLICY} | settings,
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


class A2C(Deep, stable_baselines3.A2C):  # type: ignore[misc]
    """Policy gradients over five decisions at a time [Mnih et al. 2016]."""


class QRDQN(Deep, sb3_contrib.QRDQN):  # type: ignore[misc]
    """DQN that learns the distribution of returns, as quantiles [Dabney et al. 2018]."""


class RecurrentPPO(Deep, sb3_contrib.RecurrentPPO):  # type: ignore[misc]
    """PPO with an LSTM: its policy has a memory and is no table."""

    USUAL_POLICY = "MlpLstmPolicy"
