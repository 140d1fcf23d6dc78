"""What decides a result, as ten digits: configuration, seed, and the sources and packages that compute it."""

import ast
import hashlib
import importlib.util
import json
import sysconfig
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from crawler_bench.config.files import agent_spec
from crawler_bench.config.schema import EvaluationConfig, RunConfig, to_mapping
from crawler_bench.physics.compiled import KERNEL_HASH, source_hash


def installed_version(package: str) -> str | None:
    """The version of a package; None if it is not installed."""
    try:
        return version(package)
    except PackageNotFoundError:
        return None


# Of the sources and packages as this process imported them, like KERNEL_HASH.
_HERE = Path(__file__).parents[1]
TRAINING_HASH = source_hash(_HERE / "training.py")
EVALUATION_SOURCES = (_HERE.parent / "gait", _HERE / "policies", _HERE / "evaluation.py")
EVALUATION_HASH = source_hash(*EVALUATION_SOURCES)
VERSIONS = {
    name: installed_version(name) for name in ("numpy", "numba", "gymnasium", "stable-baselines3", "torch")
}
_OURS = ("agents", "crawler_bench")  # what a run needs of these is hashed above
_INSTALLED = {Path(sysconfig.get_path(name)) for name in ("purelib", "platlib", "stdlib")}


def training_key(config: RunConfig, seed: int) -> str:
    """Ten digits that name a training run: configuration, seed, and the sources and packages that it runs."""
    sources = [KERNEL_HASH, TRAINING_HASH, source_hash(*agent_sources(config.agent))]
    content = to_mapping(config) | {"seed": seed, "sources": sources, "packages": VERSIONS}
    del content["evaluation"]
    return _digest(content)


def evaluation_key(config: EvaluationConfig) -> str:
    """Ten digits that name an evaluation: its configuration, and the sources and packages that measure."""
    sources = [KERNEL_HASH, EVALUATION_HASH]
    return _digest(to_mapping(config) | {"sources": sources, "packages": VERSIONS})


def _digest(content: dict[str, Any]) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:10]


def agent_sources(agent: str) -> list[Path]:
    """Where an agent's code lives: its file or package, and what lies beside that and is imported by it.

    What a module imports under a computed name, and data files, are not seen.
    """
    top = agent_spec(agent).partition(":")[0].partition(".")[0]
    own = _place(top)
    if own is None:
        return []
    found: set[Path] = set()
    unread = [own]
    while unread:
        place = unread.pop()
        if place not in found:
            found.add(place)
            if top not in _OURS and place.parent not in _INSTALLED:
                unread += _imported_neighbours(place)
    return sorted(found)


def _place(top: str) -> Path | None:
    """The folder of a package, or the file of a module; nothing is imported."""
    try:
        found = importlib.util.find_spec(top)
    except (ImportError, ValueError):
        return None
    if found is None:
        return None
    if found.submodule_search_locations:
        return Path(next(iter(found.submodule_search_locations)))
    return Path(found.origin) if found.origin and found.origin.endswith(".py") else None


def _imported_neighbours(place: Path) -> list[Path]:
    """Modules and packages in the same folder that a module, or a file of a package, imports."""
    names: set[str] = set()
    for path in place.rglob("*.py") if place.is_dir() else [place]:
        try:
            tree = ast.parse(path.read_bytes())
        except (SyntaxError, ValueError):
            continue
        for node in ast.walk(tree):
            if isinstance(node, ast.Import):
                names.update(each.name for each in node.names)
            elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                names.add(node.module)
    tops = {name.partition(".")[0] for name in names} - set(_OURS)
    candidates = [place.parent / name for top in tops for name in (top, f"{top}.py")]
    return [each for each in candidates if each.exists()]
