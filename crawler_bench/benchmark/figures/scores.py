"""Dots of a `Benchmark`: how fast each frozen policy crawls, and how long a cycle of its gait takes."""

from collections.abc import Iterator

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from crawler_bench.benchmark.figures import looks
from crawler_bench.benchmark.keys import DETERMINISTIC, STOCHASTIC, select
from crawler_bench.output import style
from crawler_bench.statistics import estimates
from crawler_bench.statistics.estimates import Array

MODE_LOOKS = {DETERMINISTIC: (style.BLUE, "o"), STOCHASTIC: (style.ORANGE, "D")}
_OTHER_MODE = ("#009E73", "s")
_SMOOTHING = 0.6  # tau_theta, least width of the kernel of a density


def speeds(runs: pd.DataFrame) -> Figure:
    """Speed of every agent's frozen policy, in every mode."""
    figure, panels, rows = _rows(runs, "Speed of the frozen policies, without noise")
    for axes, value in zip(panels, looks.regularizations(runs), strict=True):
        style.tidy(axes, looks.regularization_label(value).capitalize())
        axes.set_xlabel(style.SPEED_LABEL)
        here = select(runs, regularization=value)
        looks.draw_references(axes, here, vertical=True)
        for (agent, mode), row in rows.items():
            chosen = select(here, agent=agent, mode=mode).sort_values("seed")
            _dots(axes, chosen["speed"].to_numpy(np.float64) * style.SPEED_SCALE, row, mode)
        axes.set_xlim(left=1.05 * min(0.0, float(runs["speed"].min()) * style.SPEED_SCALE))
    present = [name for name in looks.REFERENCES if name in set(runs["agent"])]
    lines = [
        Line2D([], [], color=looks.REFERENCES[name][0], ls=looks.REFERENCES[name][1], label=f"{name} (IQM)")
        for name in present
    ]
    _explain(figure, runs, lines)
    return figure


def cycle_durations(cycles: pd.DataFrame, runs: pd.DataFrame) -> Figure:
    """How long a wave of contraction takes through the body, for the agents that have waves.

    The runs name the agents that have none.
    """
    figure, panels, rows = _rows(runs, "Duration of a cycle: one wave of contraction through the body")
    for axes, value in zip(panels, looks.regularizations(runs), strict=True):
        style.tidy(axes, f"{looks.regularization_label(value).capitalize()}\nright: runs with a wave, of all")
        axes.set_xlabel(r"duration of a cycle ($\tau_\theta$)")
        axes.set_xlim(0, _longest(cycles) * 1.05)
        for (agent, mode), row in rows.items():
            group = {"agent": agent, "mode": mode, "regularization": value}
            run, cycle = select(runs, **group), select(cycles, **group)
            if run.empty:
                continue
            _say(axes, 1.01, row, f"{cycle['seed'].nunique()}/{run['seed'].nunique()}")
            if cycle.empty:
                _say(axes, 0.02, row, "no wave")
                continue
            _violin(axes, cycle["duration"].to_numpy(np.float64), row, mode)
            _dots(axes, cycle.groupby("seed")["duration"].mean().to_numpy(np.float64), row, mode)
    _explain(figure, runs, [Line2D([], [], color=style.INK, alpha=0.25, lw=7, label="all cycles")])
    return figure


def _rows(runs: pd.DataFrame, title: str) -> tuple[Figure, list[Axes], dict[tuple[str, str], float]]:
    """One panel per regularization with one row per agent and mode, and the height of each row."""
    rows, ticks, place = {}, {}, 0.0
    for agent, modes in _by_agent(runs):
        at = place + np.arange(len(modes)) * 0.75
        rows.update({(agent, mode): float(y) for mode, y in zip(modes, at, strict=True)})
        ticks[agent], place = float(at.mean()), float(at[-1]) + 1.15
    values = looks.regularizations(runs)
    figure = style.new_figure(2.0 + 3.8 * len(values), 2.1 + 0.36 * place, title)
    panels = list(figure.subplots(1, len(values), squeeze=False, sharex=True, sharey=True)[0])
    for axes in panels:
        axes.set(
            yticks=list(ticks.values()),
            yticklabels=[looks.truncate(name) for name in ticks],
            ylim=(place - 0.5, -0.65),
        )
        for one, other in zip(list(rows)[:-1], list(rows)[1:], strict=True):
            if one[0] != other[0]:
                axes.axhline((rows[one] + rows[other]) / 2, color="#ececec", lw=0.8, zorder=0)
    panels[0].set_ylabel("agent")
    return figure, panels, rows


def _by_agent(runs: pd.DataFrame) -> Iterator[tuple[str, list[str]]]:
    pairs = looks.modes_of(runs)
    for agent in dict(pairs):
        yield agent, [mode for name, mode in pairs if name == agent]


def _dots(axes: Axes, values: Array, row: float, mode: str) -> None:
    """Draw one dot per run, and their interquartile mean with its interval."""
    colour, marker = MODE_LOOKS.get(mode, _OTHER_MODE)
    shift = 0.13 * (np.arange(values.size) % 3 - 1)  # to separate equal runs
    axes.plot(values, row + shift, ls="", marker=marker, ms=4.5, color=colour, alpha=0.5, mew=0)
    style.mark_middle(axes, estimates.estimate(values), row, ms=13)


def _violin(axes: Axes, durations: Array, row: float, mode: str) -> None:
    """Draw the density of all cycles, as high at its peak as a row allows."""
    width = max(_SMOOTHING, 0.9 * float(durations.std()) * durations.size**-0.2)
    at: Array = np.linspace(max(durations.min() - 3 * width, 0), durations.max() + 3 * width, 400)
    density = np.exp(-0.5 * ((at[:, None] - durations) / width) ** 2).sum(axis=1)
    half = 0.36 * density / density.max()
    colour = MODE_LOOKS.get(mode, _OTHER_MODE)[0]
    axes.fill_between(at, row - half, row + half, color=colour, alpha=0.2, lw=0)


def _longest(cycles: pd.DataFrame) -> float:
    return float(cycles["duration"].max()) if len(cycles) else 50.0


def _say(axes: Axes, x: float, row: float, text: str) -> None:
    slant = "italic" if x < 1 else "normal"
    place = axes.get_yaxis_transform()
    axes.text(x, row, text, transform=place, va="center", fontsize=8, color=style.INK, style=slant)


def _explain(figure: Figure, runs: pd.DataFrame, more: list[Line2D]) -> None:
    handles = [
        Line2D([], [], ls="", marker=marker, color=colour, alpha=0.6, mew=0, label=f"a run, {mode}")
        for mode in dict.fromkeys(mode for _, mode in looks.modes_of(runs))
        for colour, marker in [MODE_LOOKS.get(mode, _OTHER_MODE)]
    ]
    mean = Line2D([], [], color=style.INK, marker="|", ms=11, label="interquartile mean, 95 % interval")
    handles += [mean, *more]
    figure.legend(
        handles=handles, loc="outside lower center", ncols=min(len(handles), 3), fontsize=9, frameon=False
    )
