"""The command that runs every reading of the paper."""

import tempfile
import time
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from crawler_bench.cli.options import (
    RUNS,
    Jobs,
    On,
    Preset,
    PresetOption,
    Quiet,
    Runs,
    ShardOption,
    require_folder,
    require_ours,
    run_part,
)
from crawler_bench.cli.terminal.console import conclude, console, logger, phase, print_frame, starting

if TYPE_CHECKING:
    from crawler_bench.readings.laboratory import Laboratory
    from crawler_bench.readings.sizes import Size
    from crawler_bench.runs.machines.engines import Workers


def readings(
    preset: PresetOption = Preset.paper,
    only: Annotated[
        list[str] | None, typer.Option(help="Only run and print this reading; may be repeated.")
    ] = None,
    check: Annotated[
        int, typer.Option(min=0, help="Re-run this many rows of the table from scratch, and compare.")
    ] = 0,
    search: Annotated[
        bool, typer.Option("--search", help="Search the joint space instead, in three stages.")
    ] = False,
    rounds: Annotated[
        tuple[int, int, int] | None,
        typer.Option(help="Trials of the search, how many of them again, how many of those a third time."),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(help="Where to write; default results/readings, or results/search; with -smoke."),
    ] = None,
    runs: Runs = RUNS,
    jobs: Jobs = 0,
    on: On = "",
    shard: ShardOption = None,
    quiet: Quiet = False,
) -> None:
    """Run every reading of what the paper leaves open against every claim: which tells the paper's story?

    Interrupted, the same command goes on from the runs that were finished.
    """
    name = ("search" if search else "readings") + ("-smoke" if preset is Preset.smoke else "")
    folder = out or Path("results") / name
    if search and (on or shard):
        raise ValueError(
            "--search is shared otherwise: repeat the command on each machine, with the same --runs"
        )
    if search:
        require_ours(folder, "search", "finals.csv")
    elif check or only:
        require_folder(folder)
    else:
        require_ours(folder, "readings", "readings.csv")
    with starting(f"running readings of the paper{'' if check or only else f', results in {folder}'}", quiet):
        from crawler_bench.readings.sizes import FULL, smoke
        from crawler_bench.runs.machines.engines import Workers
        from crawler_bench.runs.sweep import cells_of
    workers = Workers(jobs, on)
    size = smoke() if preset is Preset.smoke else FULL
    if search:
        if rounds:
            size = replace(size, trials=rounds[0], again=rounds[1], finals=rounds[2])
        _search(_laboratory(size, runs, workers, quiet), size, runs / name, folder)
    elif shard:
        laboratory = _laboratory(size, runs, workers, quiet)
        cells = cells_of(laboratory.experiments(size.readings(), size.seeds))
        run_part(cells, shard, runs, workers, quiet)
    elif check:
        with tempfile.TemporaryDirectory() as fresh:
            _check(_laboratory(size, Path(fresh), workers, quiet), size, folder, check)
    elif only:
        _print_only(_laboratory(size, runs, workers, quiet), size, folder, only)
    else:
        _study(_laboratory(size, runs, workers, quiet), size, folder, preset)


def _laboratory(size: "Size", runs: Path, jobs: "Workers", quiet: bool) -> "Laboratory":
    from crawler_bench.config.files import config_folder, load_experiment
    from crawler_bench.readings.laboratory import EXPERIMENTS, Laboratory

    paths = {name: config_folder() / "paper" / f"{name}.yaml" for name in EXPERIMENTS}
    bases = {name: size.apply(load_experiment(path).run) for name, path in paths.items()}
    return Laboratory(bases, runs, jobs, quiet)


def _search(laboratory: "Laboratory", size: "Size", scratch: Path, folder: Path) -> None:
    from crawler_bench.readings.search.conduct import search
    from crawler_bench.runs.machines.engines import as_workers

    finals = search(
        laboratory.bases, size, scratch=scratch, folder=folder, jobs=as_workers(laboratory.jobs).jobs,
        say=logger(laboratory.quiet), phase=partial(phase, quiet=laboratory.quiet),
    )  # fmt: skip
    shown = ["reading", "failures", "free", "score", "on_diagonal", "random_ratio", "kept", "speed"]
    print_frame(finals[shown])
    console.print(f"Written to {folder}: trials, the best again, finals, figures.", soft_wrap=True)


def _check(laboratory: "Laboratory", size: "Size", folder: Path, number: int) -> None:
    from crawler_bench.readings.results import check

    again = check(laboratory, folder, size.seeds, number)
    print_frame(again)
    if not again["same"].all():
        raise RuntimeError("not every row gives the score that the table says")


def _print_only(laboratory: "Laboratory", size: "Size", folder: Path, names: list[str]) -> None:
    from crawler_bench.readings.catalogue import find_reading, readings
    from crawler_bench.readings.frames import SHOWN, summarize
    from crawler_bench.readings.results import read_readings

    known = {each.name: each for each in (*read_readings(folder), *readings())}
    scored = laboratory.run([find_reading(name, tuple(known.values())) for name in names], size.seeds)
    print_frame(summarize(scored)[SHOWN])
    for each in scored:
        console.print(each.reading.name, markup=False)
        print_frame(each.score.claims[["claim", "paper", "ours", "low", "high", "n", "distance"]])


def _study(laboratory: "Laboratory", size: "Size", folder: Path, preset: Preset) -> None:
    from crawler_bench.readings.frames import SHOWN
    from crawler_bench.readings.results import write
    from crawler_bench.readings.study import conduct

    started = time.monotonic()
    study = conduct(laboratory, size.readings(), size)
    print_frame(write(study, folder, started, logger(laboratory.quiet))[SHOWN].head(20))
    print_frame(study.confirmation())
    failed = [f"{each.reading.name}: {error}" for each in study.scored for error in each.errors]
    conclude(f"{folder}: readings.md, figures, tables", preset is Preset.smoke, failed)
