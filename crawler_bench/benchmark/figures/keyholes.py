"""Figures of what seeing and remembering are worth, and of how the runs of an agent are spread."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from crawler_bench.benchmark.figures import looks
from crawler_bench.benchmark.figures.scores import MODE_LOOKS
from crawler_bench.benchmark.keyholes import ORDER
from crawler_bench.benchmark.keys import select
from crawler_bench.output import style

_NAMES = {"score": "score (random 0, best table 1)", "reward": "reward per decision (L)"}


def worth(rows: pd.DataFrame, ceilings: pd.DataFrame) -> Figure:
    """Reward at each keyhole, and with a memory; lines are the ceilings.

    Args:
        rows: of `keyholes.keyhole_worth`.
        ceilings: of `ceilings.find_ceilings`; empty draws none.
    """
    shown = select(rows, metric="reward")
    algorithms, levels = list(dict.fromkeys(shown["algorithm"])), looks.regularizations(shown)
    size = (1.4 + 3.6 * max(len(algorithms), 1), 1.6 + 2.7 * max(len(levels), 1))
    figure = style.new_figure(*size, "What seeing more and remembering are worth")
    if shown.empty:
        style.show_missing(figure.add_subplot(), "no agent at two keyholes")
        return figure
    panels = figure.subplots(len(levels), len(algorithms), squeeze=False, sharex=True, sharey="row")
    places = [*ORDER, "index,\nmemory"]
    for line, level in zip(panels, levels, strict=True):
        for axes, algorithm in zip(line, algorithms, strict=True):
            style.tidy(axes, f"{algorithm}, ε = {level:g}")
            axes.set_xticks(range(len(places)), places, fontsize=8)
            _ceilings(axes, ceilings, level)
            here = select(shown, algorithm=algorithm, regularization=level)
            for shift, (mode, (colour, marker)) in zip((-0.12, 0.12), MODE_LOOKS.items(), strict=True):
                chosen = select(here, mode=mode)
                at = [
                    len(ORDER) if memory else ORDER.index(name)
                    for name, memory in chosen[["keyhole", "memory"]].to_numpy()
                ]
                values = chosen[["value", "low", "high"]].to_numpy(np.float64)
                error = np.abs(values[:, 1:].T - values[:, 0])
                axes.errorbar(
                    np.array(at) + shift, values[:, 0], error, ls="", marker=marker, color=colour, label=mode
                )
        line[0].set_ylabel(_NAMES["reward"])
    looks.legend(figure, panels.ravel().tolist(), 5)
    return figure


def _ceilings(axes: Axes, ceilings: pd.DataFrame, level: float) -> None:
    if ceilings.empty:
        return
    for kind, dashes in (("random", "--"), ("table", "-."), ("stochastic table", ":"), ("state", "-")):
        label = kind if kind == "random" else f"best {kind}"
        for value in select(ceilings, kind=kind, regularization=level, noise=0.0)["reward"]:
            axes.axhline(value, color=style.GREY, ls=dashes, lw=1, zorder=0.5, label=label)


def profiles(frame: pd.DataFrame, agents: list[str]) -> Figure:
    """Share of the runs of every agent that score more than each threshold."""
    levels = looks.regularizations(frame)
    modes = list(dict.fromkeys(frame["mode"]))
    size = (1.2 + 4.6 * len(levels), 1.8 + 3.0 * len(modes))
    figure = style.new_figure(*size, "Performance profiles: share of runs above a threshold, 95 % interval")
    panels = figure.subplots(len(modes), len(levels), squeeze=False, sharey=True, sharex="col")
    look_of = looks.of_agents(agents)
    for line, mode in zip(panels, modes, strict=True):
        for axes, level in zip(line, levels, strict=True):
            style.tidy(axes, f"{mode}, ε = {level:g}")
            for agent, rows in select(frame, mode=mode, regularization=level).groupby("agent", sort=False):
                look = look_of[str(agent)]
                axes.step(
                    rows["threshold"],
                    rows["share"],
                    color=look.colour,
                    ls=look.dashes,
                    where="post",
                    label=agent,
                )
                axes.fill_between(
                    rows["threshold"],
                    rows["low"],
                    rows["high"],
                    color=look.colour,
                    alpha=0.1,
                    lw=0,
                    step="post",
                )
        line[0].set_ylabel("share of runs")
    for axes in panels[-1]:
        axes.set_xlabel(_NAMES[str(frame["of"].iloc[0])])
    looks.legend(figure, panels.ravel().tolist(), 4)
    return figure
