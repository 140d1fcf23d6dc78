"""How a soft-bodied crawler learns to coordinate itself.

Importing this package registers the environment `crawler_bench/Crawler-v0` with Gymnasium.
"""

from crawler_bench.envs.registration import once_imported

__version__ = "0.1.0"

ENV_ID = "crawler_bench/Crawler-v0"


def _register() -> None:
    from gymnasium.envs.registration import register, registry

    if ENV_ID not in registry:
        register(
            id=ENV_ID,
            entry_point="crawler_bench.envs.crawler:CrawlerEnv",
            vector_entry_point="crawler_bench.envs.vector:CrawlerVectorEnv",
        )


once_imported("gymnasium", _register)
