"""Experiments, run by many workers: resumable, with progress, no failure unseen."""

import traceback
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from rich.console import Console

from crawler_bench.config.errors import ConfigError, explain
from crawler_bench.config.schema import Experiment, RunConfig
from crawler_bench.runs.agent import agent_class
from crawler_bench.runs.evaluation import evaluate
from crawler_bench.runs.folders import claims
from crawler_bench.runs.machines.engines import Lost, Workers, as_workers
from crawler_bench.runs.machines.workplaces import engine
from crawler_bench.runs.progress import SweepProgress
from crawler_bench.runs.training import train

MANY = 3000  # runs; to find out which of them are finished takes seconds


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
        notes: what else a user should know, a line each.
        busy: whether another command works on it.
    """

    cell: Cell
    folder: Path | None
    evaluation: Path | None
    error: str = ""
    log: str = ""
    notes: tuple[str, ...] = ()
    busy: bool = False


def run_experiments(
    experiments: Iterable[Experiment], root: Path, *, jobs: Workers | int = 0, quiet: bool = False
) -> list[Outcome]:
    """Run every run of experiments in parallel; what two of them share is run once.

    Args:
        experiments: what to run; finished runs are only looked up.
        root: folder of run folders.
        jobs: who does it; a number of processes, where 0 means one per core, or `Workers`.
        quiet: say nothing.

    Returns:
        One outcome per run, experiment by experiment in the order of `Experiment.runs`.

    Raises:
        ConfigError: before anything is computed, if an agent cannot be found.
    """
    return run_cells(cells_of(experiments), root, jobs=jobs, quiet=quiet)


def cells_of(experiments: Iterable[Experiment]) -> list[Cell]:
    """The runs of experiments.

    Raises:
        ConfigError: if an agent cannot be found.
    """
    cells = [Cell(each.name, config, seed) for each in experiments for config, seed in each.runs()]
    for name in dict.fromkeys(cell.config.agent for cell in cells):
        agent_class(name)
    return cells


def require_success(outcomes: Sequence[Outcome]) -> None:
    """Refuse to go on if nothing succeeded.

    Raises:
        RuntimeError: with the first error, if every cell failed.
    """
    if all(outcome.error for outcome in outcomes):
        raise RuntimeError(f"all {len(outcomes)} runs failed; the first: {outcomes[0].error}")


def run_cell(cell: Cell, root: Path, wait: bool = True) -> Outcome:
    """Train and evaluate one cell, or find that it is done; errors are returned, not raised."""
    notes: list[str] = []
    try:
        folder = train(cell.config, cell.seed, root, wait=wait, say=notes.append)
        # Whoever asks for a run names its agent; a registered one is read as everybody's are.
        named = [cell.config.agent] if ":" in cell.config.agent else []
        evaluation = evaluate(folder, cell.config.evaluation, trusted=named, wait=wait, say=notes.append)
        return Outcome(cell, folder, evaluation, notes=tuple(notes))
    except claims.Busy:
        return Outcome(cell, None, None, busy=True)
    except Exception as error:
        return Outcome(cell, None, None, _say_error(error), traceback.format_exc(), tuple(notes))


def _say_error(error: Exception) -> str:
    known = isinstance(error, OSError | ConfigError)
    return explain(error) if known else f"{type(error).__name__}: {explain(error)}"


def run_cells(
    cells: Sequence[Cell], root: Path, *, jobs: Workers | int = 0, quiet: bool = False
) -> list[Outcome]:
    """Run cells as `run_experiments` does, and return one outcome per cell in their order.

    What another command works on is left to it, and looked up when all else is done.
    """
    claims.sweep(root)
    console = Console(stderr=True, quiet=quiet)
    unique = {_identity(cell): cell for cell in reversed(cells)}
    outcomes: dict[str, Outcome] = {}
    left = list(dict.fromkeys(map(_identity, cells)))
    workers = as_workers(jobs)
    if len(unique) > MANY:
        console.print(f"looking for the finished ones of {len(unique):,} runs", soft_wrap=True)
    progress = SweepProgress([(cell.config, cell.seed) for cell in unique.values()], root, workers.processes)
    console.print(progress.plan(), markup=False, soft_wrap=True)
    place = root.resolve() if workers.on else root  # a worker elsewhere may stand in another folder
    try:
        with engine(workers) as run, progress.shown(console):
            for wait in (False, True):
                busy = []
                for found in run(_named, ((name, unique[name], place, wait) for name in left)):
                    name, outcome = _lost(found) if isinstance(found, Lost) else found
                    if outcome.busy:
                        busy.append(name)
                        continue
                    outcomes[name] = outcome
                    if outcome.error:
                        progress.give_up(outcome.cell.config, outcome.cell.seed)
                    _say(console, outcome, len(outcomes), len(unique))
                left = busy
                if not left:
                    break
                console.print(f"waiting for another command, which works on {len(left)} of the runs")
    finally:
        claims.sweep(root)  # of what dead workers were at
    return [replace(outcomes[_identity(cell)], cell=cell) for cell in cells]


def _lost(found: Lost) -> tuple[str, Outcome]:
    name, cell, *_ = found.task
    return name, Outcome(cell, None, None, found.reason)


def _identity(cell: Cell) -> str:
    """What two cells share that are one run with one evaluation."""
    return f"{cell.seed} {cell.config.model_dump_json()}"


def _named(name: str, cell: Cell, root: Path, wait: bool) -> tuple[str, Outcome]:
    return name, run_cell(cell, root, wait)


def _say(console: Console, outcome: Outcome, done: int, total: int) -> None:
    """A plain line per cell where there is no terminal; on one, the bar says it, except failures."""
    name = f"{outcome.cell.experiment} seed {outcome.cell.seed}"
    for note in outcome.notes:
        console.print(f"{name}: {note}", style="yellow", markup=False, soft_wrap=True)
    if outcome.error:
        console.print(f"FAILED {name}: {outcome.error}", style="red", markup=False)
    elif not console.is_terminal and outcome.folder is not None:
        console.print(f"[{done}/{total}] {name}: {outcome.folder.name}", markup=False, soft_wrap=True)
