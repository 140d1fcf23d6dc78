"""Agents compared on the same reward: run all, measure all alike, collect tidy frames.

An entry is an experiment: an agent's configuration over seeds and regularizations. Each of its runs is
evaluated twice, with the actions that the agent thinks best ("deterministic") and with those that it takes
while it learns ("stochastic"); a run whose two policies are the same table counts once, under the name that
fits the table. A policy that is no table (it has a memory, or another keyhole than the index) counts once if
it earns the same in both, from every start and under every noise.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from crawler_bench.benchmark.keys import LEARNER, MODES, RUN, action_columns, select
from crawler_bench.config.errors import ConfigError
from crawler_bench.config.schema import Experiment, RunConfig, override
from crawler_bench.runs.evaluation import read_evaluation
from crawler_bench.runs.machines.engines import Workers
from crawler_bench.runs.results import read_outcomes
from crawler_bench.runs.sweep import Outcome, require_success, run_cells, run_experiments

REGULARIZATION = "environment.regularization"
WINDOWS = 64  # of a learning curve, or one fewer than the points that were recorded
FEWEST_WINDOWS = 5
CURVE = [*LEARNER, "decisions", "gradient_updates", "speed", "policy"]


@dataclass(frozen=True)
class Benchmark:
    """Everything that was measured.

    Attributes:
        outcomes: of the runs, by mode; a run that counts under one mode is missing under the other.
        runs: one row per run and mode, keyed by agent, mode, regularization and seed.
        evaluations: one row per run, mode, noise and start.
        cycles: one row per cycle.
        tables: one row per run, mode and observation, with the probability of each action.
        curves: one row per run and window of its learning: decisions, gradient_updates, speed, policy.
        failures: cells that did not finish.
    """

    outcomes: dict[str, list[Outcome]]
    runs: pd.DataFrame
    evaluations: pd.DataFrame
    cycles: pd.DataFrame
    tables: pd.DataFrame
    curves: pd.DataFrame
    failures: list[Outcome]


def run_benchmark(
    entries: Sequence[Experiment], runs_root: Path, *, jobs: Workers | int, quiet: bool
) -> Benchmark:
    """Train and evaluate every entry; finished runs are looked up.

    Raises:
        RuntimeError: if no run at all succeeded.
    """
    first, second = MODES
    found = {first: run_experiments(all_in_mode(entries, first), runs_root, jobs=jobs, quiet=quiet)}
    require_success(found[first])
    # The second mode finds the runs trained. What failed once is not tried again: it would fail again.
    trained = [outcome.cell for outcome in found[first] if not outcome.error]
    again = [replace(cell, config=in_mode(cell.config, second)) for cell in trained]
    found[second] = run_cells(again, runs_root, jobs=jobs, quiet=quiet)
    require_success(found[second])
    return collect(found)


def require_comparable(entries: Sequence[Experiment]) -> None:
    """Refuse entries that would not be measured alike.

    Raises:
        ConfigError: naming the entry and what about it differs.
    """
    names = [entry.name for entry in entries]
    if doubled := sorted({name for name in names if names.count(name) > 1}):
        raise ConfigError(f"{', '.join(doubled)} would be compared twice")
    budget = max(entry.run.decisions for entry in entries)
    for entry in entries:
        if set(entry.grid) - {REGULARIZATION}:
            raise ConfigError(f"{entry.name}: the grid of what is compared may hold {REGULARIZATION} alone")
        if entry.run.decisions not in (0, budget):
            raise ConfigError(
                f"{entry.name} learns from {entry.run.decisions} decisions and others from {budget}: "
                "all must learn from the same number"
            )
        for part in ("parameters", "evaluation"):
            if getattr(entry.run, part) != getattr(entries[0].run, part):
                raise ConfigError(
                    f"{entry.name} and {entries[0].name} have different {part}; say one with --set"
                )


def all_in_mode(entries: Sequence[Experiment], mode: str) -> list[Experiment]:
    """The same entries, evaluated in a mode."""
    return [entry.model_copy(update={"run": in_mode(entry.run, mode)}) for entry in entries]


def in_mode(run: RunConfig, mode: str) -> RunConfig:
    """The same run, evaluated in a mode."""
    return override(run, {"evaluation.mode": mode}, mode)


def collect(found: dict[str, list[Outcome]]) -> Benchmark:
    """Read what finished cells measured, by mode."""
    tables = pd.concat([_tables(outcomes, mode) for mode, outcomes in found.items()], ignore_index=True)
    frames = [measured(outcomes, mode) for mode, outcomes in found.items()]
    runs, evaluations, cycles = (pd.concat(each, ignore_index=True) for each in zip(*frames, strict=True))
    names = _names(tables, evaluations)

    def keep(frame: pd.DataFrame) -> pd.DataFrame:
        """The rows of modes that count, under their names."""
        named: Any = [
            names.get((agent, mode)) for agent, mode in zip(frame["agent"], frame["mode"], strict=True)
        ]
        return (
            frame.assign(mode=named).dropna(subset="mode").sort_values(RUN, kind="stable", ignore_index=True)
        )

    first = next(iter(found.values()))
    return Benchmark(
        {
            mode: [each for each in outcomes if (each.cell.experiment, mode) in names]
            for mode, outcomes in found.items()
        },
        keep(runs), keep(evaluations), keep(cycles), keep(tables), learning_curves(first),
        [outcome for outcomes in found.values() for outcome in outcomes if outcome.error],
    )  # fmt: skip


def measured(outcomes: Sequence[Outcome], mode: str) -> list[pd.DataFrame]:
    """Runs, evaluations and cycles, keyed by RUN."""
    frames = []
    for frame in read_outcomes(outcomes):
        keyed = frame.drop(columns="agent", errors="ignore").rename(columns={"experiment": "agent"})
        keyed.insert(1, "mode", mode)
        frames.append(keyed)
    return frames


def _tables(outcomes: Sequence[Outcome], mode: str) -> pd.DataFrame:
    frames = []
    for outcome in outcomes:
        if outcome.evaluation is not None:
            table = read_evaluation(outcome.evaluation).table
            if not table.size:
                continue
            frame = pd.DataFrame(table).add_prefix("p_")
            agent, *rest = learner_of(outcome)
            key = dict(zip(RUN, (agent, mode, *rest), strict=True))
            frames.append(pd.DataFrame(key | {"observation": frame.index}).join(frame))
    return pd.concat(frames, ignore_index=True) if frames else pd.DataFrame(columns=RUN)


def _names(tables: pd.DataFrame, evaluations: pd.DataFrame) -> dict[tuple[str, str], str]:
    """The name of each agent's mode; missing where it repeats the other mode."""
    names = {}
    for agent in evaluations["agent"].unique():
        rows, by_table = select(tables, agent=agent), True
        if rows.empty:
            rows, by_table = select(evaluations, agent=agent), False
        place = ["observation"] if by_table else ["noise", "start"]
        known = action_columns(rows) if by_table else ["speed", "reward"]
        indexed = rows.set_index(["regularization", "seed", *place])
        one, other = (indexed[indexed["mode"] == mode][known] for mode in MODES)
        one, other = one.align(other, join="inner", axis=0)  # a run may have failed in one mode
        if len(one) and np.array_equal(one, other):
            sure = not by_table or bool((one.max(axis=1) == 1).all())
            names[str(agent), MODES[0]] = MODES[0] if sure else MODES[1]
        else:
            names.update({(str(agent), mode): mode for mode in MODES})
    return names


def learner_of(outcome: Outcome) -> tuple[str, float, int]:
    """Agent, regularization and seed of a run: its LEARNER."""
    return outcome.cell.experiment, outcome.cell.config.environment.regularization, outcome.cell.seed


def learning_curves(outcomes: Sequence[Outcome]) -> pd.DataFrame:
    """Learning curves in windows of equally many decisions; agents that learn nothing have none."""
    curves = []
    for outcome in outcomes:
        if outcome.folder is None or not outcome.cell.config.decisions:
            continue
        learning = pd.read_csv(outcome.folder / "learning.csv", dtype={"policy": str}).sort_values(
            "decisions"
        )
        if (curve := windows(dict(zip(LEARNER, learner_of(outcome), strict=True)), learning)) is not None:
            curves.append(curve)
    return pd.concat(curves, ignore_index=True) if curves else pd.DataFrame(columns=CURVE)


def windows(learner: dict[str, Any], learning: pd.DataFrame) -> pd.DataFrame | None:
    """A learning curve in windows of equally many decisions.

    Args:
        learner: by the names of LEARNER.
        learning: rows in the order of their decisions, with gradient_updates, time, distance and policy.

    Returns:
        One row per window; None of a run that hardly ever called back while it learned.
    """
    decisions = learning["decisions"].to_numpy(float)
    count = min(WINDOWS, len(decisions) - 1)
    if count < FEWEST_WINDOWS:
        return None
    ends = np.linspace(0, decisions[-1], count + 1)
    time, distance, updates = (
        np.interp(ends, decisions, learning[column].to_numpy(float))
        for column in ("time", "distance", "gradient_updates")
    )
    elapsed = np.diff(time)
    return pd.DataFrame(learner | {
        "decisions": ends[1:], "gradient_updates": updates[1:],
        "speed": np.diff(distance) / np.where(elapsed > 0, elapsed, np.nan),
        "policy": learning["policy"].to_numpy()[np.searchsorted(decisions, ends[1:], side="right") - 1],
    })  # fmt: skip
