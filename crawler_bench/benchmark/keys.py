"""How the frames of a benchmark are addressed: the columns that identify a row, and rows by their values."""

import pandas as pd

DETERMINISTIC, STOCHASTIC = MODES = ("deterministic", "stochastic")
GROUP = ["agent", "mode", "regularization"]  # what is summarized over seeds
RUN = [*GROUP, "seed"]  # of one run, evaluated in one mode
LEARNER = ["agent", "regularization", "seed"]  # of one run: it learns once, however it is evaluated
Group = tuple[str, str, float]  # values of GROUP


def select(frame: pd.DataFrame, **values: object) -> pd.DataFrame:
    """The rows that have these values in the columns of these names."""
    for column, value in values.items():
        frame = frame[frame[column] == value]
    return frame


def action_columns(tables: pd.DataFrame) -> list[str]:
    """Columns of a frame of policy tables that hold the probabilities of the actions."""
    return [str(column) for column in tables if str(column).startswith("p_")]
