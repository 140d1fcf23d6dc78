"""PPO of Stable-Baselines3, set up for the crawler."""

import stable_baselines3

from agents.deep import Deep


class PPO(Deep, stable_baselines3.PPO):  # type: ignore[misc]
    """Policy gradients with a clipped objective; its policy is stochastic [Schulman et al. 2017]."""
