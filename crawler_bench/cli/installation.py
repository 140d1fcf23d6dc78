"""The commands about the installation itself: what there is, what is wrong, and compiling beforehand."""

import time

import typer

from crawler_bench.cli.console import console


def list_() -> None:
    """List agents, environments, experiments and claims."""
    import crawler_bench
    from crawler_bench.config.files import config_folder, registered_agents
    from crawler_bench.paper.claims import CLAIMS

    console.print("[bold]agents[/]")
    for name, spec in registered_agents().items():
        console.print(f"  {name:12} {spec}", markup=False)
    console.print(f"[bold]environments[/]\n  {crawler_bench.ENV_ID}")
    console.print("[bold]experiments[/]")
    for path in sorted(config_folder().glob("*/*.yaml")):
        console.print(f"  {path.parent.name}/{path.stem}", markup=False)
    console.print("[bold]claims[/] (crawler-bench reproduce --claim NAME)")
    for claim in CLAIMS:
        console.print(f"  {claim.name:28} {claim.text}", markup=False, soft_wrap=True)


def doctor() -> None:
    """Say what is wrong with this installation, and how to fix it."""
    from crawler_bench.cli import diagnosis

    failed = False
    for check in diagnosis.checks():
        outcome = "ok     " if check.ok else "PROBLEM"
        console.print(f"{outcome} {check.what}: {check.found}", markup=False, soft_wrap=True)
        if not check.ok:
            console.print(f"        to fix it: {check.fix}", markup=False, soft_wrap=True)
        failed = failed or not check.ok
    if failed:
        raise typer.Exit(1)


def warmup() -> None:
    """Compile everything that learning and evaluating on the default crawler needs, so that no run has to."""
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
