"""Lines of a `Benchmark`: speed against noise, against decisions, and against the temperature of a policy."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from crawler_bench.benchmark.figures import looks
from crawler_bench.benchmark.keys import RUN, select
from crawler_bench.output import style
from crawler_bench.statistics import estimates
from crawler_bench.statistics.estimates import Array

Looks = dict[str, looks.Look]
MIDDLE = ":\ninterquartile mean, 95 % interval"
OVERTAKES = "from here on the strongest regularization is the faster one (shaded: 95 % interval)"


def noise_curves(evaluations: pd.DataFrame) -> Figure:
    """Speed against proprioceptive noise, the paper's Fig. 3C for every agent and mode.

    A line marks where the mean curve of the strongest regularization overtakes that of the weakest.
    """
    of_runs = evaluations.groupby([*RUN, "noise"], sort=False)["speed"].mean().reset_index()
    pairs, values = looks.modes_of(of_runs), looks.regularizations(of_runs)
    columns = min(4, len(pairs))
    where = looks.places([agent for agent, _ in pairs], columns)
    rows = where[-1] // columns + 1
    width, height = max(2.35 * columns + 0.8, 6.5), 2.1 * rows + 1.7
    figure = style.new_figure(width, height, "Speed against proprioceptive noise")
    panels = looks.grid(figure, where, columns)
    colours, drawn = looks.regularization_colours(values), {}
    for axes, (agent, mode) in zip(panels, pairs, strict=True):
        style.tidy(axes, "")
        axes.set_title(f"{looks.truncate(agent, 17)},\n{mode}", loc="left", fontsize=9, color=style.INK)
        chosen = select(of_runs, agent=agent, mode=mode)
        tables = {
            float(str(value)): rows.pivot(index="noise", columns="seed", values="speed") * style.SPEED_SCALE
            for value, rows in chosen.groupby("regularization")
        }
        for value, table in tables.items():
            means = [estimates.estimate(row, statistic=np.mean) for row in table.to_numpy()]
            strongest = value == values[-1] and len(values) > 1
            # Where they are equal, the wider line shows on both sides of the narrower one.
            marker, size, width = ("s", 3, 1.6) if strongest else ("o", 5, 3)
            look: dict[str, Any] = {"color": colours[value], "marker": marker, "ms": size, "lw": width}
            label = looks.regularization_label(value)
            style.band(axes, table.index.to_numpy(np.float64), means, label=label, **look)
        looks.draw_references(axes, select(of_runs, agent="random"))  # it senses nothing: its curve is level
        drawn[axes] = tables
    panels[0].set_ylim(bottom=min(0.0, panels[0].get_ylim()[0]))
    for axes, tables in drawn.items():
        if len(tables) > 1:
            _mark_crossover(axes, tables[max(tables)], tables[min(tables)])
    panels[0].margins(x=0.03)
    looks.label_bottom(panels, where, columns, "largest error $s$ of\na sensed strain (noise)")
    figure.supylabel(style.SPEED_LABEL + ", mean over runs and its 95 % interval", fontsize=10)
    looks.legend(figure, panels, 3)
    return figure


def _mark_crossover(axes: Axes, strongest: pd.DataFrame, weakest: pd.DataFrame) -> None:
    """Draw a dotted line where the strongest regularization becomes the faster one, over paired runs."""
    seeds = strongest.columns.intersection(weakest.columns)
    noise = strongest.index.intersection(weakest.index)
    rising, falling = (
        table.loc[noise, seeds].dropna(axis=1).to_numpy(np.float64).T for table in (strongest, weakest)
    )
    if len(rising) == 0 or rising.shape != falling.shape:
        return
    found, _ = estimates.crossover(noise.to_numpy(np.float64), rising, falling)
    if np.isfinite(found.value):
        axes.axvline(found.value, color=style.INK, lw=1, ls=":", label=OVERTAKES)
        if np.isfinite([found.low, found.high]).all():
            axes.axvspan(found.low, found.high, color=style.INK, alpha=0.08, lw=0)
        # The number goes where there is room: away from the curves and from the panel's edge.
        low_curves = np.concatenate([rising, falling]).mean() < 0.5 * axes.get_ylim()[1]
        late = found.value > 0.5 * noise.max()
        axes.text(
            found.value, 0.88 if low_curves else 0.04, f" {found.value:.3f} ", fontsize=8,
            color=style.INK, ha="right" if late else "left", transform=axes.get_xaxis_transform(),
        )  # fmt: skip


def learning_curves(
    curves: pd.DataFrame, runs: pd.DataFrame | None = None, agents: Sequence[str] = ()
) -> Figure:
    """Speed while learning, exploration included, against decisions.

    Args:
        curves: of `Benchmark`.
        runs: of `Benchmark`; the reference agents among them are drawn as lines.
        agents: all names of the benchmark, so that an agent looks the same in every figure.
    """
    values = looks.regularizations(curves) if len(curves) else [0.0]
    figure = style.new_figure(1.2 + 4.4 * len(values), 5.2, "Speed while learning")
    panels = figure.subplots(1, len(values), squeeze=False, sharex=True, sharey=True)[0]
    if curves.empty:
        style.show_missing(panels[0], "no agent learned")
        panels[0].set(xlabel="decisions", ylabel=style.SPEED_LABEL)
        return figure
    look_of = looks.of_agents([*agents, *curves["agent"]])
    for axes, value in zip(panels, values, strict=True):
        style.tidy(axes, looks.regularization_label(value).capitalize() + MIDDLE)
        axes.set_xlabel("decisions")
        for agent, rows in select(curves, regularization=value).groupby("agent", sort=False):
            windows = rows.assign(window=rows.groupby("seed").cumcount()).groupby("window")
            speeds = [estimates.estimate(each * style.SPEED_SCALE) for _, each in windows["speed"]]
            at = windows["decisions"].mean().to_numpy(np.float64)
            style.band(axes, at, speeds, **_line(str(agent), look_of[str(agent)], max(1, len(at) // 8)))
        if runs is not None:
            looks.draw_references(axes, select(runs, regularization=value))
        axes.margins(x=0.01)
        axes.xaxis.set_major_formatter(lambda value, _: style.grouped(value))
    panels[0].set_ylabel(style.SPEED_LABEL)
    panels[0].set_ylim(bottom=min(0.0, panels[0].get_ylim()[0]))
    looks.legend(figure, panels, 5)
    return figure


def softening(frame: pd.DataFrame, stuck: pd.DataFrame, agents: Sequence[str] = ()) -> Figure:
    """Speed of learned policies against temperature, and the traps of their deterministic versions.

    Args:
        frame: of `speed_against_temperature`.
        stuck: of `stuck_observations`.
        agents: all names of the benchmark, so that an agent looks the same in every figure.
    """
    values = sorted({*looks.regularizations(frame), *looks.regularizations(stuck)})
    names = list(dict.fromkeys([*agents, *stuck["agent"], *frame["agent"]]))
    rows = [name for name in names if name in set(stuck["agent"])]
    low = 1.1 + 0.28 * max(len(rows), 1)
    title = "From favourite actions alone to random action"
    figure = style.new_figure(1.2 + 5.2 * len(values), 4.9 + low, title)
    grid_of = figure.subplots(
        2, len(values), squeeze=False, sharex="row", sharey="row", height_ratios=(3.4, low)
    )
    look_of = looks.of_agents(names)
    for value, above, below in zip(values, *grid_of, strict=True):
        style.tidy(above, looks.regularization_label(value).capitalize() + MIDDLE)
        _draw_temperatures(above, select(frame, regularization=value), frame["temperature"], look_of)
        style.tidy(below, "Fixed points: observations whose action stops the body there")
        _draw_stuck(below, select(stuck, regularization=value), rows, look_of)
    grid_of[0, 0].set_ylabel(style.SPEED_LABEL)
    grid_of[0, 0].set_ylim(bottom=min(0.0, grid_of[0, 0].get_ylim()[0]))
    grid_of[1, 0].set_ylabel("deterministic\npolicy of")
    looks.legend(figure, grid_of[0], 5)
    return figure


def temperature_places(temperatures: Array) -> Array:
    """Positions of temperatures on the axis: the binary logarithm, with 0 and infinity beyond the others."""
    finite = temperatures[(temperatures > 0) & np.isfinite(temperatures)]
    first, last = (np.log2([finite.min(), finite.max()])) if finite.size else (0.0, 0.0)
    with np.errstate(divide="ignore"):
        return np.asarray(np.clip(np.log2(temperatures), first - 1.5, last + 1.5))


def _draw_temperatures(axes: Axes, frame: pd.DataFrame, every: pd.Series, look_of: Looks) -> None:
    """Draw one line per agent; the axis is broken before 0 and infinity."""
    known: Array = np.unique(every.to_numpy(np.float64))
    places = dict(zip(known, temperature_places(known), strict=True))
    for agent, rows in frame.groupby("agent", sort=False):
        of = rows.groupby("temperature")["speed"]
        x: Array = np.array([places[float(str(temperature))] for temperature, _ in of])
        speeds = [estimates.estimate(each * style.SPEED_SCALE) for _, each in of]
        style.band(axes, x, speeds, **_line(str(agent), look_of[str(agent)], 1))
    for temperature in (each for each in known if each in (0, np.inf)):
        axes.axvline(
            places[temperature] + (0.75 if temperature == 0 else -0.75), color="white", lw=6, zorder=4
        )
    if 1 in places:
        axes.axvline(0, color=style.INK, lw=0.8, ls=":", zorder=0.5)
    named = {0.0: "0\nfavourite\naction", 1.0: "1\nas\nlearned", np.inf: "∞\nrandom\naction"}
    between = known[(known > 0) & np.isfinite(known)]
    others = [*between[between < 1][::2], *between[between > 1][::-1][::2]]  # all would be crowded
    labels = {float(each): _fraction(each) for each in others}
    labels |= {each: text for each, text in named.items() if each in places}
    axes.set_xticks([places[each] for each in labels], list(labels.values()))
    axes.set_xlabel("temperature $T$ of the policy, $p^{1/T}$")


def _fraction(value: float) -> str:
    return f"1/{1 / value:g}" if value < 1 and (1 / value).is_integer() else f"{value:g}"


def _draw_stuck(axes: Axes, stuck: pd.DataFrame, names: Sequence[str], look_of: Looks) -> None:
    """Draw one dot per run, and the interquartile mean with its interval."""
    for row, name in enumerate(names):
        counts = np.sort(select(stuck, agent=name)["stuck"].to_numpy(np.float64))
        # Counts are whole numbers: equal ones are heaped.
        same = np.array([(counts[:i] == count).sum() for i, count in enumerate(counts)], dtype=np.int64)
        x, y = counts + 0.13 * (same // 3), row + np.array([0, -0.22, 0.22])[same % 3]
        axes.plot(x, y, ls="", alpha=0.55, mew=0, ms=5, marker="o", color=look_of[name].colour)
        style.mark_middle(axes, estimates.estimate(counts), row, ms=11, capsize=2, lw=1, zorder=2)
    axes.set(
        yticks=range(len(names)),
        yticklabels=[looks.truncate(name) for name in names],
        ylim=(len(names) - 0.4, -0.6),
    )
    axes.set_xlim(-0.5, max(10.5, float(stuck["stuck"].max()) + 1 if len(stuck) else 0))
    axes.set_xlabel("fixed points of a run (dots; bar: interquartile mean)")


def _line(agent: str, look: looks.Look, every: int) -> dict[str, Any]:
    """How to draw an agent's line."""
    known = {"color": look.colour, "ls": look.dashes, "label": looks.truncate(agent), "lw": 1.8}
    if agent in looks.REFERENCES:
        return known
    return known | {"marker": look.marker, "ms": 4.5, "markevery": every}
