"""Run folders: where finished work lives, keyed by what decides it.

A folder is written beside its final place, sealed with the checksums of its files, and renamed when it is
complete, so that it exists whole or not at all, however the process ends. Who writes has claimed it, so that
many processes, on many machines, share one store. Nothing in a folder is ever overwritten; only its manifest
knows the time of day.
"""

import functools
import json
import os
import platform
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

from crawler_bench.config.files import read_mapping
from crawler_bench.config.schema import RunConfig, build, to_yaml
from crawler_bench.runs.folders import checksums, claims
from crawler_bench.runs.folders.keys import installed_version, training_key

MANIFEST = checksums.MANIFEST
CONFIG = "config.yaml"
PACKAGES = ("numpy", "scipy", "numba", "gymnasium", "stable-baselines3", "torch", "pandas", "matplotlib")


def complain(text: str) -> None:
    """Say something on standard error."""
    print(f"crawler-bench: {text}", file=sys.stderr)


class NotARunError(ValueError):
    """A folder that is not a finished run, said in one line."""


def run_folder(root: Path, config: RunConfig, seed: int) -> Path:
    """Folder of a training run: readable words first, then what makes it unique."""
    agent = config.agent.rpartition(":")[2].lower()
    words = re.sub(r"[^\w.-]", "-", f"{agent}-eps{config.environment.regularization:g}-seed{seed:02d}")
    return root / f"{words}-{training_key(config, seed)}"


def is_run(folder: Path) -> bool:
    """Whether a folder holds a finished training run."""
    return (folder / MANIFEST).is_file() and (folder / CONFIG).is_file()


def read_run(folder: Path) -> tuple[RunConfig, int]:
    """Configuration and seed of a finished run.

    Raises:
        NotARunError: if the folder is not one of ours, or not as it was written.
    """
    if not is_run(folder):
        there = "is not a finished run" if folder.is_dir() else "does not exist"
        raise NotARunError(
            f"{folder} {there}: a run folder holds {CONFIG} and {MANIFEST}; `crawler-bench train` makes one"
        )
    if reason := checksums.damage(folder):
        raise NotARunError(f"{reason}; remove the run {folder} and train it again")
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
def publish(folder: Path, *, of: str = "") -> Iterator[Path]:
    """Give a folder to write into that becomes `folder` when the block ends well, and vanishes otherwise.

    If another process has published the same folder meanwhile, its copy, which is the same, stays. A folder
    that is damaged is replaced.

    Args:
        folder: to be published; claimed by the caller.
        of: checksum of the manifest of the run that it belongs to, see `damage`.
    """
    with _draft(folder) as draft:
        yield draft
        checksums.seal(draft, folder.name)
        if not folder.is_dir() or checksums.damage(folder, folder.name, of=of):
            _exchange(draft, folder)


@contextmanager
def replace(folder: Path) -> Iterator[Path]:
    """Give a folder to write into that takes the place of `folder` when the block ends well.

    Waits for any other process that writes the same folder.
    """
    claims.sweep(folder.parent, folder.name)
    with claims.claim(folder), _draft(folder) as draft:
        yield draft
        checksums.seal(draft, folder.name)
        _exchange(draft, folder)


@contextmanager
def _draft(folder: Path) -> Iterator[Path]:
    folder.parent.mkdir(parents=True, exist_ok=True)
    draft = Path(tempfile.mkdtemp(prefix=f".partial-{folder.name}-", dir=folder.parent))
    try:
        draft.chmod(0o755)
        yield draft
    finally:
        shutil.rmtree(draft, ignore_errors=True)


def _exchange(draft: Path, folder: Path) -> None:
    """Rename a draft to what may be there already; that comes back if it fails."""
    old = None
    if folder.exists():
        old = Path(tempfile.mkdtemp(prefix=f".partial-{folder.name}-old-", dir=folder.parent))
        folder.rename(old)
    try:
        draft.rename(folder)
    except OSError:
        if old is not None and not folder.exists():
            old.rename(folder)
        raise
    finally:
        if old is not None:
            shutil.rmtree(old, ignore_errors=True)
    checksums.sync(folder.parent)


def make(
    folder: Path,
    write: Callable[[Path], None],
    *,
    of: str = "",
    wait: bool = True,
    say: Callable[[str], None] = complain,
) -> None:
    """Make a folder, unless it is there and sound: one process at a time, the others find it made.

    Args:
        folder: the folder.
        write: fills a draft of it.
        of: checksum of the manifest of the run that it belongs to, see `damage`.
        wait: for another process that makes it.
        say: told if the folder is damaged, and therefore made again.

    Raises:
        Busy: if another process is making it, and `wait` is false.
    """
    if folder.exists() and not checksums.damage(folder, folder.name, of=of):
        claims.drop_dead(folder)  # of a process that was killed when the folder was there already
        return
    with claims.claim(folder, wait):
        if folder.exists():
            if not (reason := checksums.damage(folder, folder.name, of=of)):
                return
            say(f"{reason}; it is made again")
        with publish(folder, of=of) as draft:
            write(draft)


def write_manifest(folder: Path, started: float, **facts: Any) -> None:
    """Write where, when and with what the content of a folder was made.

    Args:
        folder: the folder.
        started: `time.monotonic()` when the work began.
        facts: anything else worth knowing.
    """
    manifest = {
        "finished": datetime.now(UTC).isoformat(timespec="seconds"),
        "wall_clock_seconds": round(time.monotonic() - started, 3),
        "crawler_bench": version("crawler-bench"),
        "git": _git_state(),
        "python": platform.python_version(),
        "packages": {name: installed_version(name) for name in PACKAGES},
        "machine": {"system": platform.platform(), "cpu": _cpu(), "cores": os.cpu_count()},
        "threads": {name: os.environ.get(name) for name in ("OMP_NUM_THREADS", "NUMBA_NUM_THREADS")},
    }
    (folder / MANIFEST).write_text(json.dumps(manifest | facts, indent=1) + "\n")


def write_command(folder: Path) -> None:
    """Write the command line that made a folder."""
    words = [Path(sys.argv[0]).name, *sys.argv[1:]]
    (folder / "command.txt").write_text(shlex.join(words) + "\n")


@functools.cache
def _git_state() -> dict[str, Any] | None:
    """Commit of the checkout that the code was imported from, and if it had local changes; None elsewhere."""

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


@functools.cache
def _cpu() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        return next(line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor()
