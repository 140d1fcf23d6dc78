"""The figures of the speed measurements: tables in, a Matplotlib figure out."""

from pathlib import Path

import pandas as pd
from matplotlib.figure import Figure

from crawler_bench.output.style import BLUE, GREEN, GREY, INK, ORANGE, RED, new_figure, save, tidy
from speed.history import History

COLOURS = {"step": BLUE, "exact": RED}
NAMES = {"step": "in steps of dt", "exact": "from event to event"}
SIZES = {"segments": "segments N", "batch": "crawlers in the batch"}
COLUMNS = 4  # of panels


def draw(history: History, folder: Path) -> None:
    """Draw the commit measured last, and all commits in order."""
    latest = history.latest()
    save(ratios(latest), folder, "ratios")
    for kind, label in SIZES.items():
        save(cost(latest[latest["kind"] == kind], label), folder, kind)
    save(over_commits(history.measurements()), folder, "history")


def ratios(latest: pd.DataFrame) -> Figure:
    """Speed relative to each peer: median, range over repeats, and the goal where there is one."""
    shown = latest[latest["kind"] == "ratio"].iloc[::-1].reset_index(drop=True)
    figure = new_figure(11, 1.2 + 0.42 * len(shown), "Speed relative to peers")
    axes = figure.subplots()
    tidy(
        axes, "median and range of the ratio, in turns on one core; bars: goals (green: met, orange: failed)"
    )
    met, aimless = shown["value"] >= shown["at_least"], shown["at_least"].isna()
    for chosen, colour in ((aimless, BLUE), (met, GREEN), (~met & ~aimless, ORANGE)):
        rows = shown[chosen]
        spread = [rows["value"] - rows["low"], rows["high"] - rows["value"]]
        axes.errorbar(rows["value"], rows.index, xerr=spread, fmt="o", color=colour, capsize=2, ms=5)
    axes.plot(shown["at_least"], shown.index, "|", color=GREY, ms=16, mew=2)
    axes.axvline(1.0, color=GREY, lw=0.8, ls=":")
    axes.set_xscale("log")
    axes.set_yticks(shown.index, (shown["what"] + "\nagainst " + shown["against"]).tolist())
    axes.tick_params(axis="y", labelsize=7)
    axes.set_xlabel("times as many per second as the peer")
    return figure


def cost(table: pd.DataFrame, label: str) -> Figure:
    """Time of a decision over a size, for each integrator, on logarithmic axes.

    Args:
        table: the measurements of one kind.
        label: of the axis of sizes.
    """
    figure = new_figure(6.5, 4.2, f"Cost of a decision over {label}")
    axes = figure.subplots()
    tidy(axes, "one core; a decision is 0.2 tau")
    for integrator, rows in table.groupby("what"):
        name = str(integrator)
        axes.plot(rows["size"], 1e6 * rows["value"], "o-", color=COLOURS[name], label=NAMES[name], ms=4)
    axes.set(xscale="log", yscale="log", xlabel=label, ylabel="time of a decision of one crawler (µs)")
    axes.legend(frameon=False)
    return figure


def over_commits(measurements: pd.DataFrame) -> Figure:
    """Every measurement that has a goal today, over the commits measured: a panel each, goals as lines."""
    keys = ["what", "against", "size"]
    measured = measurements.fillna({"against": "", "unit": "", "size": 0})
    commits = measured.drop_duplicates("date")[["date", "commit"]].reset_index(drop=True)
    places = {date: place for place, date in enumerate(commits["date"])}
    newest = measured[measured["date"] == commits["date"].iloc[-1]]
    goals = newest[newest["at_least"].notna() | newest["at_most"].notna()]
    n_rows = -(-len(goals) // COLUMNS)
    figure = new_figure(3.2 * COLUMNS, 1.2 + 2.0 * n_rows, "Speed over the commits measured")
    panels = figure.subplots(n_rows, COLUMNS, sharex=True, squeeze=False).ravel()
    for place, (axes, goal) in enumerate(zip(panels, goals.to_dict("records"), strict=False)):
        rows = measured[(measured[keys] == [goal[key] for key in keys]).all(axis=1)]
        axes.plot([places[date] for date in rows["date"]], rows["value"], "o-", color=BLUE, ms=4)
        limit, sign = (goal["at_most"], "<=") if pd.isna(goal["at_least"]) else (goal["at_least"], ">=")
        axes.axhline(limit, color=GREY, ls="--", lw=0.8)
        axes.set_ylim(0, 1.1 * max(limit, rows["value"].max()))
        second = f"against {goal['against']}" if goal["against"] else goal["unit"]
        lines = [part for part in (goal["what"], second, f"goal {sign} {limit:g}") if part]
        tidy(axes, "")
        axes.set_title("\n".join(lines), loc="left", fontsize=7, color=INK)
        axes.set_xticks(range(len(commits)), commits["commit"].str[:7], rotation=90)
        axes.tick_params(labelsize=7, labelbottom=place + COLUMNS >= len(goals))
    for axes in panels[len(goals) :]:
        axes.set_axis_off()
    return figure
