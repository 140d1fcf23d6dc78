"""Fig. 3, the gaits compared: power, duration of a cycle, and speed against noise."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
import seaborn as sns
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm
from matplotlib.figure import Figure

from crawler_bench.output import style
from crawler_bench.statistics import estimates
from crawler_bench.statistics.estimates import Array

BEYOND = 0.12  # of a cycle that is shown again on either side
ORDINARY = (0.5, 99.5)  # percentiles of the cycles between which the axis of Fig. 3B ends


def power_by_phase(phased: Mapping[str, Array]) -> Figure:
    """Fig. 3A: the power of each node against the phase of the cycle.

    Args:
        phased: (cycles, phases, N + 1) power of each gait, k L^2 / tau_theta; NaN where there is no sample,
            no cycles where none was found.
    """
    title = "Fig. 3A. Power of each node in the course of a cycle"
    figure = style.new_figure(9, 3.1 * len(phased) + 0.6, title)
    panels = figure.subplots(len(phased), 1, squeeze=False, sharex=True, sharey=True)[:, 0]
    nodes = max(cycles.shape[2] for cycles in phased.values())
    colours = style.NODES(np.linspace(0, 1, nodes))
    for axes, (name, cycles) in zip(panels, phased.items(), strict=True):
        found = f"each cycle (thin, {len(cycles)} in all) and their mean" if len(cycles) else "no cycle found"
        style.tidy(axes, f"{name.capitalize()}: {found}")
        axes.set_ylabel("power of a node\n" + r"($k\,L^2/\tau_\theta$)")
        if len(cycles) == 0:
            style.show_missing(axes, "no cycle found")
            continue
        _draw_power(axes, cycles, colours)
    panels[0].set(xlim=(-BEYOND, 1 + BEYOND))
    panels[0].set_ylim(bottom=0)
    panels[-1].set_xlabel("phase of the cycle (0: a new wave begins; shaded: the neighbouring cycles)")
    scale = ScalarMappable(BoundaryNorm(np.arange(nodes + 1) - 0.5, style.NODES.N), style.NODES)
    bar = figure.colorbar(
        scale, ax=list(panels), label="node (0 = head)", ticks=style.part_ticks(nodes), pad=0.02, aspect=30
    )
    bar.ax.invert_yaxis()
    bar.ax.minorticks_off()
    return figure


def _draw_power(axes: Axes, cycles: Array, colours: Array) -> None:
    """Draw every cycle with the ends of its neighbours, so that a peak at phase 0 is seen whole."""
    count = cycles.shape[1]
    beyond = round(BEYOND * count)
    phase = (np.arange(-beyond, count + beyond) + 0.5) / count
    mean = np.ma.masked_invalid(cycles).mean(axis=0).filled(np.nan)
    around = np.concatenate([mean[count - beyond :], mean, mean[:beyond]])
    unknown = np.full((1, beyond, cycles.shape[2]), np.nan)
    before = np.concatenate([unknown, cycles[:-1, count - beyond :]])
    after = np.concatenate([cycles[1:, :beyond], unknown])
    extended = np.concatenate([before, cycles, after], axis=1)
    for node in range(cycles.shape[2]):
        axes.plot(phase, extended[:, :, node].T, color=colours[node], lw=0.4, alpha=0.35)
        axes.plot(phase, around[:, node], color=colours[node], lw=1.8)
    for side in ((-BEYOND, 0), (1, 1 + BEYOND)):
        axes.axvspan(*side, color=style.INK, alpha=0.06, lw=0)


def cycle_durations(cycles: pd.DataFrame) -> Figure:
    """Fig. 3B: the duration of a cycle.

    Args:
        cycles: one row per cycle: experiment, seed, start, duration (tau_theta).
    """
    title = "Fig. 3B. Duration of a cycle: one wave of contraction through the body"
    figure = style.new_figure(8, 4.6, title)
    histogram, runs = figure.subplots(2, 1, sharex=True, height_ratios=(2.6, 1))
    style.tidy(histogram, "Cycles of all runs")
    style.tidy(runs, "Mean of each training run (dots); over runs, with its 95 % interval (bar)")
    histogram.set_ylabel("share of cycles (%)")
    runs.set_xlabel(r"duration ($\tau_\theta$)")
    if cycles.empty:
        style.show_missing(histogram, "no cycle found")
        runs.set_ylabel("gait")
        return figure
    names = [name for name in style.EXPERIMENT_COLOURS if name in set(cycles["experiment"])]
    look: dict[str, Any] = {"hue": "experiment", "hue_order": names, "palette": style.EXPERIMENT_COLOURS}
    sns.histplot(
        cycles, x="duration", stat="percent", common_norm=False, bins=_bins(cycles["duration"].to_numpy()),
        element="step", alpha=0.4, ax=histogram, **look,
    )  # fmt: skip
    histogram.get_legend().set(title=None, frame_on=False)
    _draw_run_means(runs, cycles, names)
    _inset_all(histogram, cycles, look)
    return figure


def _inset_all(axes: Axes, cycles: pd.DataFrame, look: dict[str, Any]) -> None:
    """End the axis where nearly all cycles do, and draw all of them, the rare ones too, in an inset."""
    durations = cycles["duration"].to_numpy(np.float64)
    means = cycles.groupby(["experiment", "seed"])["duration"].mean()
    low, high = np.percentile(durations, ORDINARY)
    low, high = min(low, means.min()), max(high, means.max())
    spread = max(high - low, 1.0)
    if durations.max() - durations.min() < 1.5 * spread:
        return
    axes.set_xlim(low - 0.05 * spread, high + 0.5 * spread)  # room for legend and inset
    inset = axes.inset_axes((0.72, 0.28, 0.27, 0.42))
    sns.histplot(
        cycles, x="duration", bins=_bins(durations), element="step", alpha=0.4, ax=inset, legend=False, **look
    )
    inset.set_yscale("log")
    inset.tick_params(labelsize=7)
    inset.set_xlabel(r"all cycles ($\tau_\theta$)", fontsize=8)
    inset.set_ylabel("number", fontsize=8)


def _draw_run_means(axes: Axes, cycles: pd.DataFrame, names: list[str]) -> None:
    """Draw one dot per run, and their mean with its interval."""
    means = cycles.groupby(["experiment", "seed"])["duration"].mean()
    for row, name in enumerate(names):
        of_runs, colour = np.sort(means[name].to_numpy()), style.EXPERIMENT_COLOURS[name]
        shift = 0.2 * (np.arange(of_runs.size) % 3 - 1)  # to separate equal runs
        axes.plot(of_runs, row + shift, ls="", marker="o", ms=5, color=colour, alpha=0.5, mew=0)
        mean = estimates.estimate(of_runs, statistic=np.mean)
        style.mark_middle(axes, mean, row, ms=14)
    axes.set(yticks=range(len(names)), yticklabels=names, ylim=(len(names) - 0.5, -0.5))


def _bins(durations: Array) -> Array:
    """Edges of at most about forty bins of whole tau_theta that hold all durations."""
    low, high = np.floor(durations.min()), np.ceil(durations.max())
    width = max(1.0, np.ceil((high - low) / 40))
    edges: Array = np.arange(low - 0.5 * width, high + 1.5 * width, width)
    return edges


def speed_against_noise(evaluations: pd.DataFrame, crossover: tuple[float, float, float]) -> Figure:
    """Fig. 3C: speed against proprioceptive noise.

    Args:
        evaluations: one row per run, noise and start: experiment, seed, noise, start, speed
            (L / tau_theta), stalled.
        crossover: noise from which on the regularized gait is the faster one, and its interval; NaN if there
            is none.
    """
    figure = style.new_figure(8, 4.8, "Fig. 3C. Speed against proprioceptive noise")
    axes = figure.add_subplot()
    runs = evaluations.groupby(["experiment", "seed", "noise"], as_index=False)["speed"].mean()
    for name in (name for name in style.EXPERIMENT_COLOURS if name in set(runs["experiment"])):
        table = runs[runs["experiment"] == name].pivot(index="noise", columns="seed", values="speed")
        _draw_speed(axes, name, table * style.SPEED_SCALE)
    value, low, high = crossover
    if np.isfinite(value):
        label = f"the regularized gait is faster from {value:.3f} on"
        axes.axvline(value, color=style.INK, lw=1, ls=":", label=label)
        if np.isfinite([low, high]).all():
            axes.axvspan(low, high, color=style.INK, alpha=0.1, lw=0, label="95 % interval of this crossover")
    axes.set_xlabel("largest error $s$ of a sensed strain (noise)")
    axes.set_ylabel(style.SPEED_LABEL)
    axes.margins(x=0.01)
    style.tidy(axes, "Mean over training runs with its 95 % interval; faint: each run")
    axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
    figure.legend(loc="outside lower center", ncols=2, fontsize=9, frameon=False)
    return figure


def _draw_speed(axes: Axes, name: str, table: pd.DataFrame) -> None:
    """Draw the speeds (noise, run) of one experiment."""
    colour, dashes = style.EXPERIMENT_COLOURS[name], "--" if name == "untrained" else "-"
    noise = table.index.to_numpy()
    if table.shape[1] > 1:
        axes.plot(noise, table.to_numpy(), color=colour, lw=0.5, alpha=0.25, ls=dashes)
    means = [estimates.estimate(row, statistic=np.mean) for row in table.to_numpy()]
    count = f"{table.shape[1]} run{'s' if table.shape[1] > 1 else ''}"
    label = f"random action ({count})" if name == "untrained" else f"{name} ({count})"
    style.band(axes, noise, means, alpha=0.2, color=colour, lw=2, ls=dashes, label=label)
