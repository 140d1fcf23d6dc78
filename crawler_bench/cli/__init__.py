"""The command line: `crawler-bench`. Heavy imports wait until a command needs them."""

import sys
from typing import Annotated

import typer

from crawler_bench.cli import benchmark, installation, paper, readings, report, runs, train, verify
from crawler_bench.cli import watch as watching
from crawler_bench.cli.options import find_modules_here
from crawler_bench.cli.terminal.errors import exit_code
from crawler_bench.cli.terminal.signals import ended_by_signals

PROGRAM = "crawler-bench"

app = typer.Typer(
    name=PROGRAM,
    no_args_is_help=True,
    rich_markup_mode=None,  # help in boxes would take twice as long to appear
    pretty_exceptions_enable=False,
)
for command in (paper.reproduce, readings.readings, train.train, runs.evaluate, runs.render, benchmark.tune):
    app.command()(command)
app.command()(benchmark.benchmark)
app.command()(benchmark.certify)
app.command()(watching.watch)
app.command("reproduce-cell")(benchmark.reproduce_cell)
app.command()(report.report)
app.command()(verify.verify)
app.command("list")(installation.list_)
app.command()(installation.settings)
app.command()(installation.doctor)
app.command()(installation.warmup)


def _print_version(wanted: bool) -> None:
    if wanted:
        from crawler_bench import __version__

        print(f"{PROGRAM} {__version__}")
        raise typer.Exit()


@app.callback()
def crawler_bench(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """How a soft-bodied crawler learns to coordinate itself: reproduce the paper, train agents."""


def main() -> None:
    """Entry point of the command `crawler-bench`."""
    sys.argv[0] = PROGRAM  # what a result says it was made with; as `python -m` it would be a file's name
    find_modules_here()
    with ended_by_signals():
        code = exit_code(lambda: app(prog_name=PROGRAM, standalone_mode=False))
    sys.exit(code)
