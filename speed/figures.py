"""The figures of the speed measurements: tables in, a Matplotlib figure out."""

import pandas as pd
from matplotlib.figure import Figure

from crawler_bench.output.style import BLUE, GREEN, GREY, ORANGE, RED, new_figure, tidy

COLOURS = {"step": BLUE, "exact": RED}
NAMES = {"step": "in steps of dt", "exact": "from event to event"}


def ratios(table: pd.DataFrame) -> Figure:
    """Speed relative to each peer: median, range over repeats, and the goal where there is one."""
    shown = table[table["repeats"] > 0].iloc[::-1].reset_index(drop=True)
    figure = new_figure(11, 1.2 + 0.42 * len(shown), "Speed relative to peers")
    axes = figure.subplots()
    tidy(
        axes,
        "median and range of the ratio, in turns on one core; bars: goals (green: met, orange: missed)",
    )
    met, aimless = shown["ratio"] >= shown["goal"], shown["goal"].isna()
    for chosen, colour in ((aimless, BLUE), (met, GREEN), (~met & ~aimless, ORANGE)):
        rows = shown[chosen]
        spread = [rows["ratio"] - rows["ratio_min"], rows["ratio_max"] - rows["ratio"]]
        axes.errorbar(rows["ratio"], rows.index, xerr=spread, fmt="o", color=colour, capsize=2, ms=5)
    axes.plot(shown["goal"], shown.index, "|", color=GREY, ms=16, mew=2)
    axes.axvline(1.0, color=GREY, lw=0.8, ls=":")
    axes.set_xscale("log")
    axes.set_yticks(shown.index, (shown["what"] + "\nagainst " + shown["peer"]).tolist())
    axes.tick_params(axis="y", labelsize=7)
    axes.set_xlabel("times as many per second as the peer")
    return figure


def cost(table: pd.DataFrame, over: str, label: str, title: str) -> Figure:
    """Time of a decision against a size.

    Args:
        table: integrator, the column `over`, seconds.
        over: name of the column of sizes.
        label: of the axis of sizes.
        title: of the figure.
    """
    figure = new_figure(6.5, 4.2, title)
    axes = figure.subplots()
    tidy(axes, "one core; a decision is 0.2 tau")
    for integrator, rows in table.groupby("integrator"):
        name = str(integrator)
        axes.plot(rows[over], 1e6 * rows["seconds"], "o-", color=COLOURS[name], label=NAMES[name], ms=4)
    if over == "segments":
        first, last = table[over].min(), table[over].max()
        low = 1e6 * table["seconds"].min()
        axes.plot([first, last], [low, low * last / first], ":", color=GREY, label="proportional to N")
    axes.set(xscale="log", yscale="log", xlabel=label, ylabel="time of a decision of one crawler (µs)")
    axes.legend(frameon=False)
    return figure
