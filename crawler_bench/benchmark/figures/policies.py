"""What each agent of a benchmark learned: its policy as a matrix, its gait, and traps."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, PowerNorm
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D

from crawler_bench.benchmark.figures import looks
from crawler_bench.benchmark.keys import GROUP, action_columns, select
from crawler_bench.gait import metrics
from crawler_bench.gait.record import Array, Record
from crawler_bench.output import style
from crawler_bench.output.kymographs import GAIT_DURATION
from crawler_bench.statistics import estimates

PROBABILITY = LinearSegmentedColormap.from_list("probability", ["#ffffff", "#bfe3d3", "#4fa886", style.GREEN])
TRAPPED = LinearSegmentedColormap.from_list("trapped", ["#ffffff", "#c9c9c9", "#4d4d4d"])
_WIDTH = 4  # matrices in a row


def policy_matrices(tables: pd.DataFrame, runs: pd.DataFrame) -> Figure:
    """The mean policy of every agent, mode and regularization; regularizations of an agent side by side."""
    if tables.empty:
        figure = style.new_figure(7.5, 4)
        style.show_missing(figure.add_subplot(), "no policy is a table")
        return figure
    pairs, values = looks.modes_of(tables), looks.regularizations(tables)
    across = max(1, min(_WIDTH // len(values), len(pairs)))
    slots = dict(zip(looks.places([agent for agent, _ in pairs], across), pairs, strict=True))
    columns, rows = across * len(values), max(slots) // across + 1
    height = 2.7 * rows + 1.5
    title = rf"Which neuron each policy turns ON, mean over runs (speed in {style.SPEED_UNIT})"
    figure = style.new_figure(max(2.15 * columns + 1.3, 7.5), height, title)
    panels = figure.subplots(rows, columns, squeeze=False)
    image = None
    for place in range(rows * across):
        row, left = place // across, place % across * len(values)
        for axes, value in zip(panels[row, left : left + len(values)], values, strict=True):
            chosen = tables.iloc[:0]
            if place in slots:
                group = dict(zip(GROUP, (*slots[place], value), strict=True))
                chosen, of_runs = select(tables, **group), select(runs, **group)
            if chosen.empty:
                axes.remove()
                continue
            # The root separates a probability close to that of random action from none at all.
            image = _matrix(axes, _mean_table(chosen), PROBABILITY, PowerNorm(0.5, 0, 1))
            said = _title(slots[place], value, chosen, of_runs)
            axes.set_title(said, loc="left", fontsize=8, color=style.INK)
            axes.tick_params(labelsize=7)
            if place + across not in slots:  # nothing is below it
                axes.set_xlabel("action: neuron ON", fontsize=9)
    assert image is not None
    figure.supylabel("observation: most contracted segment (1: head)", fontsize=10)
    shrink, ticks = min(0.9, 4.5 / height), [0, 0.02, 0.1, 0.25, 0.5, 0.75, 1]
    bar = figure.colorbar(
        image, ax=list(figure.axes), label="mean probability", pad=0.015, aspect=40, shrink=shrink,
        ticks=ticks, format="%g",
    )  # fmt: skip
    bar.ax.minorticks_off()
    _explain_diagonal(figure)
    return figure


def _mean_table(tables: pd.DataFrame) -> Array:
    probabilities = action_columns(tables)
    return tables.groupby("observation")[probabilities].mean().to_numpy(np.float64)


def _title(pair: tuple[str, str], value: float, tables: pd.DataFrame, runs: pd.DataFrame) -> str:
    off = metrics.off_diagonal(_mean_table(tables))
    speed = estimates.estimate(runs["speed"].to_numpy(np.float64) * style.SPEED_SCALE).value
    seeds = tables["seed"].nunique()
    said = f"{looks.truncate(pair[0])}\n{pair[1]}, ε = {value:g}, n = {seeds}\noff the diagonal {off:.2f}"
    return said + (f", speed {speed:.1f}" if np.isfinite(speed) else "")


def _matrix(axes: Axes, table: Array, colours: LinearSegmentedColormap, norm: PowerNorm) -> AxesImage:
    """Draw a matrix with its diagonal outlined."""
    n = len(table)
    image = axes.imshow(table, cmap=colours, norm=norm, interpolation="nearest")
    corners: Array = np.repeat(np.arange(n + 1) - 0.5, 2)
    for x, y in ((corners[1:], corners[:-1]), (corners[:-1], corners[1:])):
        axes.plot(x, y, color=style.ORANGE, lw=1)
    style.square(axes, n)
    return image


def _explain_diagonal(figure: Figure) -> None:
    line = Line2D(
        [],
        [],
        color=style.ORANGE,
        lw=1.2,
        label="the wave: a segment switches on the neuron ahead (nearest-neighbour wiring)",
    )
    figure.legend(handles=[line], loc="outside lower center", fontsize=9, frameon=False)


def trap_matrix(shares: Array) -> Figure:
    """Which pairs of an observation and an action stop the body, from the (N, N) shares of `traps`."""
    figure = style.new_figure(6.2, 6, "Traps: which neuron, held, stops the body where it is")
    axes = figure.add_subplot()
    image = _matrix(axes, shares, TRAPPED, PowerNorm(1, 0, 1))
    count = int((shares >= 0.5).sum())
    style.tidy(axes, f"{count} of {shares.size} pairs stop it from most starts")
    axes.set_xlabel("action: neuron that stays ON (0: head)")
    axes.set_ylabel("observation: most contracted segment (1: head)")
    figure.colorbar(image, ax=axes, label="share of starts after which it stays there", shrink=0.8)
    _explain_diagonal(figure)
    return figure


def gaits(records: Mapping[str, Record]) -> Figure:
    """The strain of every segment against time, in the first 120 tau_theta of each settled gait."""
    shown = {name: record.before(record.time[0] + GAIT_DURATION) for name, record in records.items()}
    columns = min(2, max(len(shown), 1))
    where = looks.places([name.rpartition(", ")[0] or name for name in shown], columns) or [0]
    rows = where[-1] // columns + 1
    title = f"Gaits: strain of each segment (speed in {style.SPEED_UNIT})"
    figure = style.new_figure(max(4.3 * columns + 1, 6.5), 1.6 * rows + 1.3, title)
    panels = looks.grid(figure, where, columns)
    if not shown:
        style.show_missing(panels[0], "no gait")
        return figure
    strains = np.concatenate([record.strain.ravel() for record in shown.values()])
    for axes, (name, record) in zip(panels, shown.items(), strict=True):
        image = style.strain_kymograph(axes, record.time - record.time[0], record.strain)
        axes.set_ylabel("")
        said = f"{looks.truncate(name, 38)}: speed {metrics.speed(record) * style.SPEED_SCALE:.1f}"
        axes.set_title(said, loc="left", fontsize=9, color=style.INK)
        axes.set_xlim(0, max(each.time[-1] - each.time[0] for each in shown.values()))
    looks.label_bottom(panels, where, columns, style.TIME_LABEL)
    figure.supylabel("segment (1: head)", fontsize=10)
    style.colour_bar(panels, image, style.STRAIN_LABEL, strains, aspect=25, shrink=min(1, 1.6 / rows))
    return figure
