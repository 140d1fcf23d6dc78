"""What finished runs measured, as tidy frames: one row per run, per start and per cycle."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from crawler_bench.config.schema import RunConfig
from crawler_bench.gait import metrics
from crawler_bench.runs.evaluation import Evaluation, read_evaluation
from crawler_bench.runs.folders import checksums
from crawler_bench.runs.store import NotARunError
from crawler_bench.runs.sweep import Outcome

CYCLE_DIGITS = 1  # of the duration of a cycle, tau_theta, within which two runs count as equal


@dataclass(frozen=True)
class Measured:
    """A trained policy with what is known of it.

    Attributes:
        key: what its rows are labelled by.
        name: of its folder or file.
        evaluation: its measures.
        learning: its learning curve; empty where it is not known.
    """

    key: dict[str, object]
    name: str
    evaluation: Evaluation
    learning: pd.DataFrame


def read_outcomes(outcomes: Sequence[Outcome]) -> tuple[pd.DataFrame, pd.DataFrame, pd.DataFrame]:
    """Collect what finished cells measured, keyed by experiment, agent, regularization and seed.

    Returns:
        runs, one row per run; evaluations, one per run, noise and start; cycles, one per cycle.

    Raises:
        NotARunError: if a file is not as it was written.
    """
    measured = []
    for outcome in outcomes:
        if outcome.folder is None or outcome.evaluation is None:
            continue
        key = label(outcome.cell.experiment, outcome.cell.config, outcome.cell.seed)
        if reason := checksums.damage(outcome.folder):
            raise NotARunError(f"{reason}; repeat the command: it is made again")
        learning = pd.read_csv(outcome.folder / "learning.csv")
        measured.append(Measured(key, outcome.folder.name, read_evaluation(outcome.evaluation), learning))
    return tabulate(measured)


def label(experiment: str, config: RunConfig, seed: int) -> dict[str, object]:
    """What the rows of a run are keyed by."""
    return {
        "experiment": experiment,
        "agent": config.agent.rpartition(":")[2].lower(),
        "regularization": config.environment.regularization,
        "seed": seed,
    }


def tabulate(measured: Sequence[Measured]) -> tuple[pd.DataFrame, pd.DataFrame, pd.DataFrame]:
    """The frames that `read_outcomes` returns, of policies wherever they come from."""
    if not measured:
        return pd.DataFrame(), pd.DataFrame(), pd.DataFrame()
    runs = [each.key | summarize(each.evaluation, each.learning) | {"run": each.name} for each in measured]
    keys = [each.key for each in measured]
    starts = _keyed(keys, [each.evaluation.starts for each in measured])
    return pd.DataFrame(runs), starts, _keyed(keys, [each.evaluation.cycles for each in measured])


def _keyed(keys: Sequence[dict[str, object]], frames: Sequence[pd.DataFrame]) -> pd.DataFrame:
    rows = [pd.DataFrame(key, index=frame.index).join(frame) for key, frame in zip(keys, frames, strict=True)]
    return pd.concat(rows, ignore_index=True)


def summarize(evaluation: Evaluation, learning: pd.DataFrame) -> dict[str, object]:
    """One run in one row: gait metrics are means over the starts that move, speeds as their names say."""
    starts = evaluation.starts
    quiet = starts[starts["noise"] == starts["noise"].iloc[0]]
    moving = quiet[~quiet["stalled"].astype(bool)]
    policy = evaluation.table.argmax(axis=1)
    settings = ["noise", "start", "speed", "reward", "stalled", "cycle_duration", "cycles"]
    durations = evaluation.cycles["duration"]
    last = learning.iloc[-1] if len(learning) else pd.Series(np.nan, ["decisions", "gradient_updates"])
    row: dict[str, object] = {
        "policy": metrics.policy_text(evaluation.table),
        "observations": len(policy),
        "diagonal_distance": metrics.diagonal_distance(policy) if len(policy) else np.nan,
        "off_diagonal": metrics.off_diagonal(evaluation.table) if len(policy) else np.nan,
        "speed": quiet["speed"].mean(),
        "speed_median": quiet["speed"].median(),
        "speed_moving": moving["speed"].mean(),
        "reward": quiet["reward"].mean(),
        "stall_share": quiet["stalled"].astype(float).mean(),
        "decisions": float(last["decisions"]),
        "gradient_updates": float(last["gradient_updates"]),
        "speed_learning": _learning_speed(learning, 0.0),
        "speed_learning_end": _learning_speed(learning, 0.9),
        "cycles": len(durations),
        "cycle_duration": durations.mean(),
        "waves_per_tau": 1 / durations.mean() if len(durations) else np.nan,
    }
    averages: dict[str, object] = moving.drop(columns=settings).mean().to_dict()
    return row | averages


def _learning_speed(learning: pd.DataFrame, since: float) -> float:
    """Speed while learning, from a share of the run to its end; NaN for an agent that does not learn."""
    if len(learning) < 2:
        return np.nan
    start = learning.iloc[int(since * len(learning))] if since else pd.Series({"time": 0.0, "distance": 0.0})
    end = learning.iloc[-1]
    elapsed = end["time"] - start["time"]
    return float((end["distance"] - start["distance"]) / elapsed) if elapsed > 0 else np.nan


def typical_run(runs: pd.DataFrame, outcomes: Sequence[Outcome]) -> Outcome:
    """The run to show of several: of those with the commonest policy, the one nearest to the middle of all.

    Nearest first by the duration of its cycle, where there are cycles, then by reward: where every run has a
    policy of its own, the one shown has the cycle that most have.

    Args:
        runs: one row per run and mode, of these outcomes and others.
        outcomes: of one experiment, regularization and mode.

    Raises:
        RuntimeError: if none of them succeeded.
    """
    finished = {each.folder.name: each for each in outcomes if each.folder is not None}
    rows = runs[runs["run"].isin(list(finished))].drop_duplicates("run") if finished else runs
    if not finished:
        raise RuntimeError("no run succeeded: there is nothing to show")
    return finished[typical_row(rows)["run"]]


def typical_row(runs: pd.DataFrame) -> "pd.Series[Any]":
    """The row of the run to show: see `typical_run`."""
    shared = runs["policy"].map(runs["policy"].value_counts())
    commonest = runs[shared == shared.max()].sort_values(["reward", "seed"])
    middle = commonest.iloc[(len(commonest) - 1) // 2]["reward"]
    cycle = commonest.get("cycle_duration", pd.Series(np.nan, commonest.index))
    away = pd.DataFrame({
        "cycle": (cycle - cycle.median()).abs().round(CYCLE_DIGITS),
        "reward": (commonest["reward"] - middle).abs(),
    })  # fmt: skip
    nearest = away.sort_values(["cycle", "reward"], kind="stable", na_position="last").index[0]
    row: pd.Series[Any] = commonest.loc[nearest]
    return row
