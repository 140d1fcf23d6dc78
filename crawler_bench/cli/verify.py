"""The command that checks whether results are as they were written."""

from pathlib import Path
from typing import Annotated

import typer

from crawler_bench.cli.options import Quiet
from crawler_bench.cli.terminal.console import console


def verify(
    folder: Annotated[Path, typer.Argument(help="Of results or runs; every folder in it is checked.")] = Path(
        "results"
    ),
    quiet: Quiet = False,
) -> None:
    """Check every file of finished results and runs against the checksums in their manifests."""
    from crawler_bench.config.errors import ConfigError
    from crawler_bench.runs.folders.checksums import MANIFEST, added_to, damage

    if not folder.is_dir():
        raise ConfigError(f"{folder} is no folder: give one of results or runs")
    places = sorted(path.parent for path in folder.rglob(MANIFEST))
    if not places:
        raise ConfigError(f"{folder} holds no finished results or runs: there is no {MANIFEST} in it")
    failed = 0
    for place in places:
        if reason := damage(place):
            failed += 1
            console.print(f"PROBLEM {reason}", markup=False, soft_wrap=True)
        elif not quiet:
            added = added_to(place)
            more = f"; added since: {', '.join(added)}" if added else ""
            console.print(f"ok      {place}{more}", markup=False, soft_wrap=True)
    if failed:
        raise RuntimeError(f"{failed} of {len(places)} folders are not as they were written")
    console.print(f"{len(places)} folders are as they were written")
