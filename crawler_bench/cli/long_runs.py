"""Options of `train` for long runs: saving, evaluating and logging on the way, and going on after a kill."""

from pathlib import Path
from typing import Annotated

import typer

from crawler_bench.cli.terminal.console import console, logger, phase, starting

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


def go_on(run: Path, habits: tuple[int, int, Path | None], trust: bool, quiet: bool) -> None:
    """Finish an unfinished run, and print its folder.

    Args:
        run: its folder.
        habits: --save-every (0: as often as before), --eval-every and --tensorboard.
        trust: import its agent, whatever it is.
        quiet: print the folder only.
    """
    with starting(f"going on with {run}", quiet):
        from crawler_bench.runs.long.running import Habits, finished, read_unfinished, train_long
    folder = finished(run)
    if folder is not None:
        logger(quiet)(f"{folder} is finished")
    else:
        config, seed, before = read_unfinished(run, trust)
        save_every, eval_every, tensorboard = habits
        kept = Habits(save_every or before.save_every, eval_every, tensorboard)
        with phase(f"training (seed {seed})", config.decisions, "decisions", quiet) as progress:
            folder = train_long(config, seed, run.parent, kept, progress)
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
