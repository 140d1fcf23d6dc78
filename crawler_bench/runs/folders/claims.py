"""Who works on a folder: a claim that ends with the process that holds it, however that process ends.

A claim is an exclusive flock on `.claim-NAME` beside the folder; the kernel drops it with the process.
Linux passes flock to the server of an NFS mount (version 4, or 3 with lockd; mounted without `nolock` and
`local_lock`), which drops it when a machine is gone for longer than its lease, 90 s by default. Where a file
system has no flock, `filelock` falls back to a file that names its owner. Claims save work; that a result is
whole does not depend on them but on the atomic rename in `store.py`.
"""

import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from filelock import FileLock, Timeout

POLL = 0.2  # seconds between two looks at a claim that another process holds
_CLAIM = ".claim-"
_DRAFT = re.compile(r"\.partial-(?P<name>.+?)(?P<old>-old)?-[a-z0-9_]{8}")


class Busy(RuntimeError):
    """Another process works on a folder."""


@contextmanager
def claim(folder: Path, wait: bool = True) -> Iterator[None]:
    """Hold the claim to a folder, which need not exist.

    Args:
        folder: the folder.
        wait: for another process that holds the claim, as long as it takes.

    Raises:
        Busy: if another process holds it, and `wait` is false.
    """
    folder.parent.mkdir(parents=True, exist_ok=True)
    lock = FileLock(_lock_file(folder))
    try:
        lock.acquire(timeout=-1 if wait else 0, poll_interval=POLL)
    except Timeout:
        raise Busy(f"another process works on {folder}") from None
    try:
        yield
    finally:
        with suppress(OSError):
            _lock_file(folder).unlink()  # while it is held: who waits for it notices, and opens a new one
        lock.release()


def drop_dead(folder: Path) -> None:
    """Remove the claim to a folder if its owner is dead."""
    if _lock_file(folder).exists():
        with suppress(Busy, OSError), claim(folder, wait=False):
            pass


def _lock_file(folder: Path) -> Path:
    return folder.parent / f"{_CLAIM}{folder.name}"


def is_hidden(name: str) -> bool:
    """Whether a file or folder is a draft or a lock, not a part of any result."""
    return name.startswith(".")


def sweep(root: Path, name: str = "") -> None:
    """Remove drafts and claims whose owners are dead; a folder cut off in mid-exchange comes back.

    Args:
        root: folder of the folders that were written.
        name: of the one to look after; empty for all of them.
    """
    for left in [*root.glob(".partial-*"), *root.glob(f"{_CLAIM}*")]:
        draft = _DRAFT.fullmatch(left.name)
        folder = root / (draft["name"] if draft else left.name.removeprefix(_CLAIM))
        if name not in ("", folder.name):
            continue
        with suppress(Busy, OSError), claim(folder, wait=False):
            if draft and draft["old"] and not folder.exists():
                left.rename(folder)
            elif left.is_dir():
                shutil.rmtree(left, ignore_errors=True)
