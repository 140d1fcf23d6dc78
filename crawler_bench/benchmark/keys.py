"""The frames of a benchmark: what their rows are known by."""

import pandas as pd

MODES = ("deterministic", "stochastic")
RUN = ["agent", "mode", "regularization", "seed"]  # what a run and the mode of its evaluation are known by
LEARNER = ["agent", "regularization", "seed"]  # a run learns once, however it is evaluated


def action_columns(tables: pd.DataFrame) -> list[str]:
    """Columns of a frame of policy tables that hold the probabilities of the actions."""
    return [str(column) for column in tables if str(column).startswith("p_")]
