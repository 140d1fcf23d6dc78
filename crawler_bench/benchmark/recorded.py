"""Runs of others' learners in the tables: recordings of `crawler_bench.record`, and Monitor CSVs.

A recording says how far the crawler came while it was learned on and which neuron was turned ON at which
index. On the index, or its zeros and ones, what the learner did in the last tenth of its decisions is a table
of shares, which is measured frozen like any other, under the mode ACTED; it is an estimate, and drawn from
where nothing was ever done. Through another keyhole, and from a Monitor's file, only what was earned while
learning is known: the mode LEARNING, everything else is empty.
"""

import json
import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from crawler_bench.benchmark.benchmark import Benchmark, windows
from crawler_bench.benchmark.keys import LEARNER, RUN
from crawler_bench.config.errors import ConfigError
from crawler_bench.config.schema import RunConfig, build, override
from crawler_bench.runs.evaluation import measure
from crawler_bench.runs.recorder import ABOUT, COUNTERS
from crawler_bench.runs.results import summarize

ACTED, LEARNING = "as acted", "while learning"
END = 0.1  # share of the decisions whose actions make the table
MONITOR = "*monitor.csv"


@dataclass(frozen=True)
class Recorded:
    """A run of somebody's learner.

    Attributes:
        agent: its name in the tables.
        seed: of the run.
        config: the run as ours would be configured; of a Monitor's file the benchmark's own.
        learning: one row per window: decisions, time, distance, reward, all summed so far; time and distance
            are NaN where nobody counted them.
        table: (N, N) shares of actions in the last tenth; None where they say nothing.
        folder: where it was found.
    """

    agent: str
    seed: int
    config: RunConfig
    learning: pd.DataFrame
    table: np.ndarray[Any, Any] | None
    folder: Path


def find(root: Path, run: RunConfig) -> list[Recorded]:
    """All recordings and Monitor files in a folder and below.

    Args:
        root: the folder.
        run: of the benchmark; a recording of another body is refused.

    Raises:
        ConfigError: naming the folder that cannot be compared or read.
    """
    found = [_read_recording(path.parent, run) for path in sorted(root.rglob(ABOUT))]
    folders = dict.fromkeys(path.parent for path in sorted(root.rglob(MONITOR)))
    return found + [_read_monitors(folder, run) for folder in folders if not (folder / ABOUT).is_file()]


def unknown(each: Recorded) -> str:
    """What is not known of a run, in words; empty if nothing."""
    if each.table is not None:
        return ""
    rest = "its frozen policy: speed, gait, noise, regrets and score of one"
    no_distance = each.learning["distance"].isna().all()
    return (
        f"{each.agent} seed {each.seed}: unknown are {'distance and time, and ' if no_distance else ''}{rest}"
    )


def with_recorded(benchmark: Benchmark, found: list[Recorded], run: RunConfig) -> Benchmark:
    """A benchmark with the rows of recorded runs, measured as its own are."""
    frames: list[list[pd.DataFrame]] = [[], [], [], []]
    runs, evaluations, cycles, tables = frames
    curves: list[pd.DataFrame | None] = []
    for each in found:
        config = override(each.config, {}, each.agent).model_copy(update={"evaluation": run.evaluation})
        key = dict(zip(RUN, (each.agent, ACTED, config.environment.regularization, each.seed), strict=True))
        learner = {name: key[name] for name in LEARNER}
        learning = each.learning.assign(gradient_updates=float("nan"))
        if each.table is None:
            runs.append(pd.DataFrame([key | {"mode": LEARNING} | _earned(each) | {"run": each.folder.name}]))
        else:
            measured = measure(config, each.seed, each.table, run.evaluation)
            runs.append(pd.DataFrame([key | summarize(measured, learning) | {"run": each.folder.name}]))
            rows = pd.DataFrame(each.table).add_prefix("p_")
            for kept, frame in ((evaluations, measured.starts), (cycles, measured.cycles)):
                kept.append(pd.DataFrame(key, index=frame.index).join(frame))
            tables.append(pd.DataFrame(key | {"observation": rows.index}).join(rows))
        if not each.learning["distance"].isna().any():
            curves.append(windows(learner, learning.assign(policy="")))
    return replace(
        benchmark,
        runs=_joined(benchmark.runs, runs),
        evaluations=_joined(benchmark.evaluations, evaluations),
        cycles=_joined(benchmark.cycles, cycles),
        tables=_joined(benchmark.tables, tables),
        curves=_joined(benchmark.curves, [each for each in curves if each is not None]),
    )


def _joined(frame: pd.DataFrame, more: list[pd.DataFrame]) -> pd.DataFrame:
    filled = [each for each in (frame, *more) if len(each)]
    return pd.concat(filled, ignore_index=True) if filled else frame


def _earned(each: Recorded) -> dict[str, object]:
    """What is known of a run without a frozen policy: the last tenth of its learning."""
    curve = each.learning
    end, before = curve.iloc[-1], curve.iloc[max(0, int((1 - END) * len(curve)) - 1)]
    decisions = end["decisions"] - before["decisions"] or np.nan
    elapsed = end["time"] - before["time"] or np.nan
    speed = (end["distance"] - before["distance"]) / elapsed
    reward = (end["reward"] - before["reward"]) / decisions
    return {"policy": "", "decisions": float(end["decisions"]), "reward": reward, "speed_learning_end": speed,
            "stall_share": np.nan, "gradient_updates": np.nan}  # fmt: skip


def _read_recording(folder: Path, run: RunConfig) -> Recorded:
    try:
        about = json.loads((folder / ABOUT).read_text())
        files = [pd.read_csv(path) for path in sorted(folder.glob("crawler-*.csv"))]
        files = [each for each in files if len(each)]
        n = int(about["parameters"]["n_segments"])
        environment = {name: about[name] for name in ("keyhole", "noise", "regularization")}
        content = {"environment": environment, "parameters": about["parameters"], "decisions": 0}
        config = build(RunConfig, content, str(folder))
        counters = [each[list(COUNTERS)] for each in files]
        counts = [
            each.drop(columns=list(COUNTERS)).to_numpy(np.int64).reshape(len(each), n, n) for each in files
        ]
        agent, seed = _name(folder, about["agent"], about["seed"])
    except (OSError, KeyError, TypeError, ValueError) as error:
        reason = " ".join(str(error).split())
        raise ConfigError(f"{folder} is no recording of crawler_bench.record: {reason}") from None
    if not files:
        raise ConfigError(f"{folder} holds no decisions: was the loop killed within its first thousand?")
    if config.parameters != run.parameters:
        raise ConfigError(f"{folder} was recorded on another body than is compared; say which with --set")
    sees_index = about["keyhole"] in ("index", "one-hot")
    return Recorded(agent, seed, config, _merged(counters), _shares(counts) if sees_index else None, folder)


def _merged(counters: list[pd.DataFrame]) -> pd.DataFrame:
    """What all environments of a run counted, together, at the windows of the first."""
    first = counters[0]
    names = [name for name in COUNTERS if name != "decisions"]
    shared = np.arange(1, len(first) + 1) / len(first)
    total = {
        name: sum(
            np.interp(shared, np.arange(len(each) + 1) / len(each), [0.0, *each[name]]) for each in counters
        )
        for name in ("decisions", *names)
    }
    start = pd.DataFrame({name: [0.0] for name in total})
    return pd.concat([start, pd.DataFrame(total)], ignore_index=True)


def _shares(counts: list[np.ndarray[Any, Any]]) -> np.ndarray[Any, Any]:
    """Shares of the actions in the last tenth; where an index was never seen, those of random action."""
    last = [each[-max(1, round(END * len(each))) :].sum(axis=0) for each in counts]
    total = np.sum(last, axis=0).astype(np.float64)
    seen = total.sum(axis=1, keepdims=True)
    return np.where(seen > 0, total / np.maximum(seen, 1), 1 / len(total))


def _read_monitors(folder: Path, run: RunConfig) -> Recorded:
    try:
        files = [pd.read_csv(path, skiprows=1) for path in sorted(folder.glob(MONITOR))]
        episodes = pd.concat(files).sort_values("t")[["r", "l"]].astype(float)
    except (OSError, KeyError, ValueError) as error:
        raise ConfigError(f"{folder}: {' '.join(str(error).split())}; a Monitor's CSV has r, l, t") from None
    if episodes.empty:
        raise ConfigError(f"{folder}: its Monitor files hold no finished episode")
    sums = pd.DataFrame(
        {"decisions": [0.0, *episodes["l"].cumsum()], "reward": [0.0, *episodes["r"].cumsum()]}
    )
    agent, seed = _name(folder, "", None)
    learning = sums.assign(time=np.nan, distance=np.nan, episodes=range(len(sums)))
    return Recorded(agent, seed, run, learning[list(COUNTERS)], None, folder)


def _name(folder: Path, agent: str, seed: int | None) -> tuple[str, int]:
    """Name and seed, from what was said or from the folder's name."""
    found = re.fullmatch(r"(.*?)(?:[-_]+(?:seed)?[-_]?(\d+))?", folder.resolve().name)
    assert found is not None
    return agent or found[1] or "recorded", int(found[2] or 0) if seed is None else int(seed)
