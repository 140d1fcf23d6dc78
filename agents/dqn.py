"""DQN of Stable-Baselines3, set up for the crawler."""

import stable_baselines3

from agents.deep import Deep


class DQN(Deep, stable_baselines3.DQN):  # type: ignore[misc]
    """Q-learning with a network in place of the table [Mnih et al. 2015]."""
