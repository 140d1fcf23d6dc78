"""What the command line says: results on standard output, notes and errors on standard error."""

import contextlib
import json
import time
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

if TYPE_CHECKING:
    import pandas as pd

console = Console()
notes = Console(stderr=True)

VERDICT_COLOURS = {"reproduced": "green", "partly": "yellow", "not reproduced": "red"}
LEAST_WIDTH = 130  # of a table that goes into a file
PATIENCE = 15.0  # s between two lines where there is no terminal


def _wide_console() -> Console:
    return console if console.is_terminal else Console(width=max(console.width, LEAST_WIDTH))


def print_table(table: Table) -> None:
    """Print a table, wide where it goes into a file."""
    _wide_console().print(table)


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


def print_json(value: Any) -> None:
    """Print a value for other programs: JSON alone, on standard output."""
    console.file.write(json.dumps(value, indent=1) + "\n")


def records(frame: "pd.DataFrame") -> Any:
    """A frame as JSON has it: one object per row, null where there is no number."""
    return json.loads(frame.to_json(orient="records", double_precision=15))


def logger(quiet: bool) -> Callable[[str], None]:
    """A function that prints notes on standard error, or none."""
    return (lambda text: None) if quiet else (lambda text: notes.print(text, markup=False))


@contextlib.contextmanager
def starting(text: str, quiet: bool = False) -> Iterator[None]:
    """Say at once what a command will do, and show that it lives while its imports take their time."""
    if quiet:
        yield
        return
    notes.print(text, markup=False, soft_wrap=True)
    with notes.status("loading") if notes.is_terminal else contextlib.nullcontext():
        yield


@contextlib.contextmanager
def phase(name: str, total: float, unit: str = "", quiet: bool = False) -> Iterator[Callable[[float], None]]:
    """Show how far a piece of work is: a bar on a terminal, elsewhere a line now and then.

    Args:
        name: of the phase, such as "training 2/3".
        total: how much there is to do.
        unit: of what is counted.
        quiet: show nothing.

    Yields:
        A function that takes how much is done.
    """
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

    from crawler_bench.runs.progress import format_duration

    said, first = time.monotonic(), (0.0, -1.0)  # when progress was first told of, and how much there was
    count = TextColumn("{task.completed:,.0f}/{task.total:,.0f} " + unit)
    times = TimeElapsedColumn(), TextColumn("left"), TimeRemainingColumn()
    shown = notes.is_terminal and not quiet
    with Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        count,
        *times,
        console=notes,
        disable=not shown,
        transient=True,
    ) as bar:
        task = bar.add_task(name, total=total)
        if not shown:
            logger(quiet)(name)

        def advance(done: float) -> None:
            nonlocal said, first
            bar.update(task, completed=done)
            now = time.monotonic()
            if first[1] < 0:
                first = now, done  # what came before may have been compiling, or an earlier command
            if not shown and now - said > PATIENCE and 0 < done < total:
                said = now
                (began, before), left = first, ""
                if done > before:
                    left = f", about {format_duration((now - began) * (total - done) / (done - before))} left"
                logger(quiet)(f"{name}: {done:,.0f}/{total:,.0f} {unit}{left}")

        yield advance


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
