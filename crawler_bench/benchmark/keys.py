"""The keys of a benchmark's frames: which columns identify a row."""

import pandas as pd

DETERMINISTIC, STOCHASTIC = MODES = ("deterministic", "stochastic")
RUN = ["agent", "mode", "regularization", "seed"]  # of one run, evaluated in one mode
LEARNER = ["agent", "regularization", "seed"]  # of one run: it learns once, however it is evaluated


def action_columns(tables: pd.DataFrame) -> list[str]:
    """Columns of a frame of policy tables that hold the probabilities of the actions."""
    return [str(column) for column in tables if str(column).startswith("p_")]
