"""Re-run one cell of the benchmark's tables from scratch, and compare."""

import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from crawler_bench.benchmark.benchmark import in_mode, learning_curves, measured
from crawler_bench.benchmark.keys import GROUP, RUN, select
from crawler_bench.benchmark.summary import summarize_benchmark
from crawler_bench.config.errors import ConfigError
from crawler_bench.config.files import load_experiment
from crawler_bench.config.schema import Experiment, override
from crawler_bench.output.csv_files import read_csv, rounded
from crawler_bench.runs.machines.engines import Workers
from crawler_bench.runs.sweep import run_experiments
from crawler_bench.runs.untrusted import agents_of, inside, require_trust


def reproduce(
    folder: Path, hash_: str, *, jobs: Workers | int, quiet: bool, trust: bool = False
) -> pd.DataFrame:
    """Train and evaluate the runs of a cell from scratch, in a fresh folder.

    Args:
        folder: that `crawler-bench benchmark` wrote.
        hash_: of a cell of summary.csv, or of a run of runs.csv.
        jobs: who does it, see `run_experiments`.
        quiet: show no progress.
        trust: import whatever agent the folder names.

    Returns:
        agent, mode, regularization, metric, before, low, high, now, verdict: one row for a cell, and for a
        run one row per column of runs.csv.

    Raises:
        ConfigError: if the folder is not one of ours, no cell has this hash, or the cell's entry lies
            elsewhere or names an agent that is neither ours nor installed.
        RuntimeError: if a run failed.
    """
    runs, evaluations, curves, summary = (_read(folder / f"{name}.csv") for name in _FILES)
    row, of_run = _find(hash_, summary, runs)
    path = inside(folder, "entries", f"{row['agent']}.yaml")
    entry = load_experiment(path)
    if not trust:
        require_trust(agents_of(entry), path)
    run = override(entry.run, {"regularization": row["regularization"]}, entry.name)
    key = {name: row[name] for name in GROUP}
    finished = select(runs, **key)["seed"]  # not the seeds that failed
    seeds = [int(row["seed"])] if of_run else finished.astype(int).tolist()
    experiment = Experiment(name=entry.name, run=in_mode(run, str(row["mode"])), seeds=seeds)
    with tempfile.TemporaryDirectory() as fresh:
        outcomes = run_experiments([experiment], Path(fresh), jobs=jobs, quiet=quiet)
        if failed := [outcome.error for outcome in outcomes if outcome.error]:
            raise RuntimeError(f"{len(failed)} of {len(outcomes)} runs failed; the first: {failed[0]}")
        new_runs, new_evaluations, _ = measured(outcomes, str(row["mode"]))
        new_curves = learning_curves(outcomes)
    if of_run:
        return _compare_runs(row, rounded(new_runs).iloc[0])
    runs, evaluations, curves = (
        _replaced(old, rounded(new))
        for old, new in ((runs, new_runs), (evaluations, new_evaluations), (curves, new_curves))
    )

    path = folder / "ceilings.csv"
    ceilings = read_csv(path) if path.is_file() else None
    again = rounded(summarize_benchmark(runs, evaluations, curves, lambda *_: "", ceilings))
    cell = select(again, **key, metric=row["metric"]).iloc[0]
    before, low, high = (float(row[name]) for name in ("value", "low", "high"))
    now = float(cell["value"])
    verdict = _verdict(before, now, low, high)
    numbers = {"before": before, "low": low, "high": high, "now": now, "verdict": verdict}
    return pd.DataFrame([key | {"metric": row["metric"]} | numbers])


_FILES = ("runs", "evaluations", "curves", "summary")


def _read(path: Path) -> pd.DataFrame:
    try:
        return read_csv(path)
    except (OSError, ValueError):
        raise ConfigError(
            f"{path} cannot be read: `crawler-bench benchmark` writes it; name its folder with --results"
        ) from None


def _find(hash_: str, summary: pd.DataFrame, runs: pd.DataFrame) -> tuple["pd.Series[Any]", bool]:
    """The row with a hash, and whether it is a run's."""
    for frame, of_run in ((summary, False), (runs, True)):
        found = frame[frame["hash"].fillna("").str.startswith(hash_.removeprefix("#"))]
        if len(found) > 1:
            raise ConfigError(f"{len(found)} cells have a hash that begins with {hash_}: write it in full")
        if len(found) == 1:
            return found.iloc[0], of_run
    raise ConfigError(
        f"no cell or run has the hash {hash_}; they stand in summary.csv and runs.csv of the folder that "
        "--results names"
    )


def _replaced(old: pd.DataFrame, new: pd.DataFrame) -> pd.DataFrame:
    """The old rows, with the runs of `new` exchanged."""
    if new.empty:
        return old
    key = [name for name in RUN if name in old and name in new]
    gone = old.set_index(key).index.isin(new.set_index(key).index)
    joined = pd.concat([old[~gone], new[[name for name in old if name in new]]])
    return joined.sort_values(key, kind="stable", ignore_index=True)


def _compare_runs(row: "pd.Series[Any]", new: "pd.Series[Any]") -> pd.DataFrame:
    """Every number of a run, and its policy, before and now: each is equal or different."""
    rows = []
    for name in row.index.drop([*RUN, "hash", "run"]):
        before, now = row[name], new.get(name)
        same = before == now or (pd.isna(before) and name in new and pd.isna(now))
        numbers = {"before": before, "now": now, "verdict": "equal" if same else "different"}
        rows.append({each: row[each] for each in GROUP} | {"metric": name} | numbers)
    return pd.DataFrame(rows)


def _verdict(before: float, now: float, low: float, high: float) -> str:
    if before == now or (np.isnan(before) and np.isnan(now)):
        return "equal"
    return "within its interval" if low <= now <= high else "different"
