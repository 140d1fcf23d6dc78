"""Claims of the paper as the report shows them: verdict, numbers, figure and command."""

import re
from collections.abc import Iterable
from dataclasses import dataclass

import pandas as pd

from crawler_bench.paper.tables import SIGNS
from crawler_bench.report.figures import described
from crawler_bench.report.page.cells import Cell, cell

# Where a claim is made in the text, the figure that shows what it is about.
_OF_THE_TEXT = {"Scaling": "fig_2a", "Results": "fig_3c", "implied": "fig_3c", "Formulation": "fig_learning"}


@dataclass(frozen=True)
class Claim:
    """A claim.

    Attributes:
        text: the sentence.
        verdict: in words.
        sign: of the verdict.
        source: where the paper makes it.
        paper: the paper's value.
        ours: with its interval and number of runs.
        command: that re-makes it.
        figure: anchor of the figure that shows it; empty if there is none.
        figure_title: its title.
    """

    text: str
    verdict: str
    sign: str
    source: str
    paper: Cell
    ours: Cell
    command: str
    figure: str
    figure_title: str


def claims(frame: pd.DataFrame, identity: str, figures: Iterable[str]) -> list[Claim]:
    """The rows of claims.csv.

    Args:
        frame: what it holds.
        identity: of the section, with which anchors begin.
        figures: names of the figures that are there.
    """
    known = set(figures)
    found = []
    for row in frame.to_dict("records"):
        verdict, name = str(row["verdict"]), figure_of(str(row["source"]))
        ours = cell(row["ours"], row["low"], row["high"], row["n"])
        anchor, title = (f"{identity}-{name}", described("paper", name).title) if name in known else ("", "")
        found.append(
            Claim(
                str(row["claim"]),
                verdict,
                SIGNS.get(verdict, "-"),
                str(row["source"]),
                _paper(row["paper"]),
                ours,
                str(row["command"]),
                anchor,
                title,
            )
        )
    return found


def figure_of(source: str) -> str:
    """Name of the figure for a source such as "Results, Fig. 2A"; empty if there is none."""
    named = re.search(r"Fig\. (\w+)", source)
    if named:
        return f"fig_{named[1].lower()}"
    return next((name for place, name in _OF_THE_TEXT.items() if place in source), "")


def _paper(value: object) -> Cell:
    """The paper's value: a number, or words such as "yes" or "> 0"."""
    try:
        return cell(float(str(value)))
    except ValueError:
        return cell(str(value))
