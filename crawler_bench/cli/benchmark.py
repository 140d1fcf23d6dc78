"""The commands that compare agents: benchmark, reproduce-cell, tune."""

import time
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

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
    Trust,
    require_folder,
    require_ours,
    resized,
    run_part,
)
from crawler_bench.cli.terminal.console import conclude, console, logger, phase, print_frame, starting

if TYPE_CHECKING:
    from crawler_bench.config.schema import Experiment

RESULTS = Path("results/benchmark")
SIDE_BY_SIDE = 8  # crawlers that an added on-policy agent of Stable-Baselines3 learns from


def benchmark(
    preset: PresetOption = Preset.paper,
    agent: Annotated[
        list[str] | None,
        typer.Option(
            help="Also compare this one: a registered agent, module:Class, or a YAML file.",
            autocompletion=names.agents,
        ),
    ] = None,
    only: Annotated[
        list[str] | None,
        typer.Option(
            help="Only this entry of configs/benchmark; may be repeated.", autocompletion=names.entries
        ),
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
    on: On = "",
    shard: ShardOption = None,
    trust: Trust = False,
    quiet: Quiet = False,
) -> None:
    """Train and compare agents: speed, cycle duration, robustness to noise; tables and figures.

    Interrupted, the same command goes on from the runs that were finished. With --runs FOLDER, what
    `crawler_bench.record` and Stable-Baselines3's Monitor left in that folder stands in the tables, too.
    """
    _require_names(only or [], agent or [])
    is_changed = seeds is not None or set_ or agent or only
    changed = "-changed" if is_changed else "" if preset is Preset.paper else "-smoke"
    folder = out or RESULTS.with_name(RESULTS.name + changed)
    require_ours(folder, "benchmark", "summary.csv")
    with starting(f"comparing agents, results in {folder}", quiet):
        from crawler_bench.benchmark.benchmark import all_in_mode, run_benchmark
        from crawler_bench.benchmark.ceilings.ceilings import FULL, SMOKE, find_ceilings
        from crawler_bench.benchmark.keys import MODES
        from crawler_bench.benchmark.recorded import find as find_recorded
        from crawler_bench.benchmark.recorded import unknown, with_recorded
        from crawler_bench.benchmark.results import overview, write_benchmark
        from crawler_bench.runs.machines.engines import Workers
        from crawler_bench.runs.sweep import cells_of

        entries = _entries(preset, only or [], agent or [], seeds, set_ or [], trust)
    workers = Workers(jobs, on)
    if shard:
        cells = cells_of(each for mode in MODES for each in all_in_mode(entries, mode))
        return run_part(cells, shard, runs, workers, quiet)
    known = None
    if (not is_changed) if ceilings is None else ceilings:
        effort = SMOKE if preset is Preset.smoke else FULL
        levels = sorted({run.environment.regularization for entry in entries for run, _ in entry.runs()})
        known = find_ceilings(
            entries[0].run, levels, runs, effort, jobs=workers.processes, say=logger(quiet),
            phase=partial(phase, quiet=quiet),
        )  # fmt: skip
    found = run_benchmark(entries, runs, jobs=workers, quiet=quiet)
    others = find_recorded(runs, entries[0].run) if runs != RUNS else []
    if others:
        learners = ", ".join(dict.fromkeys(each.agent for each in others))
        logger(quiet)(f"measuring what {learners} did, as recorded in {runs}")
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
    from crawler_bench.config.errors import ConfigError

    entries = sorted((results / "entries").glob("*.yaml"))
    if not entries or not (results / "ceilings.csv").is_file():
        raise ConfigError(
            f"{results} holds no ceilings.csv with entries; `crawler-bench benchmark` writes both"
        )
    with starting(f"certifying the best tables of {results}, several minutes"):
        from crawler_bench.benchmark.ceilings.ceilings import certificates
        from crawler_bench.config.files import load_experiment
        from crawler_bench.output.csv_files import read_csv
    made = certificates(
        read_csv(results / "ceilings.csv"), load_experiment(entries[0]).run, jobs=jobs, phase=phase
    )
    print_frame(made)
    if not made["holds"].all():
        raise RuntimeError(f"{(~made['holds']).sum()} of {len(made)} tables can be improved")
    console.print(f"{len(made)} tables: no change of one or two entries improves any of them")


def reproduce_cell(
    hash_: Annotated[str, typer.Argument(metavar="HASH", help="Of a table cell, or of a run in runs.csv.")],
    results: Annotated[Path, typer.Option(help="Folder that `benchmark` wrote.")] = RESULTS,
    jobs: Jobs = 0,
    trust: Trust = False,
    quiet: Quiet = False,
) -> None:
    """Re-run one cell of the tables from scratch and say: equal, within its interval, or different."""
    with starting(f"re-running the cell {hash_} of {results} from scratch", quiet):
        from crawler_bench.benchmark.reproduce_cell import reproduce
    made = reproduce(results, hash_, jobs=jobs, quiet=quiet, trust=trust)
    print_frame(made)
    counts = made["verdict"].value_counts()
    console.print(", ".join(f"{counts[verdict]} {verdict}" for verdict in counts.index))
    if "different" in counts:
        raise RuntimeError(f"{counts['different']} of {len(made)} numbers came out different")


def tune(
    agent: Annotated[
        str,
        typer.Argument(
            help="Name in configs/tuning, or a YAML file like those.", autocompletion=names.searches
        ),
    ],
    preset: PresetOption = Preset.paper,
    set_: Set = None,
    out: Annotated[
        Path | None,
        typer.Option(
            help="Gets a folder named like the search, with the trials (CSV) and the entry that was found "
            "(YAML); default results/tuning, with another preset or --set results/tuning-smoke or -changed."
        ),
    ] = None,
    runs: Runs = RUNS,
    jobs: Jobs = 0,
    on: On = "",
    trust: Trust = False,
    quiet: Quiet = False,
) -> None:
    """Search an agent's settings with Optuna; interrupted, the same command goes on."""
    from crawler_bench.config.files import find_config, load_tuning
    from crawler_bench.runs.untrusted import agents_of, require_trust

    path = find_config(f"tuning/{agent}" if agent in names.searches() else agent)
    tuning = load_tuning(path)
    if not trust:
        require_trust(agents_of(tuning), path)
    tuning = resized(tuning, "tuning", preset, set_)
    changed = "-changed" if set_ else "" if preset is Preset.paper else "-smoke"
    out = out or Path(f"results/tuning{changed}")
    require_folder(out)
    with starting(f"tuning {tuning.run.agent} in {tuning.trials} trials, results in {out}", quiet):
        from crawler_bench.benchmark.entries import write_search
        from crawler_bench.runs.machines.engines import Workers
        from crawler_bench.runs.tuning import tune as search
    started = time.monotonic()
    best, trials, importance = search(tuning, runs, jobs=Workers(jobs, on), quiet=quiet, say=logger(quiet))
    entry = write_search(tuning, best, trials, importance, out / tuning.name, started)
    print_frame(importance)
    console.print(f"{entry}, an entry: {best.settings}", markup=False, soft_wrap=True)
    conclude("", preset is Preset.smoke, [])


def _require_names(only: list[str], added: list[str]) -> None:
    """Refuse what is misspelt, before anything heavy is imported."""
    from crawler_bench.config.errors import ConfigError, nearest
    from crawler_bench.config.files import agent_spec, find_config

    for name in only:
        if name not in names.entries():
            raise ConfigError(f"--only {name}: no such entry{nearest(name, names.entries())}")
    for name in added:
        if name.endswith((".yaml", ".yml")):
            find_config(name)
        else:
            agent_spec(name)


def _entries(
    preset: Preset, only: list[str], added: list[str], seeds: str | None, set_: list[str], trust: bool
) -> "list[Experiment]":
    """What is compared: configs/benchmark, or part of it, and what the user adds; sized by the preset."""
    from crawler_bench.benchmark.benchmark import require_comparable
    from crawler_bench.config.files import config_folder, load_experiment

    known = {path.stem: path for path in sorted((config_folder() / "benchmark").glob("*.yaml"))}
    template = load_experiment(known["qlearning"])
    budget = {"decisions": template.run.decisions, "seeds": template.seeds, "grid": template.grid}
    entries = [load_experiment(path) for name, path in known.items() if not only or name in only]
    entries += [
        _read(Path(name), budget, trust) if name.endswith((".yaml", ".yml")) else _added(name, template)
        for name in added
    ]
    sized = [resized(entry, "benchmark", preset, set_, seeds) for entry in entries]
    require_comparable(sized)
    return sized


def _read(path: Path, budget: dict[str, Any], trust: bool) -> "Experiment":
    """An entry from somebody's file."""
    from crawler_bench.config.files import load_experiment
    from crawler_bench.runs.untrusted import agents_of, require_trust

    entry = load_experiment(path, budget)
    if not trust:
        require_trust(agents_of(entry), path)
    return entry


def _added(name: str, template: "Experiment") -> "Experiment":
    """An entry for an agent that has none: the budget of all, its own defaults."""
    from crawler_bench.runs.agent import agent_class

    on_policy = any(base.__name__ == "OnPolicyAlgorithm" for base in agent_class(name).__mro__)
    crawlers = SIDE_BY_SIDE if on_policy else 1
    run = template.run.model_copy(update={"agent": name, "settings": {}, "crawlers": crawlers})
    return template.model_copy(update={"name": name.rpartition(":")[2].lower(), "run": run})
