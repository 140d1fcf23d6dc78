"""The command that reproduces the paper."""

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from crawler_bench.cli import names
from crawler_bench.cli.options import (
    RUNS,
    Jobs,
    On,
    Preset,
    PresetOption,
    Quiet,
    Runs,
    Seeds,
    Set,
    ShardOption,
    require_ours,
    resized,
    run_part,
)
from crawler_bench.cli.terminal.console import conclude, logger, print_claims, starting

if TYPE_CHECKING:
    from crawler_bench.config.schema import Experiment


def reproduce(
    preset: PresetOption = Preset.paper,
    claim: Annotated[
        list[str] | None,
        typer.Option(help="Judge and print only this claim.", autocompletion=names.claims),
    ] = None,
    seeds: Seeds = None,
    set_: Set = None,
    out: Annotated[
        Path | None,
        typer.Option(
            help="Where to write; default results/PRESET, or results/changed with --seeds or --set."
        ),
    ] = None,
    runs: Runs = RUNS,
    jobs: Jobs = 0,
    on: On = "",
    shard: ShardOption = None,
    quiet: Quiet = False,
) -> None:
    """Reproduce the paper: train both gaits, judge every claim, draw Figs 1-3 and S1, film both gaits.

    Interrupted, the same command goes on from the runs that were finished.
    """
    from crawler_bench.paper.claims import CLAIMS, EXPERIMENTS, find_claim

    claims = tuple(find_claim(name) for name in claim) if claim else CLAIMS
    # Other seeds or settings are another experiment: they do not replace the committed results.
    folder = out or Path("results") / ("changed" if seeds is not None or set_ else preset)
    if not claim:
        require_ours(folder, "reproduce", "claims.csv")
    needed = {name for each in claims for name in each.experiments}
    experiments = [
        _experiment(name, preset, set_, seeds) for name in EXPERIMENTS if name in needed or not claim
    ]
    with starting(f"reproducing the paper{'' if claim else f', results in {folder}'}", quiet):
        from crawler_bench.paper import reproduction
        from crawler_bench.runs.machines.engines import Workers
        from crawler_bench.runs.sweep import cells_of
    workers = Workers(jobs, on)
    if shard:
        return run_part(cells_of(experiments), shard, runs, workers, quiet)
    found = reproduction.reproduce(experiments, runs, jobs=workers, quiet=quiet)
    options = "".join([
        f" --preset {preset.value}" if preset is not Preset.paper else "",
        f" --seeds {seeds}" if seeds else "",
        *(f" --set {shlex.quote(word)}" for word in set_ or []),
    ])  # fmt: skip
    if claim:
        frame = found.claims(claims, options)
    else:
        frame = reproduction.write_results(found, folder, options=options, say=logger(quiet))
    print_claims(frame)
    written = "" if claim else f"{folder}: claims.md, figures, animations, runs.csv, policies"
    conclude(written, preset is Preset.smoke, [each.error for each in found.failures])


def _experiment(name: str, preset: Preset, set_: list[str] | None, seeds: str | None) -> "Experiment":
    from crawler_bench.config.files import config_folder, load_experiment

    experiment = load_experiment(config_folder() / "paper" / f"{name}.yaml")
    # An experiment with a grid keeps its few seeds: it is about the grid.
    return resized(experiment, "paper", preset, set_, None if experiment.grid else seeds)
