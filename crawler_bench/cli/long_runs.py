"""Options of `train` for long runs: saving, evaluating and logging on the way, and going on after a kill."""

from pathlib import Path
from typing import Annotated

import typer

from crawler_bench.cli.console import console

SaveEvery = Annotated[
    int, typer.Option(min=0, help="Decisions between two checkpoints (whole rollouts); a kill loses no more.")
]
EvalEvery = Annotated[
    int, typer.Option(min=0, help="Decisions between two evaluations, kept in the run's evaluations.npz.")
]
Tensorboard = Annotated[Path | None, typer.Option(help="Folder of TensorBoard's event files.")]
Continue = Annotated[
    Path | None, typer.Option("--continue", metavar="RUN", help="Go on with this unfinished run.")
]


def go_on(run: Path, save_every: int, eval_every: int, tensorboard: Path | None, progress_bar: bool) -> None:
    """Finish an unfinished run, and print its folder."""
    from crawler_bench.runs.checkpoints import Habits
    from crawler_bench.runs.checkpoints import go_on as finish

    folder = finish(run, Habits(save_every, eval_every, tensorboard), progress_bar)
    console.print(str(folder), markup=False, soft_wrap=True)
