"""Frames as CSV files: the same numbers give the same bytes, and come back the same."""

import io
from pathlib import Path

import pandas as pd

DIGITS = 9  # significant ones
_TEXT = {name: str for name in ("agent", "mode", "policy", "hash", "run")}


def write_csv(frame: pd.DataFrame, path: Path | io.StringIO) -> None:
    """Write a frame with nine significant digits: the same numbers give the same bytes."""
    frame.to_csv(path, index=False, float_format=f"%.{DIGITS}g")


def read_csv(source: Path | io.StringIO) -> pd.DataFrame:
    """Read what `write_csv` wrote; names, policies and hashes are text, even if they look like numbers."""
    return pd.read_csv(source, dtype=_TEXT, keep_default_na=False, na_values=[""])


def rounded(frame: pd.DataFrame) -> pd.DataFrame:
    """A frame as it comes back from its CSV."""
    if not len(frame.columns):
        return frame
    text = io.StringIO()
    write_csv(frame, text)
    text.seek(0)
    return read_csv(text)
