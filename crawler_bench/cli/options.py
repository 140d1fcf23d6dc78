"""What the commands share: their options, and what these change."""

import errno
import os
import sys
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import typer

if TYPE_CHECKING:
    from crawler_bench.config.schema import Experiment
    from crawler_bench.runs.sweep import Cell

Sized = TypeVar("Sized", bound="Experiment")

RUNS = Path("results/runs")

Set = Annotated[
    list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Override a value; may be repeated.")
]
Seeds = Annotated[
    str | None, typer.Option(help="How many seeds (10), which range (100-109) or which (3,5,8).")
]
Jobs = Annotated[int, typer.Option(min=0, help="Parallel processes; 0 is one per core.")]
Runs = Annotated[Path, typer.Option(help="Folder of finished runs; what is there is not run again.")]
On = Annotated[
    str,
    typer.Option(
        metavar="WHERE",
        help="Work on dask (here), tcp://HOST:PORT, slurm or kubernetes; see docs/scaling.md.",
    ),
]
ShardOption = Annotated[
    str | None,
    typer.Option("--shard", metavar="K/N", help="Only run part K of N; then repeat the command without it."),
]
Trust = Annotated[
    bool,
    typer.Option("--trust", help="Import and unpickle whatever code the files name. It can do anything."),
]
Quiet = Annotated[bool, typer.Option("--quiet", help="Print results and errors only.")]
Json = Annotated[bool, typer.Option("--json", help="Print JSON, for other programs.")]


class Preset(StrEnum):
    """Sizes of a study."""

    paper = "paper"
    smoke = "smoke"


PresetOption = Annotated[Preset, typer.Option(help="paper: in full; smoke: small, to see that all works.")]


def find_modules_here() -> None:
    """Let agents be imported from the folder that we stand in, after all that is installed.

    Worker processes take over our path. PYTHONPATH would put this folder before what is installed.
    """
    here = str(Path.cwd())
    if here not in sys.path:
        sys.path.append(here)


def resized(
    experiment: "Sized", study: str, preset: Preset, set_: list[str] | None = None, seeds: str | None = None
) -> "Sized":
    """An experiment or a search as the options want it; an agent that has no such name is refused here."""
    from crawler_bench.config.files import agent_spec, parse_assignments, smoke_changes
    from crawler_bench.config.schema import resize

    changes = smoke_changes(study, experiment.name) if preset is Preset.smoke else {}
    changes |= {} if seeds is None else {"seeds": seeds_of(seeds)}
    found = resize(experiment, changes | parse_assignments(set_ or []), "--set")
    agent_spec(found.run.agent)
    return found


def seeds_of(words: str) -> tuple[int, ...]:
    """The seeds that --seeds names.

    Raises:
        ConfigError: if it names none, or one of them twice.
    """
    from crawler_bench.config.errors import ConfigError
    from crawler_bench.config.schema import parse_seeds

    try:
        return tuple(parse_seeds(words))
    except ValueError as error:
        raise ConfigError(f"--seeds {words!r}: {error}") from None


def evaluation_overrides(set_: list[str] | None) -> dict[str, Any]:
    """What --set says of an evaluation, by dotted key; the section may be left out."""
    from crawler_bench.config.files import parse_assignments

    return {
        f"evaluation.{key.removeprefix('evaluation.')}": value
        for key, value in parse_assignments(set_ or []).items()
    }


def require_ours(folder: Path, command: str, witness: str) -> None:
    """Refuse, before anything is computed, a folder that results cannot or should not go into.

    Args:
        folder: where the results are to go; what is in there must be the command's own, which it replaces.
        command: the command that writes it.
        witness: a file that it always writes.
    """
    from crawler_bench.config.errors import ConfigError

    require_folder(folder)
    ours = all((folder / name).is_file() for name in (witness, "manifest.json"))
    if folder.is_dir() and any(folder.iterdir()) and not ours:
        raise ConfigError(
            f"{folder} is not empty and was not written by `crawler-bench {command}` (it has no {witness} "
            "with a manifest.json); choose another folder with --out"
        )


def require_folder(folder: Path, option: str = "--out") -> None:
    """Refuse, before anything is computed, what cannot be a folder that is written to.

    Raises:
        ConfigError: if there is a file in its place.
        PermissionError: if nothing can be written there.
    """
    from crawler_bench.config.errors import ConfigError

    there = next(place for place in (folder, *folder.absolute().parents) if place.exists())
    if not there.is_dir():
        raise ConfigError(f"{there} is a file; {option} needs a folder")
    if not os.access(there, os.W_OK):
        raise PermissionError(errno.EACCES, "cannot be written to", str(there))


def run_part(cells: "list[Cell]", shard: str, runs: Path, jobs: Any, quiet: bool) -> None:
    """Run one part of a study's cells, and say what comes next.

    Raises:
        RuntimeError: if runs failed.
    """
    from crawler_bench.cli.terminal.console import conclude, console
    from crawler_bench.runs.shards import parse_shard, run_shard

    outcomes = run_shard(cells, parse_shard(shard), runs, jobs=jobs, quiet=quiet)
    console.print(
        f"Part {shard} is done, {len(outcomes)} of {len(cells)} runs. When all parts are,", soft_wrap=True
    )
    console.print("the same command without --shard writes the results.")
    conclude("", False, [each.error for each in outcomes if each.error])
