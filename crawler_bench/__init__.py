"""How a soft-bodied crawler learns to coordinate itself.

Importing this package registers the environment `crawler_bench/Crawler-v0` with Gymnasium.
"""

import gymnasium as gym

__version__ = "0.1.0"

ENV_ID = "crawler_bench/Crawler-v0"

if ENV_ID not in gym.registry:
    gym.register(
        id=ENV_ID,
        entry_point="crawler_bench.envs.crawler:CrawlerEnv",
        vector_entry_point="crawler_bench.envs.vector:CrawlerVectorEnv",
    )
