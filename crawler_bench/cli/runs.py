"""The commands about single runs: train, evaluate, render."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from crawler_bench.cli.console import console, logger, notes, print_frame
from crawler_bench.cli.long_runs import Continue, EvalEvery, SaveEvery, Tensorboard, go_on
from crawler_bench.cli.options import RUNS, Quiet, Seeds, Set, evaluation_overrides

if TYPE_CHECKING:
    from crawler_bench.runs.results import Measured


def train(
    agent: Annotated[str, typer.Argument(help="A registered agent (see `list`) or module:Class.")] = "",
    config: Annotated[Path | None, typer.Option(help="YAML file; default: the defaults of the code.")] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of agent and environment.")] = 0,
    seeds: Seeds = None,
    set_: Set = None,
    out: Annotated[Path, typer.Option(help="Folder that gets the run's folder.")] = RUNS,
    save_every: SaveEvery = 0,
    eval_every: EvalEvery = 0,
    tensorboard: Tensorboard = None,
    continue_: Continue = None,
    quiet: Quiet = False,
) -> None:
    """Train one agent, once for each seed; prints the run folders."""
    if bool(agent) == (continue_ is not None):
        raise ValueError("`train` takes an agent, or --continue RUN, and one of the two")
    if continue_ is not None:
        go_on(continue_, save_every, eval_every, tensorboard, notes.is_terminal and not quiet)
        return
    from crawler_bench.config.files import agent_spec, load_experiment, parse_assignments
    from crawler_bench.config.schema import RunConfig, override, parse_seeds
    from crawler_bench.runs.agent import agent_class
    from crawler_bench.runs.checkpoints import Habits, train_long
    from crawler_bench.runs.training import train as train_run

    if seeds and seed:
        raise ValueError("--seed and --seeds exclude each other: give one of them")
    run = load_experiment(config).run if config is not None else RunConfig()
    if agent_spec(agent) != agent_spec(run.agent):
        run = run.model_copy(update={"settings": {}})  # those of the configuration are another agent's
    run = override(run, {"agent": agent} | parse_assignments(set_ or []), "--set")
    agent_class(run.agent)  # before anything is computed
    for each in parse_seeds(seeds) if seeds else (seed,):
        shows = notes.is_terminal and not quiet
        habits = Habits(save_every, eval_every, tensorboard)
        folder = train_long(run, each, out, habits, shows) if habits.any else train_run(run, each, out, shows)
        console.print(str(folder), markup=False, soft_wrap=True)


def evaluate(
    run: Annotated[list[Path], typer.Argument(help="Run folders, as `train` prints them, or policy files.")],
    set_: Set = None,
    out: Annotated[
        Path | None, typer.Option(help="Also write runs.csv, evaluations.csv and cycles.csv here.")
    ] = None,
) -> None:
    """Measure trained runs or shared policies: policy table, speed, cycle duration, speed against noise."""
    from crawler_bench.output.csv_files import write_csv
    from crawler_bench.runs.results import tabulate

    overrides = evaluation_overrides(set_)
    runs, evaluations, cycles = tabulate([_measure(path, overrides) for path in run])
    print_frame(runs[["run", "policy", "speed", "speed_moving", "stall_share", "cycle_duration", "cycles"]])
    noisy = evaluations.pivot_table(index="experiment", columns="noise", values="speed", sort=False)
    noisy.columns = [f"s = {noise:g}" for noise in noisy.columns]
    print_frame(noisy.rename_axis("speed (L/tau) at noise").reset_index())
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
        for name, frame in (("runs", runs), ("evaluations", evaluations), ("cycles", cycles)):
            write_csv(frame, out / f"{name}.csv")


def render(
    run: Annotated[Path, typer.Argument(help="A run folder, as `train` prints it, or a policy file.")],
    set_: Set = None,
    out: Annotated[Path | None, typer.Option(help="Where to write; default results/rendered/RUN.")] = None,
    quiet: Quiet = False,
) -> None:
    """Film the gait of a trained run (GIF, MP4) and draw its positions, strains and forces (PNG, SVG)."""
    from crawler_bench.output import animation, kymographs, style

    measured = _measure(run, evaluation_overrides(set_))
    say = logger(quiet)
    record = measured.evaluation.gait
    folder = out or Path("results/rendered") / measured.name
    folder.mkdir(parents=True, exist_ok=True)
    style.save(kymographs.gait(record, measured.name), folder, "gait")
    for suffix in (".gif", ".mp4"):
        say(f"filming gait{suffix}")
        animation.animate(record, folder / f"gait{suffix}", measured.name)
    console.print(str(folder), markup=False, soft_wrap=True)


def _measure(path: Path, overrides: dict[str, Any]) -> "Measured":
    """Evaluate a run folder, which keeps its evaluations, or a policy file."""
    import pandas as pd

    from crawler_bench.config.schema import override
    from crawler_bench.runs import evaluation, policy_files, store
    from crawler_bench.runs.results import Measured, label

    if path.suffix in (".json", ".zip"):
        policy = policy_files.read_policy(path)
        config = override(policy.config, overrides, "--set")
        found = evaluation.measure(
            config, policy.seed, policy.table_of(config.evaluation.mode), config.evaluation
        )
        return Measured(label(path.stem, config, policy.seed), path.stem, found, pd.DataFrame())
    config, seed = store.read_run(path)
    config = override(config, overrides, "--set")
    found = evaluation.read_evaluation(evaluation.evaluate(path, config.evaluation))
    name = path.resolve().name
    return Measured(label(name, config, seed), name, found, pd.read_csv(path / "learning.csv"))
