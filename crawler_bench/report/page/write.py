"""Put the page together: sections, template, style and scripts in one file."""

import base64
import gzip
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import jinja2
import pandas as pd
from markupsafe import Markup
from plotly.offline import get_plotlyjs

import crawler_bench
from crawler_bench.paper.verdicts import Verdict
from crawler_bench.report.page.folders import Folder
from crawler_bench.report.page.sections import Section, other
from crawler_bench.report.page.studies import STUDIES

TEMPLATES = Path(__file__).parent / "templates"


def write_report(folders: Sequence[Folder], path: Path) -> None:
    """Write the report on these results folders to a file; it replaces an older one when it is complete.

    Raises:
        ValueError: if a folder's CSV lacks a column that its kind of results has.
    """
    page = render([_section(folder, f"{folder.kind}-{i}") for i, folder in enumerate(folders, 1)])
    path.parent.mkdir(parents=True, exist_ok=True)
    draft = path.with_name(f".{path.name}.partial")
    draft.write_text(page, encoding="utf-8")
    draft.replace(path)


def _section(folder: Folder, identity: str) -> Section:
    make = STUDIES.get(folder.kind, other)
    try:
        return make(folder, identity)
    except (KeyError, pd.errors.ParserError) as error:
        raise ValueError(
            f"{folder.path} cannot be read as {folder.kind} results ({error}); "
            "was it written by an older version?"
        ) from error


def render(sections: Sequence[Section]) -> str:
    """The page as HTML; everything that comes from results is escaped."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATES), autoescape=True, undefined=jinja2.StrictUndefined,
        trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip
    parts: dict[str, Any] = {
        name: Markup((TEMPLATES / file).read_text(encoding="utf-8"))
        for name, file in (("style", "style.css"), ("script", "page.js"))
    }
    has_charts = any(each.charts for each in sections)
    return environment.get_template("report.html").render(
        sections=sections, verdicts=[verdict.value for verdict in Verdict],
        version=crawler_bench.__version__, plotly=_packed(get_plotlyjs()) if has_charts else "", **parts,
    )  # fmt: skip


def _packed(text: str) -> str:
    """Text compressed, for the page to unpack: a third of Plotly's script is left."""
    return base64.b64encode(gzip.compress(text.encode(), mtime=0)).decode("ascii")
