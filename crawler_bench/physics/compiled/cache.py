"""A cache of compiled code that can never be stale.

Numba's cache looks at the file of the function it compiles and not at the files of the functions which that
one calls: an edit to the friction law would go unnoticed by a cached step. So the cache lives in a folder
named after a hash of every source that can stand in a compiled call chain.
"""

import functools
import hashlib
import os
import re
import shutil
import stat
import tempfile
from pathlib import Path

import platformdirs

_PACKAGE = Path(__file__).resolve().parents[2]
KEPT_VERSIONS = 8  # of the compiled code
_VERSION = re.compile("[0-9a-f]{16}")
_DRAWING = ("palette.py", "rendering.py")  # of envs: how a crawler looks decides no number
KERNEL_SOURCES = (
    _PACKAGE / "physics", _PACKAGE.parent / "agents",
    *(path for path in sorted((_PACKAGE / "envs").glob("*.py")) if path.name not in _DRAWING),
)  # fmt: skip


def source_hash(*places: Path) -> str:
    """Hash every Python file in the given files and folders.

    Args:
        places: files or folders; of a folder, all `.py` files below it.

    Returns:
        16 hexadecimal digits that change whenever one of the sources does.
    """
    digest = hashlib.sha256()
    for place in places:
        for path in sorted(place.rglob("*.py")) if place.is_dir() else [place]:
            digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


# Taken when this process imports the sources: an edit made meanwhile must not lend its name to their results.
KERNEL_HASH = source_hash(*KERNEL_SOURCES)


@functools.cache
def cache_folder() -> Path:
    """Folder of the compiled code for the sources as they were imported; the user's alone.

    What Numba keeps there is unpickled, which runs whatever somebody has put there. So a folder that is not
    ours, or lies where anybody may exchange it, is not used: the temporary folder serves, or a new one for
    this process. `CRAWLER_BENCH_CACHE` moves it.
    """
    home = Path(os.environ.get("CRAWLER_BENCH_CACHE") or platformdirs.user_cache_dir("crawler-bench"))
    for place in (home, Path(tempfile.gettempdir()) / f"crawler-bench-{os.getuid()}"):
        try:
            if _make_private(place / KERNEL_HASH):
                return place / KERNEL_HASH
        except OSError:
            continue
    return Path(tempfile.mkdtemp(prefix="crawler-bench-"))


def _make_private(folder: Path) -> bool:
    """Make a folder for this user alone, and say whether it is; what others could write into is made new."""
    home = folder.parent
    home.mkdir(mode=0o700, parents=True, exist_ok=True)
    mode = home.stat().st_mode
    if mode & stat.S_IWOTH and not mode & stat.S_ISVTX:
        return False
    if folder.is_dir() and _is_ours(folder) and folder.stat().st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        shutil.rmtree(folder)
    if not folder.exists():
        folder.mkdir(mode=0o700, exist_ok=True)
        _forget_old_versions(home)
    if not _is_ours(folder) or not os.access(folder, os.W_OK):
        return False
    folder.chmod(0o700)
    return True


def _is_ours(folder: Path) -> bool:
    found = folder.lstat()
    return stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid()


def _forget_old_versions(home: Path) -> None:
    """Keep the compiled code of the newest versions; a process that needs an older one compiles it again."""
    versions = [each for each in home.iterdir() if _VERSION.fullmatch(each.name) and each.is_dir()]
    for old in sorted(versions, key=lambda each: each.stat().st_mtime)[:-KEPT_VERSIONS]:
        shutil.rmtree(old, ignore_errors=True)
