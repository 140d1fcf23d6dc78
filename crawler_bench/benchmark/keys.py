"""The frames of a benchmark: what their rows are known by, and how they become CSV files and come back."""

import io
from pathlib import Path

import pandas as pd

MODES = ("deterministic", "stochastic")
RUN = ["agent", "mode", "regularization", "seed"]  # what a run and the mode of its evaluation are known by
LEARNER = ["agent", "regularization", "seed"]  # a run learns once, however it is evaluated
DIGITS = 9  # significant ones
_TEXT = {name: str for name in ("agent", "mode", "policy", "hash", "run")}


def action_columns(tables: pd.DataFrame) -> list[str]:
    """Columns of a frame of policy tables that hold the probabilities of the actions."""
    return [str(column) for column in tables if str(column).startswith("p_")]


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
