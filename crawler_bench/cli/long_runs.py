"""Options of `train` for long runs: saving, evaluating and logging on the way, and going on after a kill."""

from pathlib import Path
from typing import Annotated

import typer

from crawler_bench.cli.console import console, starting

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


def go_on(
    run: Path, save_every: int, eval_every: int, tensorboard: Path | None, trust: bool, quiet: bool
) -> None:
    """Finish an unfinished run, and print its folder."""
    with starting(f"going on with {run}", quiet):
        from crawler_bench.runs.long.running import Habits
        from crawler_bench.runs.long.running import go_on as finish
    folder = finish(run, Habits(save_every, eval_every, tensorboard), trust=trust)
    console.print(str(folder), markup=False, soft_wrap=True)


def require_alone(*words: object) -> None:
    """Refuse what else is said beside --continue: the run has its configuration.

    Raises:
        ConfigError: if anything is.
    """
    from crawler_bench.config.errors import ConfigError

    if any(word is not None for word in words):
        raise ConfigError(
            "--continue takes all but --save-every, --eval-every and --tensorboard from its run"
        )
