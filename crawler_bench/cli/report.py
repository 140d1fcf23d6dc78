"""The command that writes a page of what is in results/."""

import time
from pathlib import Path
from typing import Annotated

import typer

from crawler_bench.cli.options import Quiet
from crawler_bench.cli.terminal.console import console, logger

MEGABYTE = 1_000_000


def report(
    folders: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="[FOLDER]...",
            help="Results to show, or folders that hold some; default results.",
            show_default=False,
        ),
    ] = None,
    out: Annotated[Path, typer.Option(help="The HTML file to write.")] = Path("results/report.html"),
    quiet: Quiet = False,
) -> None:
    """Write one HTML page of what is in results/: claims, films, curves, policies, tables, figures.

    The file needs no network and no other file: send it to anyone.
    """
    from crawler_bench.report.page.folders import DEFAULT, find_folders
    from crawler_bench.report.page.write import write_report

    if out.is_dir():
        raise IsADirectoryError(f"{out} is a folder; name a file with --out, such as {out / 'report.html'}")
    found = find_folders(folders or [DEFAULT])
    began = time.monotonic()
    logger(quiet)(f"reading {', '.join(each.path.as_posix() for each in found)}")
    write_report(found, out)
    size, seconds = out.stat().st_size / MEGABYTE, time.monotonic() - began
    console.print(f"Written to {out}: {size:.1f} MB in {seconds:.0f} s.", soft_wrap=True, highlight=False)
