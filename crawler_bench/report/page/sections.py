"""A results folder as a section of the report: what the template needs to know of it."""

import json
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pandas as pd
from markupsafe import Markup

from crawler_bench.report.figures import COMMANDS, pictures
from crawler_bench.report.page import media
from crawler_bench.report.page.cells import Cell, Table, plain_table
from crawler_bench.report.page.charts import Chart
from crawler_bench.report.page.claims import Claim
from crawler_bench.report.page.folders import Folder

LONGEST = 200  # rows of a CSV that a section shows as it is
# By kind: title, and a word for it where there is little room.
_TITLES = {
    "paper": ("The paper, claim by claim", "Paper"), "benchmark": ("Agents compared", "Agents"),
    "readings": ("Readings of what the paper leaves open", "Readings"),
    "search": ("The search among readings", "Search"),
}  # fmt: skip


@dataclass(frozen=True)
class Picture:
    """A figure: its anchor in the page, its words, and its data."""

    anchor: str
    title: str
    shows: str
    source: str
    width: int
    height: int


@dataclass(frozen=True)
class Film:
    """A film of a gait."""

    title: str
    source: str


@dataclass(frozen=True)
class Board:
    """A policy as a drawing, and what is said below it.

    Attributes:
        drawing: SVG.
        title: whose it is.
        text: which one.
        code: its digits; empty for a mean of policies.
        off_diagonal: share of its actions that are off the diagonal, where it is known.
    """

    drawing: Markup
    title: str
    text: str
    code: str = ""
    off_diagonal: Cell | None = None


@dataclass(frozen=True)
class Run:
    """What made the results: the command, short facts, and the manifest in full."""

    command: str
    facts: Sequence[tuple[str, str]]
    manifest: str


@dataclass(frozen=True)
class Fact:
    """What a reader wants to know of a folder first.

    Attributes:
        label: in front of it.
        value: a count, or a number of a CSV.
        source: that CSV, relative to the results folder; empty for a count.
    """

    label: str
    value: int | Cell
    source: str = ""


@dataclass(frozen=True)
class Section:
    """A results folder.

    Attributes:
        identity: unique in the page.
        title: of the section.
        short: the title in a word.
        path: of the folder, as the user named it.
        kind: of the results.
        run: what made them.
        glance: what was found, in a line.
        claims: of the paper; none in other sections.
        films: of gaits.
        charts: that answer to the pointer.
        boards: policies.
        tables: to sort and filter.
        figures: drawn by Matplotlib.
        left_out: CSV files that are too long to show as they are, with their number of rows.
    """

    identity: str
    title: str
    short: str
    path: str
    kind: str
    run: Run
    glance: Sequence[Fact] = ()
    claims: Sequence[Claim] = ()
    films: Sequence[Film] = ()
    charts: Sequence[Chart] = ()
    boards: Sequence[Board] = ()
    tables: Sequence[Table] = ()
    figures: Sequence[Picture] = ()
    left_out: Sequence[tuple[str, int]] = field(default=())


def section(folder: Folder, identity: str, **parts: Any) -> Section:
    """A section with the figures and the manifest of its folder.

    Args:
        folder: what it shows.
        identity: unique in the page.
        parts: glance, claims, films, charts, boards, tables, left_out.
    """
    name = folder.path.name.replace("_", " ").capitalize()
    title, short = _TITLES.get(folder.kind, (name, name))
    return Section(
        identity, title, short, folder.path.as_posix(), folder.kind, _run(folder),
        figures=_pictures(folder, identity), **parts,
    )  # fmt: skip


def other(folder: Folder, identity: str, tables: Iterable[Table] = (), **parts: Any) -> Section:
    """A section of tables, or, where none are given, of every CSV of the folder that is not too long."""
    chosen, left_out = list(tables), []
    if not chosen:
        for path in sorted(folder.path.glob("*.csv")):
            frame = folder.frame(path.stem)
            if len(frame) > LONGEST:
                left_out.append((path.name, len(frame)))
            elif len(frame):
                caption = path.stem.replace("_", " ").capitalize()
                chosen.append(plain_table(f"{identity}-{path.stem}", caption, path.name, frame))
    return section(folder, identity, tables=chosen, left_out=left_out, **parts)


def films(folder: Folder) -> list[Film]:
    """Every film of a folder."""
    return [
        Film(f"{path.stem.replace('_', ' ').capitalize()} gait", media.film(path))
        for path in sorted(folder.path.glob("*.mp4"))
    ]


def _pictures(folder: Folder, identity: str) -> list[Picture]:
    kind = folder.path.name if folder.kind == "other" else folder.kind
    found = list(pictures(folder.path, kind))
    with ThreadPoolExecutor() as threads:  # Pillow lets go of the interpreter while it compresses
        data = list(threads.map(media.picture, [path for _, _, path in found]))
    return [
        Picture(f"{identity}-{name}", words.title, words.shows, *each)
        for (name, words, _), each in zip(found, data, strict=True)
    ]


def _run(folder: Folder) -> Run:
    command = _text(folder.path / "command.txt").strip() or COMMANDS.get(folder.kind, "")
    text = _text(folder.path / "manifest.json")
    content: dict[str, Any] = json.loads(text) if text else {}
    git, machine = content.get("git") or {}, content.get("machine") or {}
    facts = {
        "finished": content.get("finished"),
        "wall clock of the last part (s)": content.get("wall_clock_seconds"),
        "crawler-bench": content.get("crawler_bench"),
        "commit": f"{git.get('commit') or ''}{' with changes' if git.get('dirty') else ''}",
        "Python": content.get("python"),
        "packages": ", ".join(f"{name} {version}" for name, version in content.get("packages", {}).items()),
        "machine": ", ".join(f"{each}{' cores' * (name == 'cores')}" for name, each in machine.items()),
        "runs": str(len(content["runs"])) if "runs" in content else None,
    }  # fmt: skip
    return Run(command, [(name, str(value)) for name, value in facts.items() if value], text)


def _text(path: Path) -> str:
    return path.read_text(encoding="utf-8") if path.is_file() else ""


def counts(values: pd.Series) -> list[tuple[str, int]]:
    """Every value with how often it occurs, the commonest first, equals by name."""
    found = values.value_counts().sort_index().sort_values(ascending=False, kind="stable")
    return [(str(value), int(count)) for value, count in found.items()]
