"""Experiments, run in parallel processes: resumable, with progress, no failure unseen."""

import os
import traceback
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from joblib import Parallel, delayed
from rich.console import Console

from crawler_bench.config.errors import ConfigError, explain
from crawler_bench.config.schema import Experiment, RunConfig
from crawler_bench.runs import store
from crawler_bench.runs.agent import agent_class
from crawler_bench.runs.evaluation import evaluate
from crawler_bench.runs.progress import SweepProgress
from crawler_bench.runs.training import train


@dataclass(frozen=True)
class Cell:
    """One run of a sweep.

    Attributes:
        experiment: name of the experiment that it belongs to.
        config: the run.
        seed: its seed.
    """

    experiment: str
    config: RunConfig
    seed: int


@dataclass(frozen=True)
class Outcome:
    """What became of a cell.

    Attributes:
        cell: the cell.
        folder: its run folder; None if it failed.
        evaluation: folder of its evaluation; None if it failed.
        error: the last line of what went wrong, empty if nothing did.
        log: the whole traceback.
    """

    cell: Cell
    folder: Path | None
    evaluation: Path | None
    error: str = ""
    log: str = ""


def run_experiments(
    experiments: Iterable[Experiment], root: Path, *, jobs: int = 0, quiet: bool = False
) -> list[Outcome]:
    """Run every run of experiments in parallel processes; what two of them share is run once.

    Args:
        experiments: what to run; finished runs are only looked up.
        root: folder of run folders.
        jobs: number of processes; 0 means one per core.
        quiet: say nothing.

    Returns:
        One outcome per run, experiment by experiment in the order of `Experiment.runs`.

    Raises:
        ConfigError: before anything is computed, if an agent cannot be found.
    """
    cells = [Cell(each.name, config, seed) for each in experiments for config, seed in each.runs()]
    for name in dict.fromkeys(cell.config.agent for cell in cells):
        agent_class(name)
    return run_cells(cells, root, jobs=jobs, quiet=quiet)


def require_success(outcomes: Sequence[Outcome]) -> None:
    """Refuse to go on if nothing succeeded.

    Raises:
        RuntimeError: with the first error, if every cell failed.
    """
    if all(outcome.error for outcome in outcomes):
        raise RuntimeError(f"all {len(outcomes)} runs failed; the first: {outcomes[0].error}")


def run_cell(cell: Cell, root: Path) -> Outcome:
    """Train and evaluate one cell, or find that it is done; errors are returned, not raised."""
    try:
        folder = train(cell.config, cell.seed, root)
        return Outcome(cell, folder, evaluate(folder, cell.config.evaluation))
    except Exception as error:
        return Outcome(cell, None, None, _say_error(error), traceback.format_exc())


def _say_error(error: Exception) -> str:
    known = isinstance(error, OSError | ConfigError)
    return explain(error) if known else f"{type(error).__name__}: {explain(error)}"


def run_cells(cells: Sequence[Cell], root: Path, *, jobs: int = 0, quiet: bool = False) -> list[Outcome]:
    """Run cells as `run_experiments` does, and return one outcome per cell in their order."""
    store.sweep_drafts(root)
    console = Console(stderr=True, quiet=quiet)
    unique = {_identity(cell): cell for cell in reversed(cells)}
    outcomes: dict[str, Outcome] = {}
    jobs = jobs or os.cpu_count() or 1
    progress = SweepProgress([(cell.config, cell.seed) for cell in unique.values()], root, jobs)
    console.print(progress.plan(), markup=False, soft_wrap=True)
    workers = Parallel(n_jobs=jobs, return_as="generator_unordered")
    tasks = (delayed(_named)(name, unique[name], root) for name in dict.fromkeys(map(_identity, cells)))
    with progress.shown(console):
        for name, outcome in workers(tasks):
            outcomes[name] = outcome
            if outcome.error:
                progress.give_up(outcome.cell.config, outcome.cell.seed)
            _say(console, outcome, len(outcomes), len(unique))
    return [replace(outcomes[_identity(cell)], cell=cell) for cell in cells]


def _identity(cell: Cell) -> str:
    """What two cells share that are one run with one evaluation."""
    return f"{cell.seed} {cell.config.model_dump_json()}"


def _named(name: str, cell: Cell, root: Path) -> tuple[str, Outcome]:
    return name, run_cell(cell, root)


def _say(console: Console, outcome: Outcome, done: int, total: int) -> None:
    """A plain line per cell where there is no terminal; on one, the bar says it, except failures."""
    name = f"{outcome.cell.experiment} seed {outcome.cell.seed}"
    if outcome.error:
        console.print(f"FAILED {name}: {outcome.error}", style="red", markup=False)
    elif not console.is_terminal and outcome.folder is not None:
        console.print(f"[{done}/{total}] {name}: {outcome.folder.name}", markup=False, soft_wrap=True)
