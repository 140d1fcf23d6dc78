"""Figures of the search: what can be had for how many constants, and where learning is trapped."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from crawler_bench.output.style import GREY, INK, new_figure, tidy
from crawler_bench.readings.catalogue import FORMER
from crawler_bench.readings.scoring import SCALE

CHOSEN_COLOUR, FORMER_COLOUR = "#d55e00", "#0072b2"


def front(trials: pd.DataFrame, finals: pd.DataFrame) -> Figure:
    """The score of every completed trial against its number of free constants, and of the finalists.

    Args:
        trials: one row per trial, see `search.row`.
        finals: one row per finalist, the chosen one first.
    """
    figure = new_figure(7, 4.5, "How close a reading gets with how few free constants")
    axes: Axes = figure.subplots()
    done = trials[trials["stopped"].fillna("") == ""]
    spread = np.random.default_rng(0).uniform(-0.25, 0.25, len(done))
    axes.scatter(done["free"] + spread, done["score"], s=6, color=GREY, alpha=0.5, label="trials, 10 seeds")
    others = finals[finals["reading"] != FORMER.name]
    axes.scatter(others["free"], others["score"], s=40, color=INK, marker="D", label="finalists, fresh seeds")
    _mark(axes, finals, "free", "score")
    axes.set_xlabel("free constants")
    axes.set_ylabel("score: mean distance to the paper, in tolerances")
    axes.set_ylim(bottom=0)
    axes.legend(frameon=False, fontsize=8)
    tidy(axes, "Lower is nearer to the paper")
    return figure


def trapping(trials: pd.DataFrame, again: pd.DataFrame, finals: pd.DataFrame) -> Figure:
    """Share of runs that end on the diagonal against how fast random action is, one dot per reading."""
    figure = new_figure(7, 4.5, "Readings in which learning succeeds, and pays")
    axes: Axes = figure.subplots()
    spread = np.random.default_rng(0).uniform(-0.02, 0.02, len(trials))
    axes.scatter(
        trials["random_ratio"], trials["on_diagonal"] + spread, s=6, color=GREY, alpha=0.4,
        label="trials, 10 seeds",
    )  # fmt: skip
    axes.scatter(
        again["random_ratio"], again["on_diagonal"], s=22, facecolors="none", edgecolors=INK,
        label="the best of them, 20 fresh seeds",
    )  # fmt: skip
    _mark(axes, finals, "random_ratio", "on_diagonal")
    axes.axvline(SCALE, color=INK, lw=0.8, ls="--")
    axes.axhline(0.8, color=INK, lw=0.8, ls="--")
    axes.set_xlabel("speed of random action relative to the regularized gait")
    axes.set_ylabel("share of runs on the diagonal")
    axes.legend(frameon=False, fontsize=8, loc="lower right")
    tidy(axes, "Wanted: above and left of the dashed lines")
    return figure


def _mark(axes: Axes, finals: pd.DataFrame, x: str, y: str) -> None:
    """The chosen reading and the former default."""
    former = finals[finals["reading"] == FORMER.name]
    chosen = finals.head(1)
    for rows, colour, name in ((chosen, CHOSEN_COLOUR, "chosen"), (former, FORMER_COLOUR, "former default")):
        axes.scatter(rows[x], rows[y], s=90, color=colour, marker="*", zorder=3, label=name)
