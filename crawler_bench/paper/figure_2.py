"""Fig. 2C, the learned policies as matrices of observation and action, and how they were learned."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle
from numpy.typing import NDArray
from scipy.stats import rankdata

from crawler_bench.output import style
from crawler_bench.statistics.estimates import Array

OBSERVATION_LABEL = "most contracted segment\n(observation)"
ACTION_LABEL = "neuron ON (action)"
MOMENTS = 5  # snapshots of learning shown of a run


def policies(tables: Mapping[str, Array], visited: Mapping[str, Sequence[int]]) -> Figure:
    """Fig. 2C: which neuron each policy turns ON at each observation.

    Args:
        tables: (N, N) action probabilities at each observation, of each gait.
        visited: observations that occur in each converged gait.
    """
    figure = style.new_figure(4.6 * len(tables) + 0.6, 5.6, "Fig. 2C. Which neuron each gait turns ON")
    panels = figure.subplots(1, len(tables), squeeze=False)[0]
    for axes, (name, table) in zip(panels, tables.items(), strict=True):
        _draw_policy(axes, table, visited[name])
        on = int((np.diag(table) > 0.5).sum())
        style.tidy(axes, f"{name.capitalize()}: {on} of {len(table)} on the diagonal")
    panels[0].set_ylabel(OBSERVATION_LABEL + ", 1: head")
    wiring = "nearest-neighbour wiring: a segment switches on the neuron ahead"
    handles = [
        Patch(facecolor=style.GREEN, label="action taken in the converged gait"),
        Patch(facecolor=style.LIGHT_GREEN, label="action at an observation that the gait never reaches"),
        Patch(facecolor="none", edgecolor=style.ORANGE, ls="--", label=wiring),
    ]
    figure.legend(handles=handles, loc="outside lower center", fontsize=9, frameon=False)
    return figure


def _draw_policy(axes: Axes, table: Array, visited: Sequence[int]) -> None:
    """Draw probabilities as depth of colour, from white (never taken)."""
    n = len(table)
    reached = np.isin(np.arange(n), list(visited))
    colours = np.where(reached[:, None], to_rgb(style.GREEN), to_rgb(style.LIGHT_GREEN))
    axes.imshow(1 - table[:, :, None] * (1 - colours[:, None, :]), interpolation="nearest")
    for edge in np.arange(0.5, n - 1):
        axes.axhline(edge, color="#e4e4e4", lw=0.6)
        axes.axvline(edge, color="#e4e4e4", lw=0.6)
    for i in range(n):
        axes.add_patch(
            Rectangle((i - 0.45, i - 0.45), 0.9, 0.9, fill=False, edgecolor=style.ORANGE, ls="--", lw=1.3)
        )
    axes.set_xlabel(ACTION_LABEL + ", 0: head")
    style.square(axes, n)


def learning(snapshots: Mapping[str, tuple[NDArray[np.int64], Array]], distances: pd.DataFrame) -> Figure:
    """How the wiring is learned: tables of values along a run, and distance of policies to the diagonal.

    Args:
        snapshots: of one run of each experiment: (K,) decisions and the (K, N, N) tables of values there.
        distances: one row per moment of each run: experiment, seed, decisions, diagonal_distance.
    """
    rows = len(snapshots)
    figure = style.new_figure(11, 3 * rows + 3, "Learning: from equal values to the wiring of a gait")
    grid = figure.add_gridspec(rows + 1, MOMENTS, height_ratios=[1.1] * rows + [1])
    for row, (name, (decisions, tables)) in enumerate(snapshots.items()):
        panels = [figure.add_subplot(grid[row, column]) for column in range(MOMENTS)]
        image = _draw_snapshots(panels, np.asarray(decisions), np.asarray(tables))
        bar = figure.colorbar(image, ax=panels, ticks=[0, 1], pad=0.01, aspect=15, shrink=0.8)
        bar.ax.set_yticklabels(["worst", "best"])
        bar.set_label("rank of the action's value\nat this observation", fontsize=9)
        panels[0].set_ylabel(f"{name.capitalize()} run\n\n" + OBSERVATION_LABEL, fontsize=9)
    greedy = "greedy action (where there is one best)"
    marks = [
        Line2D([], [], ls="", marker="o", color=style.GREEN, mec="white", label=greedy),
        Line2D([], [], ls="--", lw=1, color=style.ORANGE, label="nearest-neighbour wiring"),
    ]
    figure.legend(handles=marks, loc="outside lower center", ncols=2, fontsize=9, frameon=False)
    _draw_distances(figure.add_subplot(grid[rows, :]), distances, next(iter(snapshots.values()))[1].shape[1])
    return figure


def _draw_snapshots(panels: Sequence[Axes], decisions: NDArray[np.int64], tables: Array) -> AxesImage:
    """Draw tables at the start, at the end and between, ever further apart: most is learned early."""
    last = len(decisions) - 1
    chosen = [0, *(round(last / 3**step) for step in reversed(range(MOMENTS - 1)))]
    for axes, moment in zip(panels, chosen, strict=True):
        table = tables[moment]
        n = len(table)
        rank = (rankdata(table, axis=1) - 1) / (n - 1)
        image = axes.imshow(rank, cmap=style.RANK, vmin=0, vmax=1, interpolation="nearest")
        best = table == table.max(axis=1, keepdims=True)
        greedy = np.flatnonzero(best.sum(axis=1) == 1)
        look = {"marker": "o", "ms": 24 / n**0.7, "color": style.GREEN, "mec": "white", "mew": 0.6}
        axes.plot(table[greedy].argmax(axis=1), greedy, ls="", **look)
        axes.plot([-0.5, n - 0.5], [-0.5, n - 0.5], color=style.ORANGE, lw=1, ls="--", zorder=1)
        style.square(axes, n)
        axes.tick_params(labelsize=8, labelleft=axes is panels[0])
        axes.set_xlabel(ACTION_LABEL, fontsize=9)
        axes.set_title(f"after {style.grouped(decisions[moment])} decisions", fontsize=9, color=style.INK)
    return image


def _draw_distances(axes: Axes, distances: pd.DataFrame, n: int) -> None:
    """Draw one faint line per run, and the mean of each experiment."""
    title = "Distance to nearest-neighbour wiring: the mean, and faintly each run"
    style.tidy(axes, title)
    axes.set_xlabel("decisions")
    axes.set_ylabel(f"entries off the\ndiagonal, of {n}")
    axes.set_ylim(-0.03 * n, n * 1.05)
    if distances.empty:
        style.show_missing(axes, "no learning curve")
        return
    for name in (name for name in style.EXPERIMENT_COLOURS if name in set(distances["experiment"])):
        of_experiment = distances[distances["experiment"] == name]
        table = of_experiment.pivot(index="decisions", columns="seed", values="diagonal_distance")
        colour = style.EXPERIMENT_COLOURS[name]
        axes.plot(table.index, table.to_numpy(), color=colour, lw=0.5, alpha=0.25)
        axes.plot(table.index, table.mean(axis=1), color=colour, lw=2, label=name)
    axes.margins(x=0.01)
    axes.xaxis.set_major_formatter(lambda value, _: style.grouped(value))
    axes.legend(fontsize=9, frameon=False, ncols=2)
