"""Tables of the report: what a cell says, what it is sorted by, and which numbers it shows."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import pandas as pd

from crawler_bench.output.cells import format_number
from crawler_bench.output.csv_files import DIGITS


@dataclass(frozen=True)
class Number:
    """A number as a CSV has it and as a reader wants it."""

    value: float

    @property
    def raw(self) -> str:
        """As a CSV has it."""
        return f"{self.value:.{DIGITS}g}"

    @property
    def text(self) -> str:
        """In short."""
        return format_number(self.value)

    @property
    def known(self) -> bool:
        """Whether there is such a number."""
        return not math.isnan(self.value)


@dataclass(frozen=True)
class Cell:
    """One cell.

    Attributes:
        content: a number or text.
        low: lower end of the interval of the number, or None.
        high: upper end.
        n: number of runs behind it, where the table has no column for that.
        code: whether the text is something to type.
    """

    content: Number | str
    low: Number | None = None
    high: Number | None = None
    n: int | None = None
    code: bool = False

    @property
    def number(self) -> Number | None:
        """The content, if it is a number that is known."""
        return self.content if isinstance(self.content, Number) and self.content.known else None

    @property
    def key(self) -> str:
        """What the cell is sorted by; empty is last."""
        if isinstance(self.content, Number):
            return self.content.raw if self.content.known else ""
        return self.content

    @property
    def interval(self) -> bool:
        """Whether there is an interval to show."""
        return self.low is not None and self.high is not None and self.low.known

    @property
    def no_spread(self) -> bool:
        """Whether all runs agree."""
        return self.interval and self.low == self.high


@dataclass(frozen=True)
class Table:
    """A table that a reader can sort and filter.

    Attributes:
        identity: unique in the page.
        caption: what a row is.
        source: the CSV that every number of it is in, relative to the results folder.
        columns: headings.
        rows: a cell for each column.
        filters: by heading, the value that is chosen at first; empty is all.
        derived: whether the numbers are computed from that CSV instead of copied.
    """

    identity: str
    caption: str
    source: str
    columns: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    filters: Mapping[str, str] = field(default_factory=dict)
    derived: bool = False

    def choices(self, column: str) -> list[str]:
        """Values of a column in the order of the rows."""
        at = list(self.columns).index(column)
        return list(dict.fromkeys(row[at].key for row in self.rows))

    def numeric(self, column: str) -> bool:
        """Whether a column holds numbers."""
        at = list(self.columns).index(column)
        return any(isinstance(row[at].content, Number) for row in self.rows)


def cell(value: Any, low: Any = None, high: Any = None, n: Any = None, *, code: bool = False) -> Cell:
    """A cell of a value from a CSV: numbers become a `Number`, a missing one NaN, the rest text."""
    if isinstance(value, bool) or type(value).__name__ == "bool_":
        return Cell("yes" if value else "no")
    if isinstance(value, str) or value is None:
        return Cell(value or "", code=code)
    lowest, highest = (None, None) if low is None else (Number(float(low)), Number(float(high)))
    return Cell(Number(float(value)), lowest, highest, None if n is None else int(n))


def plain_table(identity: str, caption: str, source: str, frame: pd.DataFrame) -> Table:
    """A CSV as it is, but for `low` and `high`, which go into one column with what they belong to.

    They belong to the column before them.
    """
    names = [str(name) for name in frame.columns]
    bounds = {"low", "high"} & set(names)
    owner = names[names.index("low") - 1] if len(bounds) == 2 and names.index("low") else ""
    shown = [name for name in names if not (owner and name in bounds)]
    rows = []
    for row in frame.to_dict("records"):
        cells = [
            cell(row[name], row["low"], row["high"])
            if name == owner and not isinstance(row[name], str)
            else cell(row[name])
            for name in shown
        ]
        rows.append(cells)
    return Table(identity, caption, source, [name.replace("_", " ") for name in shown], rows)
