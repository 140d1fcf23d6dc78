"""What the figures of a benchmark share: the look of each agent, and parts of panels."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import cycle, islice

import numpy as np
import pandas as pd
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from crawler_bench.benchmark.keys import MODES, select
from crawler_bench.output.style import BLUE, GREY, INK, RED, SPEED_SCALE
from crawler_bench.statistics import estimates

REFERENCES = {"random": (GREY, "--"), "wave": (INK, "-.")}  # lines to compare the others with, where present

# Okabe and Ito's colours without yellow and black, then darker ones of Tol's "muted".
_HUES = (
    "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#882255", "#332288", "#999933",
    "#44AA99", "#661100",
)  # fmt: skip
_MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<", ">", "p", "h")


@dataclass(frozen=True)
class Look:
    """The lines of an agent."""

    colour: str
    marker: str
    dashes: str


def of_agents(agents: Iterable[str]) -> dict[str, Look]:
    """A look for each agent: a variant ("name-something" where there is a "name") is its dashed twin."""
    names = list(dict.fromkeys(agents))
    origin = {name: _origin(name, names) for name in names}
    plain = [name for name in names if origin[name] == name and name not in REFERENCES]
    hues = dict(zip(plain, zip(cycle(_HUES), cycle(_MARKERS), strict=False), strict=False))
    found: dict[str, Look] = {}
    variants: dict[str, int] = {}
    for name in names:
        colour, marker = (
            (REFERENCES[name][0], "x") if name in REFERENCES else hues.get(origin[name], ("", ""))
        )
        if not colour:  # a variant of a reference
            colour, marker = REFERENCES[origin[name]][0], "+"
        rank = variants[origin[name]] = variants.get(origin[name], -1) + 1 if name != origin[name] else 0
        dashes = REFERENCES[name][1] if name in REFERENCES else ("-", "--", ":", "-.")[min(rank, 3)]
        found[name] = Look(colour, marker, dashes)
    return found


def _origin(name: str, names: Sequence[str]) -> str:
    """The shortest other name that this one continues after a hyphen, or the name itself."""
    return min((other for other in names if name.startswith(f"{other}-")), key=len, default=name)


def regularizations(frame: pd.DataFrame) -> list[float]:
    """All regularizations of a frame, the least first."""
    return sorted(float(value) for value in frame["regularization"].unique())


def regularization_label(value: float) -> str:
    """A regularization in words: what the paper calls it, and its epsilon."""
    return f"{'regularized' if value else 'unregularized'} (ε = {value:g})"


def regularization_colours(values: Sequence[float]) -> dict[float, str]:
    """The paper's blue for none and red for the strongest; further colours for the others."""
    others = iter(islice(cycle(_HUES[2:]), len(values)))
    known = {0.0: BLUE, max(values): RED} if max(values) > 0 else {0.0: BLUE}
    return {value: known.get(value) or next(others) for value in values}


def modes_of(frame: pd.DataFrame) -> list[tuple[str, str]]:
    """All pairs of agent and mode of a frame: agents as they first appear, modes in the order of MODES."""
    pairs = set(zip(frame["agent"], frame["mode"], strict=True))
    return [
        (agent, mode)
        for agent in frame["agent"].unique()
        for mode in (*MODES, *sorted({each for _, each in pairs} - set(MODES)))
        if (agent, mode) in pairs
    ]


def places(agents: Sequence[str], columns: int) -> list[int]:
    """Where in a grid each panel goes, row by row: the modes of an agent stay in one row."""
    found: list[int] = []
    for agent in dict.fromkeys(agents):
        count = agents.count(agent)
        first = found[-1] + 1 if found else 0
        if first % columns + count > columns >= count:
            first += columns - first % columns
        found += range(first, first + count)
    return found


def grid(figure: Figure, where: Sequence[int], columns: int) -> list[Axes]:
    """Panels on common axes at these places of a grid; the outer ones have numbers."""
    panels = figure.subplots(
        where[-1] // columns + 1, columns, squeeze=False, sharex=True, sharey=True
    ).ravel()
    for place, axes in enumerate(panels):
        if place not in where:
            axes.remove()
        elif place + columns not in where:
            axes.tick_params(labelbottom=True)
    return [panels[place] for place in where]


def label_bottom(panels: Sequence[Axes], where: Sequence[int], columns: int, label: str) -> None:
    """Label the panels that have nothing below them."""
    for axes, place in zip(panels, where, strict=True):
        if place + columns not in where:
            axes.set_xlabel(label, fontsize=9)


def truncate(name: str, length: int = 24) -> str:
    """A name, cut with an ellipsis if it is longer than `length`."""
    return name if len(name) <= length else name[: length - 1] + "…"


def draw_references(axes: Axes, runs: pd.DataFrame, *, vertical: bool = False) -> None:
    """Draw dashed lines at the speed of the reference agents that are present."""
    for name, (colour, dashes) in REFERENCES.items():
        speeds = select(runs, agent=name)["speed"].dropna().to_numpy(np.float64)
        if speeds.size:
            middle = float(estimates.interquartile_mean(speeds)) * SPEED_SCALE
            line = axes.axvline if vertical else axes.axhline
            line(middle, color=colour, ls=dashes, lw=1.2, zorder=0.5, label=name)


def legend(figure: Figure, panels: Iterable[Axes], columns: int) -> None:
    """Explain what the panels hold, each name once, below the figure."""
    named: dict[str, Artist] = {}
    for axes in panels:
        for handle, name in zip(*axes.get_legend_handles_labels(), strict=True):
            named.setdefault(name, handle)
    figure.legend(
        list(named.values()), list(named), loc="outside lower center", ncols=columns, fontsize=9,
        frameon=False, handlelength=3.2,
    )  # fmt: skip
