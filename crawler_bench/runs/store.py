"""Run folders: where finished work lives, keyed by what decides it.

A folder is written beside its final place and renamed when it is complete, so that it exists whole or not at
all, however the process ends. Nothing in it is ever overwritten; only its manifest knows the time of day.
"""

import hashlib
import importlib.util
import json
import os
import platform
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from crawler_bench.config.files import agent_spec, read_mapping
from crawler_bench.config.schema import EvaluationConfig, RunConfig, build, to_mapping, to_yaml
from crawler_bench.physics.compiled import KERNEL_HASH, source_hash

MANIFEST = "manifest.json"
CONFIG = "config.yaml"
# Of the sources as this process imported them, like KERNEL_HASH.
_HERE = Path(__file__).parent
TRAINING_HASH = source_hash(_HERE / "training.py")
EVALUATION_SOURCES = (
    _HERE.parent / "gait", _HERE / "acting.py", _HERE / "policy_table.py", _HERE / "evaluation.py",
)  # fmt: skip
EVALUATION_HASH = source_hash(*EVALUATION_SOURCES)
PACKAGES = ("numpy", "scipy", "numba", "gymnasium", "stable-baselines3", "torch", "pandas", "matplotlib")


class NotARunError(ValueError):
    """A folder that is not a finished run, said in one line."""


def training_key(config: RunConfig, seed: int) -> str:
    """Ten digits that name a training run: its configuration, its seed and the sources that it runs."""
    sources = [KERNEL_HASH, TRAINING_HASH, source_hash(*_agent_sources(config))]
    content = to_mapping(config) | {"seed": seed, "sources": sources}
    del content["evaluation"]
    return _digest(content)


def evaluation_key(config: EvaluationConfig) -> str:
    """Ten digits that name an evaluation: its configuration and the sources that measure."""
    return _digest(to_mapping(config) | {"sources": [KERNEL_HASH, EVALUATION_HASH]})


def _digest(content: dict[str, Any]) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:10]


def _agent_sources(config: RunConfig) -> list[Path]:
    """Where an agent's code lives: the folder of its package, or its one file."""
    module = agent_spec(config.agent).partition(":")[0]
    try:
        found = importlib.util.find_spec(module)
    except (ImportError, ValueError):
        found = None
    if found is None or found.origin is None:
        return []
    return [Path(found.origin).parent if "." in module else Path(found.origin)]


def run_folder(root: Path, config: RunConfig, seed: int) -> Path:
    """Folder of a training run: readable words first, then what makes it unique."""
    agent = config.agent.rpartition(":")[2].lower()
    words = f"{agent}-eps{config.environment.regularization:g}-seed{seed:02d}"
    return root / f"{words}-{training_key(config, seed)}"


def is_run(folder: Path) -> bool:
    """Whether a folder holds a finished training run."""
    return (folder / MANIFEST).is_file() and (folder / CONFIG).is_file()


def read_run(folder: Path) -> tuple[RunConfig, int]:
    """Configuration and seed of a finished run.

    Raises:
        NotARunError: if the folder is not one of ours.
    """
    if not is_run(folder):
        there = "is not a finished run" if folder.is_dir() else "does not exist"
        raise NotARunError(
            f"{folder} {there}: a run folder holds {CONFIG} and {MANIFEST}; `crawler-bench train` makes one"
        )
    try:
        content = read_mapping(folder / CONFIG)
        return build(RunConfig, content["run"], "run"), int(content["seed"])
    except (KeyError, TypeError, ValueError) as error:
        raise NotARunError(
            f"{folder / CONFIG} does not describe a run: {' '.join(str(error).split())}"
        ) from None


def write_config(folder: Path, config: RunConfig, seed: int) -> None:
    """Write the resolved configuration."""
    indented = "".join(f"  {line}\n" for line in to_yaml(config).splitlines())
    (folder / CONFIG).write_text(f"seed: {seed}\nrun:\n{indented}")


@contextmanager
def publish(folder: Path) -> Iterator[Path]:
    """Give a folder to write into that becomes `folder` when the block ends well, and vanishes otherwise.

    If another process has published the same folder meanwhile, its copy, which is the same, stays. A folder
    without a manifest, which somebody has broken, is replaced.
    """
    folder.parent.mkdir(parents=True, exist_ok=True)
    draft = Path(tempfile.mkdtemp(prefix=f".partial-{folder.name}-", dir=folder.parent))
    try:
        draft.chmod(0o755)
        yield draft
        if folder.is_dir() and not (folder / MANIFEST).is_file():
            folder.rename(tempfile.mkdtemp(prefix=f".partial-{folder.name}-broken-", dir=folder.parent))
        try:
            draft.rename(folder)
        except OSError:
            if not (folder / MANIFEST).is_file():
                raise
    finally:
        shutil.rmtree(draft, ignore_errors=True)


@contextmanager
def replace(folder: Path) -> Iterator[Path]:
    """Give a folder to write into that takes the place of `folder` when the block ends well."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    draft, old = (
        Path(tempfile.mkdtemp(prefix=f".partial-{folder.name}-", dir=folder.parent)) for _ in range(2)
    )
    try:
        draft.chmod(0o755)
        yield draft
        if folder.exists():
            folder.rename(old)
        try:
            draft.rename(folder)
        except OSError:
            if not folder.exists():
                old.rename(folder)
            raise
    finally:
        for left in (draft, old):
            shutil.rmtree(left, ignore_errors=True)


def sweep_drafts(root: Path, older_than: float = 3600.0) -> None:
    """Remove what killed processes left behind."""
    for draft in root.glob("**/.partial-*"):
        with suppress(FileNotFoundError):
            if time.time() - draft.stat().st_mtime > older_than:
                shutil.rmtree(draft, ignore_errors=True)


def write_manifest(folder: Path, started: float, **facts: Any) -> None:
    """Write where, when and with what the content of a folder was made.

    Args:
        folder: the folder.
        started: `time.time()` when the work began.
        facts: anything else worth knowing.
    """
    manifest = {
        "finished": datetime.now(UTC).isoformat(timespec="seconds"),
        "wall_clock_seconds": round(time.time() - started, 3),
        "crawler_bench": version("crawler-bench"),
        "git": _git_state(),
        "python": platform.python_version(),
        "packages": {name: _version(name) for name in PACKAGES},
        "machine": {"system": platform.platform(), "cpu": _cpu(), "cores": os.cpu_count()},
        "threads": {name: os.environ.get(name) for name in ("OMP_NUM_THREADS", "NUMBA_NUM_THREADS")},
    }
    (folder / MANIFEST).write_text(json.dumps(manifest | facts, indent=1) + "\n")


def write_command(folder: Path) -> None:
    """Write the command line that made a folder."""
    words = [Path(sys.argv[0]).name, *sys.argv[1:]]
    (folder / "command.txt").write_text(shlex.join(words) + "\n")


def _git_state() -> dict[str, Any] | None:
    """Commit of the checkout that the code runs from, and whether it has local changes; None elsewhere."""

    def git(*words: str) -> str:
        place = Path(__file__).resolve().parents[2]
        # Without optional locks: a killed run must not leave the checkout locked.
        command = ["git", "--no-optional-locks", "-C", str(place), *words]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        return done.stdout.strip()

    try:
        return {
            "commit": git("rev-parse", "HEAD"),
            "dirty": bool(git("status", "--porcelain", "--", ".", ":!results")),
        }
    except (OSError, subprocess.CalledProcessError):
        return None


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def _cpu() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        return next(line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor()
