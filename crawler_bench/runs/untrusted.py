"""Files that others made: what they may name, where they may lead, and how much they may unpack to.

Nothing here imports or unpickles. A class that a file names is imported only if it is ours, was registered by
an installed package, or was named by the user; `--trust` names all that a file names.
"""

import json
import os
import zipfile
from collections.abc import Collection, Iterable
from pathlib import Path
from typing import Any

from crawler_bench.config.errors import ConfigError
from crawler_bench.config.files import registered_agents
from crawler_bench.config.schema import Experiment

MOST_UNPACKED = 2**28  # bytes that an archive may hold


def require_trust(agents: Iterable[str], source: Path, trusted: Collection[str] = ()) -> None:
    """Refuse to import a class because a file says so.

    Args:
        agents: names that a file holds.
        source: the file.
        trusted: names that the user gave, or allowed.

    Raises:
        ConfigError: naming the class, and what would allow it.
    """
    known = registered_agents()
    for agent in agents:
        if agent not in known and agent not in known.values() and agent not in trusted:
            raise ConfigError(
                f"{source} names the agent {agent!r}, which is neither ours nor installed: "
                "with --trust its code is imported and run"
            )


def agents_of(experiment: Experiment) -> set[str]:
    """Every agent that an experiment names."""
    varied = [*experiment.grid.get("agent", ())]
    if (space := getattr(experiment, "space", {}).get("agent")) is not None:
        varied += [space.start, *space.values]
    return {experiment.run.agent, *map(str, varied)}


def inside(folder: Path, *names: str) -> Path:
    """A file in a folder, by names that a file holds.

    Raises:
        ConfigError: if they lead out of the folder.
    """
    path = folder.joinpath(*names)
    if not Path(os.path.normpath(path)).is_relative_to(os.path.normpath(folder)):
        raise ConfigError(f"{folder} names {'/'.join(names)!r}, which is outside of it")
    return path


def require_bounded(path: Path, most: int = MOST_UNPACKED) -> None:
    """Refuse an archive that unpacks to more than any of ours.

    Args:
        path: the archive.
        most: bytes that it may hold.

    Raises:
        ValueError: saying how large it is.
        zipfile.BadZipFile: if it is no archive.
    """
    with zipfile.ZipFile(path) as archive:
        size = sum(each.file_size for each in archive.infolist())
    if size > most:
        raise ValueError(f"{path.name} unpacks to {size:,} bytes; at most {most:,} are read")


def load_weights(agent: Any, path: Path) -> None:
    """Give an agent of Stable-Baselines3 the weights of a saved one; nothing is unpickled.

    Args:
        agent: new, with the same networks.
        path: the archive; its weights and its exploration rate are read.

    Raises:
        ValueError: if it holds other networks, or none.
        zipfile.BadZipFile: if it is no archive.
    """
    require_bounded(path)
    with zipfile.ZipFile(path) as archive:
        if "policy.pth" not in archive.namelist():
            raise ValueError("it holds no policy.pth")
        plain = json.loads(archive.read("data")) if "data" in archive.namelist() else {}
    agent.set_parameters(str(path), exact_match=True, device="cpu")  # torch.load with weights_only
    rate = plain.get("exploration_rate")
    if rate is not None:
        if isinstance(rate, bool) or not isinstance(rate, int | float) or not 0 <= rate <= 1:
            raise ValueError(f"exploration_rate = {rate!r} is no share")
        agent.exploration_rate = float(rate)
