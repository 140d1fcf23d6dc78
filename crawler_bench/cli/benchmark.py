"""The commands that compare agents: benchmark, reproduce-cell, tune."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from crawler_bench.cli.console import console, print_frame, teller
from crawler_bench.cli.options import (
    RUNS,
    Jobs,
    Preset,
    Quiet,
    Runs,
    Seeds,
    Set,
    agent_spec,
    agents_package,
    require_ours,
)

if TYPE_CHECKING:
    from crawler_bench.config.schema import Experiment

RESULTS = Path("results/benchmark")
SIDE_BY_SIDE = 8  # crawlers that an added agent of Stable-Baselines3 learns from


def benchmark(
    preset: Annotated[
        Preset, typer.Option(help="full: as committed; smoke: small, to see that all works.")
    ] = Preset.full,
    agent: Annotated[
        list[str] | None,
        typer.Option(help="Also compare this one: a registered agent, module:Class, or a YAML file."),
    ] = None,
    only: Annotated[
        list[str] | None, typer.Option(help="Of configs/bench, only this entry; may be repeated.")
    ] = None,
    seeds: Seeds = None,
    set_: Set = None,
    out: Annotated[
        Path | None,
        typer.Option(
            help="Default results/benchmark, with any other option results/benchmark-PRESET or -changed."
        ),
    ] = None,
    runs: Runs = RUNS,
    jobs: Jobs = 0,
    quiet: Quiet = False,
) -> None:
    """Train and compare agents: speed, cycle duration, robustness to noise; tables and figures.

    Interrupted, the same command goes on from the runs that were finished.
    """
    from crawler_bench.benchmark.benchmark import run_benchmark
    from crawler_bench.benchmark.results import overview, write_benchmark

    entries = _entries(preset, only or [], agent or [], seeds, set_ or [])
    changed = "-changed" if seeds or set_ or agent or only else "" if preset is Preset.full else "-smoke"
    folder = out or RESULTS.with_name(RESULTS.name + changed)
    require_ours(folder, "benchmark", "summary.csv")
    found = run_benchmark(entries, runs, jobs=jobs, quiet=quiet)
    say = teller(quiet)
    facts = write_benchmark(found, entries, folder, say=say)
    print_frame(overview(folder))
    console.print(f"{facts}\nWritten to {folder}: tables, figures, runs.csv, policies.", soft_wrap=True)
    if preset is Preset.smoke:
        console.print("This was the smoke preset: too small for its numbers to mean anything.")
    if found.failures:
        raise RuntimeError(
            f"{len(found.failures)} runs failed (see {folder / 'failures.csv'}); "
            "the same command tries them again"
        )


def reproduce_cell(
    hash_: Annotated[str, typer.Argument(metavar="HASH", help="Of a table cell, or of a run in runs.csv.")],
    results: Annotated[Path, typer.Option(help="Folder that `benchmark` wrote.")] = RESULTS,
    jobs: Jobs = 0,
    quiet: Quiet = False,
) -> None:
    """Re-run one cell of the tables from scratch and say: equal, within its interval, or different."""
    from crawler_bench.benchmark.reproduce_cell import reproduce

    made = reproduce(results, hash_, jobs=jobs, quiet=quiet)
    print_frame(made)
    counts = made["verdict"].value_counts()
    console.print(", ".join(f"{counts[verdict]} {verdict}" for verdict in counts.index))
    if "different" in counts:
        raise RuntimeError(f"{counts['different']} of {len(made)} numbers came out different")


def tune(
    agent: Annotated[str, typer.Argument(help="Name in configs/tuning, or a YAML file like those.")],
    set_: Set = None,
    out: Annotated[
        Path, typer.Option(help="Folder for the trials (CSV) and the best settings (YAML).")
    ] = Path("results/tuning"),
    runs: Runs = RUNS,
    jobs: Jobs = 0,
    quiet: Quiet = False,
) -> None:
    """Search an agent's settings with Optuna; interrupted, the same command goes on."""
    from crawler_bench.config.files import config_folder, load_tuning, parse_assignments
    from crawler_bench.config.schema import to_yaml
    from crawler_bench.output.csv_files import write_csv
    from crawler_bench.runs.tuning import tune as search

    path = Path(agent) if agent.endswith((".yaml", ".yml")) else config_folder() / "tuning" / f"{agent}.yaml"
    tuning = load_tuning(path, parse_assignments(set_ or []))
    run = tuning.run.model_copy(update={"agent": agent_spec(tuning.run.agent)})
    tuning = tuning.model_copy(update={"run": run})
    best, trials = search(tuning, runs, jobs=jobs, quiet=quiet, say=teller(quiet))
    out.mkdir(parents=True, exist_ok=True)
    write_csv(trials, out / f"{tuning.name}.csv")
    (out / f"{tuning.name}.yaml").write_text(to_yaml(best))
    console.print(f"{out / tuning.name}.csv, .yaml: {best.settings}", markup=False, soft_wrap=True)


def _entries(
    preset: Preset, only: list[str], added: list[str], seeds: str | None, set_: list[str]
) -> "list[Experiment]":
    """What is compared: configs/bench, or part of it, and what the user adds; sized by the preset."""
    from crawler_bench.benchmark.benchmark import require_comparable
    from crawler_bench.config.files import (
        config_folder,
        load_entry,
        load_experiment,
        load_overrides,
        parse_assignments,
    )
    from crawler_bench.config.schema import ConfigError, nearest, parse_seeds

    known = {path.stem: path for path in sorted((config_folder() / "bench").glob("*.yaml"))}
    for name in only:
        if name not in known:
            raise ConfigError(f"--only {name}: no such entry{nearest(name, list(known))}")
    template = load_experiment(known["qlearning"])
    entries = [load_experiment(path) for name, path in known.items() if not only or name in only]
    entries += [
        load_entry(Path(name), template) if name.endswith((".yaml", ".yml")) else _added(name, template)
        for name in added
    ]
    small = load_overrides(config_folder() / "benchmark-smoke.yaml") if preset is Preset.smoke else {}
    small_seeds = small.pop("seeds", None)
    chosen = seeds or small_seeds
    own_seeds = parse_seeds(chosen) if chosen is not None else None
    sized = [_sized(entry, own_seeds, small | parse_assignments(set_)) for entry in entries]
    require_comparable(sized)
    return sized


def _sized(entry: "Experiment", seeds: tuple[int, ...] | None, overrides: dict[str, Any]) -> "Experiment":
    """An entry with other seeds and values; a value that its grid varies is no longer varied."""
    from crawler_bench.config.schema import override

    # What learns nothing has no number of decisions to change.
    mine = {key: value for key, value in overrides.items() if entry.run.decisions or key != "decisions"}
    grid = dict(entry.grid)
    for varied in entry.grid:
        for key in (varied, varied.rpartition(".")[2]):
            if key in mine:
                value = mine.pop(key)
                grid[varied] = tuple(value) if isinstance(value, list) else (value,)
    run = override(entry.run, {"agent": agent_spec(entry.run.agent)} | mine, entry.name)
    update: dict[str, Any] = {"run": run, "grid": grid} | ({"seeds": seeds} if seeds else {})
    return entry.model_copy(update=update)


def _added(name: str, template: "Experiment") -> "Experiment":
    """An entry for an agent that has none: the budget of all, its own defaults."""
    spec = agent_spec(name)
    kinds = (base.__module__ for base in agents_package().agent_class(spec).__mro__)
    deep = any(kind.startswith("stable_baselines3") for kind in kinds)
    update: dict[str, Any] = {"agent": spec, "settings": {}, "crawlers": SIDE_BY_SIDE if deep else 1}
    short = name if ":" not in name else spec.rpartition(":")[2].lower()
    return template.model_copy(update={"name": short, "run": template.run.model_copy(update=update)})
