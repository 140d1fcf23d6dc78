"""The command `crawler-bench readings`."""

import tempfile
import time
from collections.abc import Callable
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from crawler_bench.console import console, print_frame, teller

if TYPE_CHECKING:
    from crawler_bench.config import RunConfig

Bases = Callable[[], "dict[str, RunConfig]"]


class Preset(StrEnum):
    """Sizes of the study."""

    full = "full"
    smoke = "smoke"


def add_to(app: typer.Typer, bases: Bases) -> None:
    """Add the command to the command line.

    Args:
        app: the command line.
        bases: the run of the default reading for each experiment, agents resolved.
    """

    @app.command()
    def readings(
        preset: Annotated[
            Preset, typer.Option(help="full: under an hour; smoke: small, to see that all works.")
        ] = Preset.full,
        only: Annotated[
            list[str] | None, typer.Option(help="Only run and print this reading; may be repeated.")
        ] = None,
        check: Annotated[
            int, typer.Option(min=0, help="Run so many rows of the table again, from nothing, and compare.")
        ] = 0,
        out: Annotated[
            Path | None, typer.Option(help="Where to write; default results/readings or readings-smoke.")
        ] = None,
        runs: Annotated[
            Path, typer.Option(help="Folder of finished runs; what is there is not run again.")
        ] = Path("results/runs"),
        jobs: Annotated[int, typer.Option(min=0, help="Parallel processes; 0 is one a core.")] = 0,
        quiet: Annotated[bool, typer.Option("--quiet", help="Print results and errors only.")] = False,
    ) -> None:
        """Run every reading of what the paper leaves open against every claim: which tells the paper's story?

        Interrupted, the same command goes on from the runs that were finished.
        """
        smoke = preset is Preset.smoke
        folder = out or Path("results") / ("readings-smoke" if smoke else "readings")
        _study(bases(), folder, runs, smoke=smoke, only=only, check=check, jobs=jobs, quiet=quiet)


def _study(
    bases: "dict[str, RunConfig]",
    folder: Path,
    runs: Path,
    *,
    smoke: bool,
    only: list[str] | None,
    check: int,
    jobs: int,
    quiet: bool,
) -> None:
    from crawler_bench.bench import readings_presets as presets
    from crawler_bench.bench.readings import find_reading, readings
    from crawler_bench.bench.readings_decision import conduct
    from crawler_bench.bench.readings_frames import summarize
    from crawler_bench.bench.readings_results import check as check_rows
    from crawler_bench.bench.readings_results import read_readings, require_ours, write
    from crawler_bench.bench.readings_study import Laboratory

    started = time.time()
    size = presets.SMOKE if smoke else presets.FULL
    sized = {name: size.apply(run) for name, run in bases.items()}
    if only:
        known = {each.name: each for each in (*read_readings(folder), *readings())}
        chosen = [find_reading(name, tuple(known.values())) for name in only]
        scored = Laboratory(sized, runs, jobs, quiet).run(chosen, size.seeds)
        print_frame(summarize(scored)[presets.SHOWN])
        for each in scored:
            print_frame(each.score.claims[["claim", "paper", "ours", "low", "high", "n", "distance"]])
        return
    if check:
        with tempfile.TemporaryDirectory() as fresh:
            again = check_rows(Laboratory(sized, Path(fresh), jobs, quiet), folder, size.seeds, check)
        print_frame(again)
        if not again["same"].all():
            raise RuntimeError("not every row gives the score that the table says")
        return
    require_ours(folder)
    study = conduct(Laboratory(sized, runs, jobs, quiet), size.readings(), size)
    table = write(study, folder, started, teller(quiet))
    print_frame(table[presets.SHOWN].head(20))
    print_frame(study.confirmation())
    failed = [f"{each.reading.name}: {error}" for each in study.scored for error in each.errors]
    console.print(f"Written to {folder}: readings.md, figures, tables.", soft_wrap=True)
    if smoke:
        console.print("This was the smoke preset: too small for its scores to mean anything.")
    if failed:
        raise RuntimeError(f"{len(failed)} runs failed; the first: {failed[0]}")
