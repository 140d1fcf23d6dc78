"""The commands about trained policies: evaluate, render."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from crawler_bench.cli import names
from crawler_bench.cli.options import Json, Quiet, Set, Trust, evaluation_overrides, require_folder
from crawler_bench.cli.terminal.console import (
    console,
    logger,
    phase,
    print_frame,
    print_json,
    records,
    starting,
)

if TYPE_CHECKING:
    from crawler_bench.runs.results import Measured

WHAT = "A run folder, as `train` prints it, a policy file, or a name of `list`: regularized."


def evaluate(
    run: Annotated[list[str], typer.Argument(help=WHAT, autocompletion=names.policies)],
    set_: Set = None,
    out: Annotated[
        Path | None, typer.Option(help="Also write runs.csv, evaluations.csv and cycles.csv here.")
    ] = None,
    json: Json = False,
    trust: Trust = False,
    quiet: Quiet = False,
) -> None:
    """Measure trained runs or shared policies: policy table, speed, cycle duration, speed against noise."""
    paths = [names.find_run(word) for word in run]
    overrides = evaluation_overrides(set_)
    if out is not None:
        require_folder(out)
    where = f", tables in {out}" if out is not None else ""
    with starting(f"measuring {len(paths)} trained {_policies(len(paths))}{where}", quiet):
        from crawler_bench.output.csv_files import write_csv
        from crawler_bench.runs.results import tabulate
    runs, evaluations, cycles = tabulate(_measure_all(paths, overrides, trust, quiet))
    noisy = evaluations.pivot_table(index="experiment", columns="noise", values="speed", sort=False)
    if json:
        print_json({"runs": records(runs), "speeds": _speeds(noisy)})
    else:
        shown = ["run", "policy", "speed", "speed_moving", "stall_share", "cycle_duration", "cycles"]
        print_frame(runs[shown])
        noisy.columns = [f"s = {noise:g}" for noise in noisy.columns]
        print_frame(noisy.rename_axis("speed (L/tau) at noise").reset_index())
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
        for name, frame in (("runs", runs), ("evaluations", evaluations), ("cycles", cycles)):
            write_csv(frame, out / f"{name}.csv")


def render(
    run: Annotated[str, typer.Argument(help=WHAT, autocompletion=names.policies)],
    set_: Set = None,
    out: Annotated[Path | None, typer.Option(help="Where to write; default results/rendered/RUN.")] = None,
    trust: Trust = False,
    quiet: Quiet = False,
) -> None:
    """Film the gait of a trained run (GIF, MP4) and draw its positions, strains and forces (PNG, SVG)."""
    path = names.find_run(run)
    overrides = evaluation_overrides(set_)
    folder = out or Path("results/rendered") / (path.stem if path.is_file() else path.resolve().name)
    require_folder(folder)
    with starting(f"filming {run}, pictures and films in {folder}", quiet):
        from crawler_bench.output import animation, kymographs, style
    (measured,) = _measure_all([path], overrides, trust, quiet)
    record = measured.evaluation.gait
    folder.mkdir(parents=True, exist_ok=True)
    logger(quiet)("drawing gait.png, gait.svg")
    style.save(kymographs.gait(record, measured.name), folder, "gait")
    for suffix in (".gif", ".mp4"):
        with phase(
            f"filming gait{suffix}", animation.count_pictures(record, suffix), "pictures", quiet
        ) as shown:
            animation.animate(record, folder / f"gait{suffix}", measured.name, shown)
    console.print(str(folder), markup=False, soft_wrap=True)


def _policies(number: int) -> str:
    return "policy" if number == 1 else "policies"


def _speeds(noisy: Any) -> dict[str, dict[str, float]]:
    """Speed by policy and amplitude of noise."""
    return {str(name): {f"{s:g}": float(v) for s, v in row.items()} for name, row in noisy.iterrows()}


def _measure_all(
    paths: Sequence[Path], overrides: dict[str, Any], trust: bool, quiet: bool
) -> "list[Measured]":
    return [
        _measure(path, overrides, f"measuring {number}/{len(paths)}", trust, quiet)
        for number, path in enumerate(paths, 1)
    ]


def _measure(path: Path, overrides: dict[str, Any], step: str, trust: bool, quiet: bool) -> "Measured":
    """Evaluate a run folder, which keeps its evaluations, or a policy file."""
    import pandas as pd

    from crawler_bench.config.schema import override
    from crawler_bench.runs import evaluation, store
    from crawler_bench.runs.policies import files as policy_files
    from crawler_bench.runs.results import Measured, label

    policy = None if path.is_dir() else policy_files.read_policy(path)
    config, seed = store.read_run(path) if policy is None else (policy.config, policy.seed)
    config = override(config, overrides, "--set")
    how, trusted = config.evaluation, [config.agent] if trust else []
    name = path.resolve().name if policy is None else path.stem
    learning = pd.read_csv(path / "learning.csv") if policy is None else pd.DataFrame()
    with phase(f"{step} ({name})", how.starts * len(how.noise), "crawls", quiet) as progress:
        if policy is None:
            found = evaluation.read_evaluation(evaluation.evaluate(path, how, progress, trusted=trusted))
        else:
            found = evaluation.measure(config, policy.seed, policy.table_of(how.mode), how, progress)
    return Measured(label(name, config, seed), name, found, learning)
