"""The commands about the installation itself: what there is, what is wrong, and compiling beforehand."""

import time
from dataclasses import asdict
from typing import Annotated

import typer
from rich.table import Table

from crawler_bench.cli import names
from crawler_bench.cli.options import Json
from crawler_bench.cli.terminal.console import console, print_json, print_table, starting

SHOWN = {
    "index": "shows the index of the most contracted segment (Discrete)",
    "one-hot": "shows the same as zeros and ones (Box)",
    "strain": "shows the strain of every segment (Box)",
    "state": "shows all that decides the future (Box)",
}


def list_(json: Json = False) -> None:
    """List agents, environments, configurations, policies and claims."""
    from crawler_bench import KEYHOLE_IDS
    from crawler_bench.config.files import registered_agents
    from crawler_bench.paper.claims import CLAIMS

    agents, policies = registered_agents(), names.policies()
    if json:
        claims = {claim.name: claim.text for claim in CLAIMS}
        environments = list(KEYHOLE_IDS.values())
        print_json({
            "agents": agents, "environments": environments, "configurations": names.configs(),
            "policies": policies, "claims": claims,
        })  # fmt: skip
        return
    console.print("[bold]agents[/] (crawler-bench train AGENT)")
    for name, spec in agents.items():
        console.print(f"  {name:{max(map(len, agents))}}  {spec}", markup=False)
    console.print("[bold]environments[/] (gymnasium.make)")
    for keyhole, id_ in KEYHOLE_IDS.items():
        console.print(f"  {id_:31} {SHOWN[keyhole]}", markup=False, soft_wrap=True)
    console.print(
        "[bold]configurations[/] (crawler-bench train --config NAME; tuning/NAME: crawler-bench tune NAME)",
        soft_wrap=True,
    )
    for name in names.configs():
        console.print(f"  {name}", markup=False)
    console.print("[bold]policies[/] (crawler-bench render NAME)")
    for name in policies:
        console.print(f"  {name}", markup=False)
    console.print("[bold]claims[/] (crawler-bench reproduce --claim NAME)")
    for claim in CLAIMS:
        console.print(f"  {claim.name:28} {claim.text}", markup=False, soft_wrap=True)


def settings(
    agent: Annotated[
        str | None,
        typer.Argument(
            help="Also the settings of this agent: a registered one or module:Class.",
            autocompletion=names.agents,
        ),
    ] = None,
    json: Json = False,
) -> None:
    """List every key that --set takes, with its default, unit and source."""
    from crawler_bench.config.documentation import run_settings
    from crawler_bench.config.files import agent_spec

    found = run_settings()
    if agent is not None:
        agent_spec(agent)
        with starting(f"looking into {agent}", quiet=json):
            from crawler_bench.runs.agent_settings import agent_settings
        found += agent_settings(agent)
    if json:
        print_json([asdict(each) for each in found])
        return
    table = Table("key", "default", "unit", "what it is", "source of the default")
    table.columns[0].no_wrap = True  # to be copied
    for each in found:
        default = ", ".join(map(str, each.default)) if isinstance(each.default, tuple) else str(each.default)
        table.add_row(each.key, default, each.unit, each.meaning, each.source)
    print_table(table)


def doctor(
    imports: Annotated[
        bool, typer.Option("--imports", help="Import every package, too: slower, and finds broken ones.")
    ] = False,
    json: Json = False,
) -> None:
    """Say what is wrong with this installation, and how to fix it."""
    from crawler_bench.cli import diagnosis

    found = []
    for check in diagnosis.checks(imports):
        found.append(check)
        if json:
            continue
        outcome = "ok     " if check.ok else "PROBLEM"
        console.print(f"{outcome} {check.what}: {check.found}", markup=False, soft_wrap=True)
        if not check.ok:
            console.print(f"        to fix it: {check.fix}", markup=False, soft_wrap=True)
    if json:
        print_json([asdict(check) for check in found])
    if not all(check.ok for check in found):
        raise typer.Exit(1)


def warmup() -> None:
    """Compile everything that learning and evaluating on the default crawler needs, so that no run has to."""
    with starting("compiling the physics: about half a minute, and nothing to do if it has been"):
        import gymnasium as gym
        import numpy as np

        import crawler_bench
        from crawler_bench.gait.rollout import rollout
        from crawler_bench.physics.parameters import CrawlerParameters
        from crawler_bench.runs.agent import agent_class

        started = time.perf_counter()
        env = gym.make(crawler_bench.ENV_ID)
        env.reset(seed=0)
        env.step(0)
        agent_class("qlearning")(env=env, seed=0).learn(1, callback=None, progress_bar=False)
        crawlers = gym.make_vec(crawler_bench.ENV_ID, num_envs=2)
        crawlers.reset(seed=0)
        crawlers.step(np.zeros(2, dtype=np.int64))
        parameters = CrawlerParameters()
        wave = np.eye(parameters.n_segments)
        rollout(parameters, wave, warm_up=0.0, duration=parameters.decision_interval, noise=0.0, start=(0,))
    console.print(f"ready to step, after {time.perf_counter() - started:.0f} s")
