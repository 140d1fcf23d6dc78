"""The commands about the installation itself: what there is, and what is wrong."""

import typer

from crawler_bench.cli.console import console
from crawler_bench.cli.options import agents_package


def list_() -> None:
    """List agents, environments, experiments and claims."""
    import crawler_bench
    from crawler_bench.config.files import config_folder
    from crawler_bench.paper.claims import CLAIMS

    agents = agents_package()
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


def doctor() -> None:
    """Say what is wrong with this installation, and how to mend it."""
    from crawler_bench.cli import diagnosis

    sick = False
    for check in diagnosis.checks(agents_package):
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
