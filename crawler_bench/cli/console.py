"""What the command line says: results on standard output, notes and errors on standard error."""

import contextlib
import os
import sys
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

from rich.console import Console
from rich.markup import escape
from rich.table import Table

if TYPE_CHECKING:
    import pandas as pd

console = Console()
notes = Console(stderr=True)

VERDICT_COLOURS = {"reproduced": "green", "partly": "yellow", "not reproduced": "red"}
INTERRUPTED = 130  # exit code of a command that Ctrl-C ended
LEAST_WIDTH = 130  # of a table that goes into a file


def _wide_console() -> Console:
    return console if console.is_terminal else Console(width=max(console.width, LEAST_WIDTH))


def print_claims(claims: "pd.DataFrame") -> None:
    """Print claims with their verdicts, and how many there are of each verdict."""
    from crawler_bench.output.cells import format_interval, format_number
    from crawler_bench.paper.tables import verdict_counts

    wide = _wide_console()
    table = Table("claim", "paper", "ours", "95 % interval", "n", "verdict")
    for row in claims.to_dict("records"):
        coloured = f"[{VERDICT_COLOURS.get(row['verdict'], 'dim')}]{row['verdict']}[/]"
        between = format_interval(row["low"], row["high"])
        table.add_row(
            row["claim"],
            format_number(row["paper"]),
            format_number(row["ours"]),
            between,
            str(row["n"]),
            coloured,
        )
    wide.print(table)
    wide.print(verdict_counts(claims))


def print_frame(frame: "pd.DataFrame") -> None:
    """Print a frame as a table, numbers in short."""
    from crawler_bench.output.cells import format_number

    wide = _wide_console()
    table = Table(*(escape(str(name)) for name in frame.columns))
    for row in frame.itertuples(index=False):
        table.add_row(*(escape(value) if isinstance(value, str) else format_number(value) for value in row))
    wide.print(table)


def logger(quiet: bool) -> Callable[[str], None]:
    """A function that prints notes on standard error, or none."""
    return (lambda text: None) if quiet else (lambda text: notes.print(text, markup=False))


def conclude(written: str, smoke: bool, errors: list[str]) -> None:
    """Say what was written, and that the smoke preset proves nothing.

    Raises:
        RuntimeError: if runs failed.
    """
    if written:
        console.print(f"Written to {written}.", soft_wrap=True)
    if smoke:
        console.print("This was the smoke preset: too small for its numbers to mean anything.")
    if errors:
        raise RuntimeError(
            f"{len(errors)} runs failed; the first: {errors[0]}; the same command tries them again"
        )


@contextlib.contextmanager
def one_line_errors() -> Iterator[None]:
    """Turn what a user can fix into one line and a non-zero exit; a bug keeps its traceback.

    With CRAWLER_BENCH_DEBUG set, every error keeps it.
    """
    try:
        yield
    except (KeyboardInterrupt, SystemExit) as end:
        if isinstance(end, SystemExit) and end.code != INTERRUPTED:
            raise
        _complain("interrupted; the same command goes on from the runs that are finished")
        sys.exit(INTERRUPTED)
    except (OSError, ValueError, RuntimeError) as error:
        if os.environ.get("CRAWLER_BENCH_DEBUG"):
            raise
        from crawler_bench.runs.store import explain

        _complain(explain(error))
        sys.exit(1)


def _complain(message: str) -> None:
    text = f"crawler-bench: {message}"
    notes.print(text, style="red", markup=False, highlight=False, soft_wrap=True)
