"""The command that trains."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from crawler_bench.cli import names
from crawler_bench.cli.long_runs import (
    Continue,
    EvalEvery,
    SaveEvery,
    Tensorboard,
    go_on,
    require_alone,
)
from crawler_bench.cli.options import (
    RUNS,
    Preset,
    PresetOption,
    Quiet,
    Seeds,
    Set,
    Trust,
    require_folder,
    resized,
)
from crawler_bench.cli.terminal.console import console, logger, phase, starting

if TYPE_CHECKING:
    from crawler_bench.config.schema import Experiment, RunConfig


def train(
    agent: Annotated[
        str | None,
        typer.Argument(
            help="A registered agent (see `list`) or module:Class; default: the configuration's.",
            autocompletion=names.agents,
        ),
    ] = None,
    config: Annotated[
        str | None,
        typer.Option(
            help="A configuration by its name in `list`, or a YAML file: its seeds and grid count, too.",
            autocompletion=names.configs,
        ),
    ] = None,
    preset: PresetOption = Preset.paper,
    seed: Annotated[
        int | None, typer.Option(min=0, help="Seed of agent and environment [default: 0].")
    ] = None,
    seeds: Seeds = None,
    set_: Set = None,
    out: Annotated[Path, typer.Option(help="Folder that gets the run's folder.")] = RUNS,
    save_every: SaveEvery = 0,
    eval_every: EvalEvery = 0,
    tensorboard: Tensorboard = None,
    continue_: Continue = None,
    trust: Trust = False,
    quiet: Quiet = False,
) -> None:
    """Train an agent, once for each seed; prints the run folders."""
    if continue_ is not None:
        require_alone(agent, config, seed, seeds, set_)
        go_on(continue_, (save_every, eval_every, tensorboard), trust, quiet)
        return
    experiment = experiment_to_train(agent, config, preset, seed, seeds, set_, trust)
    require_folder(out)
    runs = list(experiment.runs())
    with starting(f"training {experiment.run.agent}, run folders in {out}", quiet):
        from crawler_bench.runs import store
        from crawler_bench.runs.agent import agent_class
        from crawler_bench.runs.long.running import Habits, require_possible, train_long
        from crawler_bench.runs.training import train as train_run

        agent_class(experiment.run.agent)
        habits = Habits(save_every, eval_every, tensorboard)
        if habits.any:
            require_possible(experiment.run, habits)
        folders = [store.run_folder(out, run, each) for run, each in runs]
    logger(quiet)(_plan(runs, folders, out))
    for number, (run, each) in enumerate(runs, 1):
        name = f"training {number}/{len(runs)} (seed {each})"
        silent = quiet or store.is_run(folders[number - 1])
        with phase(name, run.decisions, "decisions", silent) as progress:
            if habits.any:
                folder = train_long(run, each, out, habits, progress)
            else:
                folder = train_run(run, each, out, progress=progress)
        console.print(str(folder), markup=False, soft_wrap=True)


def experiment_to_train(
    agent: str | None,
    config: str | None,
    preset: Preset,
    seed: int | None,
    seeds: str | None,
    set_: list[str] | None,
    trust: bool = False,
) -> "Experiment":
    """What the words of the command line ask to train.

    Raises:
        ConfigError: if two of them contradict each other, or a file names a class that is not to be imported.
    """
    from crawler_bench.config.errors import ConfigError
    from crawler_bench.config.files import agent_spec, find_config, load_experiment, parse_assignments
    from crawler_bench.config.schema import Experiment, RunConfig, override
    from crawler_bench.runs.untrusted import agents_of, require_trust

    if seeds is not None and seed is not None:
        raise ConfigError("--seed and --seeds exclude each other: give one of them")
    if agent is None and config is None:
        raise ConfigError("name an agent (see `crawler-bench list`), or a configuration with --config")
    if agent is not None:
        agent_spec(agent)  # misspelt? said before a file is looked for
    experiment, study = Experiment(name="--set"), "train"
    if config is not None:
        path = find_config(config)
        experiment, study = load_experiment(path), path.parent.name
    stated = experiment.run.agent if "agent" in experiment.run.model_fields_set else None
    if agent is not None and stated is not None and agent_spec(agent) != agent_spec(stated):
        raise ConfigError(
            f"{config} says `agent: {stated}`, the command line {agent}: leave one of the two out"
        )
    if config is not None and not trust:
        require_trust(agents_of(experiment), path, [agent] if agent else [])
    run = experiment.run.model_copy(update={"agent": stated or agent or RunConfig().agent})
    has_seeds = "seeds" in experiment.model_fields_set
    experiment = experiment.model_copy(update={"run": run} | ({} if has_seeds else {"seeds": (0,)}))
    found = resized(experiment, study, preset, set_, str(seed) + "," if seed is not None else seeds)
    wanted = parse_assignments(set_ or [])
    if "decisions" in wanted:  # even where the configuration learns nothing
        found = found.model_copy(
            update={"run": override(found.run, {"decisions": wanted["decisions"]}, "--set")}
        )
    return found


def _plan(runs: "Sequence[tuple[RunConfig, int]]", folders: Sequence[Path], out: Path) -> str:
    """How many runs there are, how many are finished, and about how long the rest takes."""
    from crawler_bench.runs import store
    from crawler_bench.runs.progress import format_duration, seconds_to_train

    left = [run for (run, _), folder in zip(runs, folders, strict=True) if not store.is_run(folder)]
    count = f"{len(runs)} run{'' if len(runs) == 1 else 's'}"
    if not left:
        return f"{count}: all finished"
    decisions = " or ".join(f"{each:,}" for each in sorted({run.decisions for run in left}))
    seconds = sum(seconds_to_train(out, run) for run in left)
    return (
        f"{count}: {len(left)} to train ({len(runs) - len(left)} finished), {decisions} decisions each, "
        f"about {format_duration(seconds)}"
    )
