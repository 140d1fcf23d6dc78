"""Many runs in parallel processes: resumable, with progress, no failure unseen."""

import os
import traceback
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd
from joblib import Parallel, delayed
from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from crawler_bench.config.schema import ConfigError, RunConfig
from crawler_bench.gait import metrics
from crawler_bench.runs import store
from crawler_bench.runs.evaluation import Evaluation, evaluate, read_evaluation
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


def run_cell(cell: Cell, root: Path) -> Outcome:
    """Train and evaluate one cell, or find that it is done; errors are returned, not raised."""
    try:
        folder = train(cell.config, cell.seed, root)
        return Outcome(cell, folder, evaluate(folder, cell.config.evaluation))
    except Exception as error:
        return Outcome(cell, None, None, _say_error(error), traceback.format_exc())


def _say_error(error: Exception) -> str:
    known = isinstance(error, OSError | ConfigError)
    return store.explain(error) if known else f"{type(error).__name__}: {store.explain(error)}"


def run_cells(cells: Sequence[Cell], root: Path, *, jobs: int = 0, quiet: bool = False) -> list[Outcome]:
    """Run cells in parallel processes.

    Args:
        cells: what to run; finished ones are only looked up.
        root: folder of run folders.
        jobs: number of processes; 0 means one a core.
        quiet: say nothing.

    Returns:
        One outcome a cell, in their order.
    """
    store.sweep_drafts(root)
    console = Console(stderr=True, quiet=quiet)
    outcomes: dict[int, Outcome] = {}
    workers = Parallel(n_jobs=jobs or os.cpu_count() or 1, return_as="generator_unordered")
    tasks = (delayed(_numbered)(number, cell, root) for number, cell in enumerate(cells))
    with _progress(console) as progress:
        bar = progress.add_task("runs", total=len(cells))
        for number, outcome in workers(tasks):
            outcomes[number] = outcome
            progress.advance(bar)
            _say(console, outcome, len(outcomes), len(cells))
    return [outcomes[number] for number in range(len(cells))]


def _numbered(number: int, cell: Cell, root: Path) -> tuple[int, Outcome]:
    return number, run_cell(cell, root)


def _progress(console: Console) -> Progress:
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    left = (TextColumn("left"), TimeRemainingColumn())
    return Progress(*columns, *left, console=console, disable=not console.is_terminal, transient=True)


def _say(console: Console, outcome: Outcome, done: int, total: int) -> None:
    """A plain line for every cell where there is no terminal; on one, the bar tells, but for failures."""
    name = f"{outcome.cell.experiment} seed {outcome.cell.seed}"
    if outcome.error:
        console.print(f"FAILED {name}: {outcome.error}", style="red", markup=False)
    elif not console.is_terminal and outcome.folder is not None:
        console.print(f"[{done}/{total}] {name}: {outcome.folder.name}", markup=False, soft_wrap=True)


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
        runs, a row a run; evaluations, a row a run, noise and start; cycles, a row a cycle.
    """
    measured = []
    for outcome in outcomes:
        if outcome.folder is None or outcome.evaluation is None:
            continue
        key = label(outcome.cell.experiment, outcome.cell.config, outcome.cell.seed)
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
    evaluations, cycles = (
        [pd.DataFrame(each.key, index=frame.index).join(frame) for each, frame in frames]
        for frames in (
            [(each, each.evaluation.starts) for each in measured],
            [(each, each.evaluation.cycles) for each in measured],
        )
    )
    return pd.DataFrame(runs), pd.concat(evaluations, ignore_index=True), pd.concat(cycles, ignore_index=True)


def summarize(evaluation: Evaluation, learning: pd.DataFrame) -> dict[str, object]:
    """One run in one row: gait metrics are means over the starts that move, speeds as their names say."""
    starts = evaluation.starts
    quiet = starts[starts["noise"] == starts["noise"].iloc[0]]
    moving = quiet[~quiet["stalled"].astype(bool)]
    policy = evaluation.table.argmax(axis=1)
    settings = ["noise", "start", "speed", "reward", "stalled", "cycle_duration", "cycles"]
    durations = evaluation.cycles["duration"]
    row: dict[str, object] = {
        "policy": metrics.policy_text(evaluation.table),
        "observations": len(policy),
        "diagonal_distance": metrics.diagonal_distance(policy),
        "off_diagonal": metrics.off_diagonal(evaluation.table),
        "speed": quiet["speed"].mean(),
        "speed_median": quiet["speed"].median(),
        "speed_moving": moving["speed"].mean(),
        "reward": quiet["reward"].mean(),
        "stall_share": quiet["stalled"].astype(float).mean(),
        "decisions": _last(learning, "decisions"),
        "gradient_updates": _last(learning, "gradient_updates"),
        "speed_learning": _learning_speed(learning, 0.0),
        "speed_learning_end": _learning_speed(learning, 0.9),
        "cycles": len(durations),
        "cycle_duration": durations.mean(),
        "waves_per_tau": 1 / durations.mean() if len(durations) else float("nan"),
    }
    averages: dict[str, object] = moving.drop(columns=settings).mean().to_dict()
    return row | averages


def _last(learning: pd.DataFrame, column: str) -> float:
    return float(learning[column].iloc[-1]) if len(learning) else float("nan")


def _learning_speed(learning: pd.DataFrame, since: float) -> float:
    """Speed while learning, from a share of the run to its end; NaN for an agent that does not learn."""
    if len(learning) < 2:
        return float("nan")
    start = learning.iloc[int(since * len(learning))] if since else pd.Series({"time": 0.0, "distance": 0.0})
    end = learning.iloc[-1]
    elapsed = end["time"] - start["time"]
    return float((end["distance"] - start["distance"]) / elapsed) if elapsed > 0 else float("nan")
