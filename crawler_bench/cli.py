"""The command line: `crawler-bench`. Heavy imports wait until a command needs them."""

import errno
import os
import shlex
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from crawler_bench.commands import readings
from crawler_bench.console import console, notes, one_line_errors, print_claims, print_frame, teller

if TYPE_CHECKING:
    from crawler_bench.config import Experiment, RunConfig

app = typer.Typer(
    name="crawler-bench",
    help="How a soft-bodied crawler learns to coordinate itself: reproduce the paper, train agents.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    add_completion=False,
)
RUNS = Path("results/runs")

Set = Annotated[
    list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Override a value; may be repeated.")
]
Seeds = Annotated[
    str | None, typer.Option(help="How many seeds (10), which range (100-109) or which (3,5,8).")
]
Jobs = Annotated[int, typer.Option(min=0, help="Parallel processes; 0 is one a core.")]
Runs = Annotated[Path, typer.Option(help="Folder of finished runs; what is there is not run again.")]
Quiet = Annotated[bool, typer.Option("--quiet", help="Print results and errors only.")]


class Preset(StrEnum):
    """Sizes of an experiment."""

    paper = "paper"
    smoke = "smoke"


@app.command()
def reproduce(
    preset: Annotated[
        Preset, typer.Option(help="paper: in full; smoke: small, to see that all works.")
    ] = Preset.paper,
    claim: Annotated[list[str] | None, typer.Option(help="Only re-make this claim, and print it.")] = None,
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
    quiet: Quiet = False,
) -> None:
    """Reproduce the paper: train both gaits, judge every claim, draw Figs 1-3 and S1, film both gaits.

    Interrupted, the same command goes on from the runs that were finished.
    """
    from crawler_bench.bench import reproduction
    from crawler_bench.bench.paper_claims import CLAIMS, find_claim

    claims = tuple(find_claim(name) for name in claim) if claim else CLAIMS
    # Other seeds or settings are another experiment: they do not replace the committed results.
    folder = out or Path("results") / ("changed" if seeds or set_ else preset)
    if not claim:
        _require_ours(folder)
    needed = (
        {name for each in claims for name in each.experiments} if claim else set(reproduction.EXPERIMENTS)
    )
    experiments = _experiments(preset, sorted(needed, key=reproduction.EXPERIMENTS.index), set_, seeds)
    found = reproduction.reproduce(experiments, runs, jobs=jobs, quiet=quiet)
    options = "".join([
        f" --preset {preset.value}" if preset is not Preset.paper else "",
        f" --seeds {seeds}" if seeds else "",
        *(f" --set {shlex.quote(word)}" for word in set_ or []),
    ])  # fmt: skip
    if claim:
        frame = found.claims(claims, options)
    else:
        frame = reproduction.write_results(found, folder, options=options, say=teller(quiet))
    print_claims(frame)
    if not claim:
        console.print(
            f"Written to {folder}: claims.md, figures, animations, runs.csv, policies.", soft_wrap=True
        )
    if preset is Preset.smoke:
        console.print("This was the smoke preset: too small for its verdicts to mean anything.")
    if found.failures:
        raise RuntimeError(
            f"{len(found.failures)} runs failed (see FAILED above); the same command tries them again"
        )


@app.command()
def train(
    agent: Annotated[str, typer.Argument(help="A registered agent (see `list`) or module:Class.")],
    config: Annotated[Path | None, typer.Option(help="YAML file; default: the defaults of the code.")] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of agent and environment.")] = 0,
    seeds: Seeds = None,
    set_: Set = None,
    out: Annotated[Path, typer.Option(help="Folder that gets the run's folder.")] = RUNS,
    quiet: Quiet = False,
) -> None:
    """Train one agent, once for each seed; prints the run folders."""
    from crawler_bench.bench.training import train as train_run
    from crawler_bench.config import RunConfig, load_experiment, override, parse_assignments, parse_seeds

    if seeds and seed:
        raise ValueError("--seed and --seeds say the same thing: give one of them")
    run = load_experiment(config).run if config is not None else RunConfig()
    spec = _agent_spec(agent)
    if spec != _agents_package().agent_spec(run.agent):
        run = run.model_copy(update={"settings": {}})  # those of the configuration are another agent's
    run = override(run, {"agent": spec} | parse_assignments(set_ or []), "--set")
    run = run.model_copy(update={"agent": _agent_spec(run.agent)})
    for each in parse_seeds(seeds) if seeds else (seed,):
        folder = train_run(run, each, out, progress_bar=notes.is_terminal and not quiet)
        console.print(str(folder), markup=False, soft_wrap=True)


@app.command()
def evaluate(
    run: Annotated[list[Path], typer.Argument(help="Run folders, as `train` prints them.")],
    set_: Set = None,
    out: Annotated[
        Path | None, typer.Option(help="Also write runs.csv, evaluations.csv and cycles.csv here.")
    ] = None,
) -> None:
    """Measure trained runs: policy table, speed, cycle duration, speed against noise."""
    from crawler_bench.bench import store, tables
    from crawler_bench.bench.evaluation import evaluate as evaluate_run
    from crawler_bench.bench.sweep import Cell, Outcome, read_outcomes
    from crawler_bench.config import override, parse_assignments

    overrides = {
        f"evaluation.{key.removeprefix('evaluation.')}": value
        for key, value in parse_assignments(set_ or []).items()
    }
    trained = [store.read_run(folder) for folder in run]
    outcomes = []
    for folder, (config, seed) in zip(run, trained, strict=True):
        changed = override(config, overrides, "--set")
        cell = Cell(folder.resolve().name, changed, seed)
        outcomes.append(Outcome(cell, folder.resolve(), evaluate_run(folder, changed.evaluation)))
    runs, evaluations, cycles = read_outcomes(outcomes)
    print_frame(runs[["run", "policy", "speed", "speed_moving", "stall_share", "cycle_duration", "cycles"]])
    noisy = evaluations.pivot_table(index="experiment", columns="noise", values="speed")
    noisy.columns = [f"s = {noise:g}" for noise in noisy.columns]
    print_frame(noisy.rename_axis("speed (L/tau) at noise").reset_index())
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
        for name, frame in (("runs", runs), ("evaluations", evaluations), ("cycles", cycles)):
            tables.write_csv(frame, out / f"{name}.csv")


@app.command()
def render(
    run: Annotated[Path, typer.Argument(help="A run folder, as `train` prints it.")],
    out: Annotated[Path | None, typer.Option(help="Where to write; default results/rendered/RUN.")] = None,
    quiet: Quiet = False,
) -> None:
    """Film the gait of a trained run (GIF, MP4) and draw its positions, strains and forces (PNG, SVG)."""
    from crawler_bench.bench import animation, figures
    from crawler_bench.bench.evaluation import evaluate as evaluate_run
    from crawler_bench.bench.evaluation import read_evaluation
    from crawler_bench.bench.store import read_run

    read_run(run)
    say = teller(quiet)
    record = read_evaluation(evaluate_run(run)).gait
    folder = out or Path("results/rendered") / run.resolve().name
    folder.mkdir(parents=True, exist_ok=True)
    figures.save(figures.gait(record, run.resolve().name), folder, "gait")
    for suffix in (".gif", ".mp4"):
        say(f"filming gait{suffix}")
        animation.animate(record, folder / f"gait{suffix}", run.resolve().name)
    console.print(str(folder), markup=False, soft_wrap=True)


@app.command("list")
def list_() -> None:
    """List agents, environments, experiments and claims."""
    import crawler_bench
    from crawler_bench.bench.paper_claims import CLAIMS
    from crawler_bench.config import config_folder

    agents = _agents_package()
    console.print("[bold]agents[/]")
    for name, spec in agents.registered().items():
        console.print(f"  {name:12} {spec}", markup=False)
    console.print(f"[bold]environments[/]\n  {crawler_bench.ENV_ID}")
    console.print("[bold]experiments[/]")
    for path in sorted(config_folder().glob("*/*.yaml")):
        console.print(f"  {path.parent.name}/{path.stem}", markup=False)
    console.print("[bold]claims[/] (crawler-bench reproduce --claim NAME)")
    for claim in CLAIMS:
        console.print(f"  {claim.name:28} {claim.text}", markup=False, soft_wrap=True)


@app.command()
def doctor() -> None:
    """Say what is wrong with this installation, and how to mend it."""
    from crawler_bench import diagnosis

    sick = False
    for check in diagnosis.checks(_agents_package):
        console.print(
            f"{'ok     ' if check.well else 'PROBLEM'} {check.what}: {check.found}",
            markup=False,
            soft_wrap=True,
        )
        if not check.well:
            console.print(f"        to mend it: {check.mend}", markup=False, soft_wrap=True)
        sick = sick or not check.well
    if sick:
        raise typer.Exit(1)


def _agents_package() -> Any:
    """Import our `agents`, which another package on PyPI is called as well."""
    import agents

    if not hasattr(agents, "ENTRY_POINT_GROUP"):
        raise ValueError(
            f"the package 'agents' that Python finds is not crawler-bench's but {agents.__file__}; "
            "uninstall that one (it may be openai-agents) or use a fresh virtual environment"
        )
    return agents


def _agent_spec(name: str) -> str:
    spec: str = _agents_package().agent_spec(name)
    _agents_package().agent_class(spec)
    return spec


def _experiments(
    preset: Preset, names: list[str], set_: list[str] | None, seeds: str | None
) -> "list[Experiment]":
    from crawler_bench.config import config_folder, load_experiment, parse_assignments, parse_seeds

    overrides = parse_assignments(set_ or [])
    experiments = []
    for name in names:
        experiment = load_experiment(config_folder() / preset / f"{name}.yaml", overrides)
        run = experiment.run.model_copy(update={"agent": _agent_spec(experiment.run.agent)})
        update: dict[str, Any] = {"run": run} | (
            {"seeds": parse_seeds(seeds)} if seeds and not experiment.grid else {}
        )
        experiments.append(experiment.model_copy(update=update))
    return experiments


def _require_ours(folder: Path) -> None:
    """Refuse, before anything is computed, a folder that results cannot or should not go into."""
    if folder.exists() and not folder.is_dir():
        raise ValueError(f"{folder} is a file; results need a folder: choose another one with --out")
    ours = all((folder / name).is_file() for name in ("claims.csv", "manifest.json"))
    if folder.is_dir() and any(folder.iterdir()) and not ours:
        raise ValueError(
            f"{folder} is not empty and was not written by `crawler-bench reproduce` (it has no claims.csv "
            "with a manifest.json); choose another folder with --out"
        )
    folder.parent.mkdir(parents=True, exist_ok=True)
    if not os.access(folder.parent, os.W_OK):
        raise PermissionError(errno.EACCES, "cannot be written to", str(folder.parent))


def _bases() -> "dict[str, RunConfig]":
    """The paper's three experiments: the default of every reading."""
    names = ["regularized", "unregularized", "untrained"]
    return {each.name: each.run for each in _experiments(Preset.paper, names, None, None)}


readings.add_to(app, _bases)


def main() -> None:
    """Entry point of the command `crawler-bench`."""
    with one_line_errors():
        app()


if __name__ == "__main__":
    main()
