"""Errors that a user can mend, each said in one line."""

import difflib
import errno
from collections.abc import Sequence


class ConfigError(ValueError):
    """Something asked for that cannot be had: wrong usage, said in one line."""


def explain(error: BaseException) -> str:
    """One line that says what is wrong and, where it is known, what to do."""
    if not isinstance(error, OSError):
        return " ".join(str(error).split())
    if error.errno == errno.ENOSPC:
        return "the disk is full; free some room and repeat the command: it goes on from the finished runs"
    return f"{error.filename}: {error.strerror}" if error.filename else str(error)


def nearest(key: str, names: Sequence[str]) -> str:
    """Words that name the key that was probably meant, or all there are."""
    close = difflib.get_close_matches(key, names, n=1, cutoff=0.5)
    return f"; did you mean {close[0]!r}?" if close else f"; known are {', '.join(names)}"
