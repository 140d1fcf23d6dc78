"""What a keyhole is worth, what memory is worth, and how runs are spread, from a benchmark's frames."""

import numpy as np
import pandas as pd

from crawler_bench.benchmark.families import RECURRENT, traits_of
from crawler_bench.benchmark.keys import GROUP
from crawler_bench.benchmark.summary import metric
from crawler_bench.output.cells import format_cell
from crawler_bench.statistics.profiles import performance_profile

SHOWN = ("reward", "speed", "score", "regret_state", "noise_area")
ORDER = ("index", "one-hot", "strain", "state")
THRESHOLDS = 61  # of a profile, from the worst score to the best


def keyhole_worth(summary: pd.DataFrame, traits: pd.DataFrame) -> pd.DataFrame:
    """The rows of a summary that say what seeing more, or remembering, is worth.

    Args:
        summary: of `summarize_benchmark`.
        traits: of `entries.traits`.

    Returns:
        The rows of SHOWN metrics, with the columns algorithm, keyhole and memory (whether the agent has one),
        of untuned learners whose algorithm is there at several keyholes, or with and without a memory; by
        algorithm, regularization and mode, keyholes from the narrowest on.
    """
    of = traits_of(traits)
    learners = {name: each for name, each in of.items() if not (each.tuned or each.is_reference)}
    plain = {name: each.algorithm.removeprefix(RECURRENT) for name, each in learners.items()}
    ways = pd.Series(plain).value_counts()
    kept = [name for name in learners if ways[plain[name]] > 1]
    rows = summary[summary["agent"].isin(kept) & summary["metric"].isin(SHOWN)].copy()
    rows["algorithm"] = rows["agent"].map(plain)
    rows["keyhole"] = rows["agent"].map({name: learners[name].keyhole for name in kept})
    rows["memory"] = rows["agent"].map(
        {name: learners[name].algorithm.startswith(RECURRENT) for name in kept}
    )
    place = rows["keyhole"].map({name: rank for rank, name in enumerate(ORDER)})
    keys = ["algorithm", "regularization", "mode", "metric", "_place", "memory"]
    return (
        rows.assign(_place=place).sort_values(keys, kind="stable", ignore_index=True).drop(columns="_place")
    )


def profiles(measured: pd.DataFrame, column: str = "score") -> pd.DataFrame:
    """Performance profile of every agent, mode and regularization.

    Args:
        measured: of `summary.measure_runs`.
        column: what a run scores; where it is unknown for all, `reward` stands in.

    Returns:
        One row per agent, mode, regularization and threshold: these, of (the column), threshold, share, low,
        high, n.
    """
    if not np.isfinite(measured[column].astype(float)).any():
        column = "reward"
    rows = []
    for level, at_level in measured.groupby("regularization"):
        scores = at_level[column].astype(float)
        at = np.linspace(scores.min(), scores.max(), THRESHOLDS)
        for key, runs in at_level.groupby(["agent", "mode"], sort=False):
            values = runs[column].to_numpy(np.float64)
            for threshold, *share in zip(at, *performance_profile(values, at), strict=True):
                rows.append((*key, level, column, threshold, *share, int(np.isfinite(values).sum())))
    return pd.DataFrame(rows, columns=[*GROUP, "of", "threshold", "share", "low", "high", "n"])


def worth_table(rows: pd.DataFrame) -> pd.DataFrame:
    """What a keyhole, or a memory, is worth: one row per algorithm, regularization, mode and way to see."""
    if rows.empty:
        return pd.DataFrame()
    key = ["algorithm", "regularization", "mode", "keyhole", "memory"]
    cells = rows.assign(
        cell=[
            format_cell(*row)
            for row in rows[["value", "low", "high", "n"]].itertuples(index=False, name=None)
        ]
    )
    names = list(dict.fromkeys(rows["metric"]))
    order = pd.MultiIndex.from_frame(rows[key].drop_duplicates())
    wide = cells.pivot(index=key, columns="metric", values="cell").reindex(index=order, columns=names)
    wide.columns = pd.Index([metric(name).heading for name in names])
    flat = wide.fillna("-").reset_index()
    return flat.assign(
        regularization=flat["regularization"].map("{:g}".format),
        memory=flat["memory"].map({True: "yes", False: "no"}),
    )
