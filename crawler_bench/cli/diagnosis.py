"""What can be wrong with an installation, and how to fix it."""

import shutil
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from importlib.metadata import version
from importlib.util import find_spec

LEAST_PYTHON = (3, 11)
LEAST_ROOM = 2**30  # bytes
PACKAGES = (
    "numpy", "scipy", "pandas", "numba", "gymnasium", "matplotlib", "seaborn", "pygame", "imageio", "torch",
    "stable_baselines3",
)  # fmt: skip


@dataclass(frozen=True)
class Check:
    """One thing that was looked at: what was found, whether that will do, and how to fix it if not."""

    what: str
    found: str
    ok: bool = True
    fix: str = ""


def checks(imports: bool = False) -> Iterator[Check]:
    """Look at everything, one check after the other.

    Args:
        imports: import every package instead of looking whether it is there.
    """
    python = sys.version.split()[0]
    yield Check("python", python, sys.version_info >= LEAST_PYTHON, "install Python 3.11 or newer")
    for name in PACKAGES:
        find = _imported if imports else _installed
        yield _look(name, partial(find, name), f"pip install -c constraints.txt {name.replace('_', '-')}")
    yield _look("agents", _agents, "see the message")
    yield _look("environment", _step, "reinstall with: pip install -c constraints.txt -e .")
    yield _look("compiled code", _cache, "point CRAWLER_BENCH_CACHE at a folder that can be written")
    yield _look("configurations", _configs, "reinstall crawler-bench: its configurations are missing")
    yield _look("video encoder", _encoder, "pip install --force-reinstall imageio-ffmpeg")
    free = shutil.disk_usage(".").free
    enough = "free some room: results need up to 1 GiB"
    yield Check("free disk", f"{free / 2**30:.1f} GiB", free > LEAST_ROOM, enough)


def _look(what: str, find: Callable[[], str], fix: str) -> Check:
    try:
        return Check(what, find())
    except Exception as error:
        return Check(what, " ".join(f"{type(error).__name__}: {error}".split()), False, fix)


def _installed(name: str) -> str:
    if find_spec(name) is None:
        raise ModuleNotFoundError(f"No module named {name!r}")
    return version(name.replace("_", "-"))


def _imported(name: str) -> str:
    return str(getattr(import_module(name), "__version__", "") or _installed(name))


def _agents() -> str:
    from crawler_bench.config.files import registered_agents
    from crawler_bench.runs.agent import require_our_agents

    found = registered_agents()
    for spec in found.values():
        module = spec.partition(":")[0]
        require_our_agents(module)
        if find_spec(module) is None:
            raise ModuleNotFoundError(f"No module named {module!r}")
    return ", ".join(found)


def _step() -> str:
    import gymnasium as gym

    import crawler_bench
    from crawler_bench.physics.compiled import cache_folder

    if not any(cache_folder().rglob("*.nbi")):
        return "not compiled yet; the first run does it in half a minute, `crawler-bench warmup` beforehand"
    env = gym.make(crawler_bench.ENV_ID)
    env.reset(seed=0)
    env.step(0)
    return f"{crawler_bench.ENV_ID} steps"


def _cache() -> str:
    from crawler_bench.physics.compiled import cache_folder

    return str(cache_folder())


def _configs() -> str:
    from crawler_bench.config.files import config_folder, load_experiment, load_tuning

    paths = sorted(config_folder().glob("*/*.yaml"))
    if not paths:
        raise FileNotFoundError(f"no experiment in {config_folder()}")
    for path in paths:
        (load_tuning if path.parent.name == "tuning" else load_experiment)(path)
    return f"{len(paths)} experiments in {config_folder()}"


def _encoder() -> str:
    import imageio_ffmpeg

    return str(imageio_ffmpeg.get_ffmpeg_exe())
