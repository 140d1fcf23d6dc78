"""The commands that compare agents: benchmark, reproduce-cell, tune."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from crawler_bench.cli.console import conclude, console, logger, print_frame
from crawler_bench.cli.options import (
    RUNS,
    Jobs,
    Preset,
    PresetOption,
    Quiet,
    Runs,
    Seeds,
    Set,
    require_ours,
    resized,
)

if TYPE_CHECKING:
    from crawler_bench.config.schema import Experiment

RESULTS = Path("results/benchmark")
SIDE_BY_SIDE = 8  # crawlers that an added on-policy agent of Stable-Baselines3 learns from


def benchmark(
    preset: PresetOption = Preset.paper,
    agent: Annotated[
        list[str] | None,
        typer.Option(help="Also compare this one: a registered agent, module:Class, or a YAML file."),
    ] = None,
    only: Annotated[
        list[str] | None, typer.Option(help="Only this entry of configs/benchmark; may be repeated.")
    ] = None,
    seeds: Seeds = None,
    set_: Set = None,
    out: Annotated[
        Path | None,
        typer.Option(
            help="Default results/benchmark, with any other option results/benchmark-smoke or -changed."
        ),
    ] = None,
    runs: Runs = RUNS,
    ceilings: Annotated[
        bool | None,
        typer.Option(
            help="Search for the best policies, too. Default: unless an option changes what is compared."
        ),
    ] = None,
    jobs: Jobs = 0,
    quiet: Quiet = False,
) -> None:
    """Train and compare agents: speed, cycle duration, robustness to noise; tables and figures.

    Interrupted, the same command goes on from the runs that were finished. With --runs FOLDER, what
    `crawler_bench.record` and Stable-Baselines3's Monitor left in that folder stands in the tables, too.
    """
    from crawler_bench.benchmark.benchmark import run_benchmark
    from crawler_bench.benchmark.ceilings.ceilings import FULL, SMOKE, find_ceilings
    from crawler_bench.benchmark.recorded import find as find_recorded
    from crawler_bench.benchmark.recorded import unknown, with_recorded
    from crawler_bench.benchmark.results import overview, write_benchmark

    entries = _entries(preset, only or [], agent or [], seeds, set_ or [])
    changed = "-changed" if seeds or set_ or agent or only else "" if preset is Preset.paper else "-smoke"
    folder = out or RESULTS.with_name(RESULTS.name + changed)
    require_ours(folder, "benchmark", "summary.csv")
    known = None
    if (not changed or changed == "-smoke") if ceilings is None else ceilings:
        effort = SMOKE if preset is Preset.smoke else FULL
        levels = sorted({run.environment.regularization for entry in entries for run, _ in entry.runs()})
        known = find_ceilings(entries[0].run, levels, runs, effort, jobs=jobs, say=logger(quiet))
    found = run_benchmark(entries, runs, jobs=jobs, quiet=quiet)
    others = find_recorded(runs, entries[0].run) if runs != RUNS else []
    for missing in filter(None, map(unknown, others)):
        logger(quiet)(missing)
    found = with_recorded(found, others, entries[0].run)
    facts = write_benchmark(found, entries, folder, say=logger(quiet), ceilings=known, others=others)
    print_frame(overview(folder))
    console.print(facts, soft_wrap=True)
    written = f"{folder}: tables, figures, runs.csv, policies"
    conclude(written, preset is Preset.smoke, [each.error for each in found.failures])


def certify(
    results: Annotated[Path, typer.Option(help="Folder that `benchmark` wrote.")] = RESULTS,
    jobs: Jobs = 0,
) -> None:
    """Certify again that no change of one or two entries improves the best known tables."""
    from crawler_bench.benchmark.ceilings.ceilings import certificates
    from crawler_bench.config.files import load_experiment
    from crawler_bench.output.csv_files import read_csv

    entries = sorted((results / "entries").glob("*.yaml"))
    if not entries or not (results / "ceilings.csv").is_file():
        raise ValueError(
            f"{results} holds no ceilings.csv with entries; `crawler-bench benchmark` writes both"
        )
    made = certificates(read_csv(results / "ceilings.csv"), load_experiment(entries[0]).run, jobs=jobs)
    print_frame(made)
    if not made["holds"].all():
        raise RuntimeError(f"{(~made['holds']).sum()} of {len(made)} tables can be improved")
    console.print(f"{len(made)} tables: no change of one or two entries improves any of them")


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
    preset: PresetOption = Preset.paper,
    set_: Set = None,
    out: Annotated[
        Path, typer.Option(help="Folder for the trials (CSV) and the entry that was found (YAML).")
    ] = Path("results/tuning"),
    runs: Runs = RUNS,
    jobs: Jobs = 0,
    quiet: Quiet = False,
) -> None:
    """Search an agent's settings with Optuna; interrupted, the same command goes on."""
    from crawler_bench.benchmark.entries import tuned_entry
    from crawler_bench.config.files import config_folder, load_tuning
    from crawler_bench.output.csv_files import write_csv
    from crawler_bench.runs.tuning import tune as search

    path = Path(agent) if agent.endswith((".yaml", ".yml")) else config_folder() / "tuning" / f"{agent}.yaml"
    tuning = resized(load_tuning(path), "tuning", preset, set_)
    best, trials, importance = search(tuning, runs, jobs=jobs, quiet=quiet, say=logger(quiet))
    out.mkdir(parents=True, exist_ok=True)
    write_csv(trials, out / f"{tuning.name}.csv")
    write_csv(importance, out / f"{tuning.name}-importance.csv")
    (out / f"{tuning.name}-tuned.yaml").write_text(tuned_entry(tuning, best))
    print_frame(importance)
    console.print(f"{out / tuning.name}-tuned.yaml, an entry: {best.settings}", markup=False, soft_wrap=True)


def _entries(
    preset: Preset, only: list[str], added: list[str], seeds: str | None, set_: list[str]
) -> "list[Experiment]":
    """What is compared: configs/benchmark, or part of it, and what the user adds; sized by the preset."""
    from crawler_bench.benchmark.benchmark import require_comparable
    from crawler_bench.config.files import config_folder, load_experiment
    from crawler_bench.config.schema import ConfigError, nearest

    known = {path.stem: path for path in sorted((config_folder() / "benchmark").glob("*.yaml"))}
    for name in only:
        if name not in known:
            raise ConfigError(f"--only {name}: no such entry{nearest(name, list(known))}")
    template = load_experiment(known["qlearning"])
    budget = {"decisions": template.run.decisions, "seeds": template.seeds, "grid": template.grid}
    entries = [load_experiment(path) for name, path in known.items() if not only or name in only]
    entries += [
        load_experiment(Path(name), budget) if name.endswith((".yaml", ".yml")) else _added(name, template)
        for name in added
    ]
    sized = [resized(entry, "benchmark", preset, set_, seeds) for entry in entries]
    require_comparable(sized)
    return sized


def _added(name: str, template: "Experiment") -> "Experiment":
    """An entry for an agent that has none: the budget of all, its own defaults."""
    from crawler_bench.runs.agent import agent_class

    on_policy = any(base.__name__ == "OnPolicyAlgorithm" for base in agent_class(name).__mro__)
    crawlers = SIDE_BY_SIDE if on_policy else 1
    run = template.run.model_copy(update={"agent": name, "settings": {}, "crawlers": crawlers})
    return template.model_copy(update={"name": name.rpartition(":")[2].lower(), "run": run})
