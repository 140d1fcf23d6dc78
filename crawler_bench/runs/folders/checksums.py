"""Every file answers for itself: a manifest holds the checksum of each file in its folder, and its own."""

import hashlib
import json
import os
from pathlib import Path, PurePosixPath
from typing import Any

from crawler_bench.runs.folders.claims import is_hidden

MANIFEST = "manifest.json"
FOLDER, FILES, CHECKSUM = "folder", "files", "checksum"  # keys that `seal` adds to a manifest


def seal(folder: Path, name: str) -> None:
    """Write the checksums of a folder's files into its manifest, and see that all of it is on the disk.

    Args:
        folder: complete; its manifest may be missing.
        name: that it is going to have.
    """
    path = folder / MANIFEST
    manifest = json.loads(path.read_text()) if path.is_file() else {}
    manifest |= {FOLDER: name, FILES: {each: _sha256(folder / each) for each in content_of(folder)}}
    manifest[CHECKSUM] = _of_manifest(manifest)
    path.write_text(json.dumps(manifest, indent=1) + "\n")
    for place in [*folder.rglob("*"), folder]:
        sync(place)


def content_of(folder: Path) -> list[str]:
    """The files that a folder answers for: not its manifest, drafts, or folders with their own manifest."""
    found = []
    for here, folders, files in os.walk(folder):
        inside = Path(here).relative_to(folder)
        folders[:] = [
            each for each in folders if not is_hidden(each) and not (Path(here) / each / MANIFEST).is_file()
        ]
        found += [(inside / each).as_posix() for each in files if not is_hidden(each)]
    return sorted(set(found) - {MANIFEST})


def damage(folder: Path, name: str = "", *, of: str = "") -> str:
    """Say in one line what is wrong with a folder that was finished once; empty if nothing is.

    Args:
        folder: the folder.
        name: that it was given; empty if it may have any.
        of: checksum of the manifest of the run that it belongs to; empty if that does not matter.
    """
    try:
        manifest = json.loads((folder / MANIFEST).read_bytes())
        files, checksum = manifest.get(FILES), manifest.get(CHECKSUM)
    except (FileNotFoundError, NotADirectoryError, IsADirectoryError):
        return f"{folder / MANIFEST} is missing"
    except (ValueError, AttributeError, RecursionError):
        return f"{folder / MANIFEST} is damaged"
    if files is None and checksum is None:
        return f"{folder / MANIFEST} holds no checksums"
    if not isinstance(files, dict) or checksum != _of_manifest(manifest):
        return f"{folder / MANIFEST} was changed after it was written"
    if name and manifest[FOLDER] != name:
        return f"{folder} holds what was made as {manifest[FOLDER]}"
    if of and manifest.get("run") != of:
        return f"{folder} was measured on another run"
    for each, expected in files.items():
        path = folder / each
        if not _stays_inside(each):
            return f"{folder / MANIFEST} names {each!r}, which is outside of its folder"
        if not path.is_file():
            return f"{path} is missing"
        if _sha256(path) != expected:
            return f"{path} was changed after it was written"
    return ""


def added_to(folder: Path) -> list[str]:
    """Files in a sound folder that its manifest does not know."""
    known = json.loads((folder / MANIFEST).read_bytes())[FILES]
    return [each for each in content_of(folder) if each not in known]


def identity(folder: Path) -> str:
    """The checksum of a sealed folder's manifest, and so of all of its files."""
    return str(json.loads((folder / MANIFEST).read_bytes())[CHECKSUM])


def sync(place: Path) -> None:
    """See that a file, or the list of a folder's files, is on the disk."""
    number = os.open(place, os.O_RDONLY)
    try:
        os.fsync(number)
    finally:
        os.close(number)


def _of_manifest(manifest: dict[str, Any]) -> str:
    content = {key: value for key, value in manifest.items() if key != CHECKSUM}
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def _sha256(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _stays_inside(name: str) -> bool:
    path = PurePosixPath(name)
    return bool(name) and not path.is_absolute() and ".." not in path.parts
