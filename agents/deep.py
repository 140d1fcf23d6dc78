"""What DQN and PPO have in common here: one torch thread, one scale of rewards, one discount.

A decision earns about a thousandth of a rest length, far from the rewards of order one that the defaults of
deep agents are made for; so both see rewards multiplied by REWARD_SCALE, which changes no optimal policy.
Everything else that is not said in a configuration is Stable-Baselines3's default; Adam runs as one fused
kernel and distributions do not check their own arguments, which changes the time and not the learning.
"""

from typing import Any

import gymnasium as gym
import numpy as np
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
    """Goes before an algorithm of Stable-Baselines3 in the bases of a class.

    Args:
        env: one environment or a vector of them.
        seed: everything random in agent and environment derives from it.
        reward_scale: what rewards are multiplied by while learning.
        gamma: discount.
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
        torch.set_num_threads(1)  # the networks are small, and there is a process a core
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
        """Learn in other environments, of the same number, from now on."""
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
    """Move seeds apart: Stable-Baselines3 seeds crawler i with seed + i, and neighbours would share them."""
    return None if seed is None else int(np.random.SeedSequence(seed).generate_state(1)[0])
