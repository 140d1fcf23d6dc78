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
import tempfile
from pathlib import Path

import platformdirs

_PACKAGE = Path(__file__).resolve().parents[2]
KEPT_VERSIONS = 8  # of the compiled code
KERNEL_SOURCES = (_PACKAGE / "physics", _PACKAGE / "envs", _PACKAGE.parent / "agents")


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
    """Folder of the compiled code for the sources as they were imported.

    `CRAWLER_BENCH_CACHE` moves it; where the user's cache cannot be written, the temporary folder serves.
    """
    home = Path(os.environ.get("CRAWLER_BENCH_CACHE") or platformdirs.user_cache_dir("crawler-bench"))
    folder = home / KERNEL_HASH
    try:
        if not folder.is_dir():
            folder.mkdir(parents=True)
            _forget_old_versions(home)
        if os.access(folder, os.W_OK):
            return folder
    except OSError:
        pass
    folder = Path(tempfile.gettempdir()) / f"crawler-bench-{os.getuid()}" / KERNEL_HASH
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def _forget_old_versions(home: Path) -> None:
    """Keep the compiled code of the newest versions; a process that needs an older one compiles it again."""
    versions = [each for each in home.iterdir() if re.fullmatch("[0-9a-f]{16}", each.name) and each.is_dir()]
    for old in sorted(versions, key=lambda each: each.stat().st_mtime)[:-KEPT_VERSIONS]:
        shutil.rmtree(old, ignore_errors=True)
