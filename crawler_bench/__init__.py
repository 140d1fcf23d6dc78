"""How a soft-bodied crawler learns to coordinate itself.

Importing this package registers the crawler with Gymnasium: `crawler_bench/Crawler-v0`, which observes the
index of its most contracted segment, and the same body seen through other keyholes (envs/keyholes.py):
`CrawlerOneHot-v0`, `CrawlerStrain-v0` and `CrawlerState-v0`.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from crawler_bench.envs.registration import once_imported

if TYPE_CHECKING:
    from pathlib import Path

__version__ = "0.1.0"

ENV_ID = "crawler_bench/Crawler-v0"
KEYHOLE_IDS = {
    "index": ENV_ID,
    "one-hot": "crawler_bench/CrawlerOneHot-v0",
    "strain": "crawler_bench/CrawlerStrain-v0",
    "state": "crawler_bench/CrawlerState-v0",
}


def _register() -> None:
    from gymnasium.envs.registration import register, registry

    if ENV_ID not in registry:
        register(
            id=ENV_ID,
            entry_point="crawler_bench.envs.crawler:CrawlerEnv",
            vector_entry_point="crawler_bench.envs.vector:CrawlerVectorEnv",
        )
    for keyhole, id_ in KEYHOLE_IDS.items():
        if id_ not in registry:
            register(
                id=id_,
                entry_point="crawler_bench.envs.keyhole_envs:KeyholeEnv",
                vector_entry_point="crawler_bench.envs.keyhole_envs:KeyholeVectorEnv",
                kwargs={"keyhole": keyhole},
            )


once_imported("gymnasium", _register)


def record(env: Any, folder: "str | Path", agent: str = "", seed: int | None = None) -> Any:
    """Make a crawler record what any learner does with it; see `crawler_bench.runs.recorder.record`."""
    # By its name: the environments import this package, and know no runs.
    recorder = import_module("crawler_bench.runs.recorder")
    return recorder.record(env, folder, agent, seed)
