"""The commands that compare agents."""

from pathlib import Path
from typing import Annotated

import typer

from crawler_bench.cli.options import RUNS, Jobs, Quiet, Runs, Set, agent_spec
from crawler_bench.console import console, teller


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
    from crawler_bench.bench.tables import write_csv
    from crawler_bench.bench.tuning import tune as search
    from crawler_bench.config import config_folder, load_tuning, parse_assignments, to_yaml

    path = Path(agent) if agent.endswith((".yaml", ".yml")) else config_folder() / "tuning" / f"{agent}.yaml"
    tuning = load_tuning(path, parse_assignments(set_ or []))
    run = tuning.run.model_copy(update={"agent": agent_spec(tuning.run.agent)})
    tuning = tuning.model_copy(update={"run": run})
    best, trials = search(tuning, runs, jobs=jobs, quiet=quiet, say=teller(quiet))
    out.mkdir(parents=True, exist_ok=True)
    write_csv(trials, out / f"{tuning.name}.csv")
    (out / f"{tuning.name}.yaml").write_text(to_yaml(best))
    console.print(f"{out / tuning.name}.csv, .yaml: {best.settings}", markup=False, soft_wrap=True)
