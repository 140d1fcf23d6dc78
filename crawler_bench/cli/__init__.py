"""The command line: `crawler-bench`. Heavy imports wait until a command needs them."""

import typer

from crawler_bench.cli import benchmark, installation, paper, readings, runs
from crawler_bench.cli import watch as watching
from crawler_bench.cli.console import one_line_errors
from crawler_bench.cli.options import find_modules_here

app = typer.Typer(
    name="crawler-bench",
    help="How a soft-bodied crawler learns to coordinate itself: reproduce the paper, train agents.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    add_completion=False,
)
for command in (paper.reproduce, readings.readings, runs.train, runs.evaluate, runs.render, benchmark.tune):
    app.command()(command)
app.command()(benchmark.benchmark)
app.command()(benchmark.certify)
app.command()(watching.watch)
app.command("reproduce-cell")(benchmark.reproduce_cell)
app.command("list")(installation.list_)
app.command()(installation.doctor)
app.command()(installation.warmup)


def main() -> None:
    """Entry point of the command `crawler-bench`."""
    with one_line_errors():
        find_modules_here()
        app()
