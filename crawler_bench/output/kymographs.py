"""One record against time: positions, strains and muscle forces."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from crawler_bench.gait.record import Array, Record
from crawler_bench.output import style

GAIT_DURATION = 120.0  # tau_theta of a gait that are shown: three to five cycles


def gait(record: Record, title: str) -> Figure:
    """Fig. 2A and 2B: position and strain of each segment, and the force of each muscle.

    Args:
        record: of the settled gait; its first 120 tau_theta are shown, counted from 0.
        title: of the figure.
    """
    record = record.before(record.time[0] + GAIT_DURATION)
    time = record.time - record.time[0]
    figure = style.new_figure(9, 8, title)
    positions, strains, forces = figure.subplots(3, 1, sharex=True, height_ratios=(1.3, 1, 1))
    _draw_positions(positions, time, record.displacement)
    draw_strains_and_forces(strains, forces, record)
    return figure


def draw_strains_and_forces(strains: Axes, forces: Axes, record: Record) -> None:
    """Draw two kymographs, one above the other, with time counted from 0."""
    time = record.time - record.time[0]
    style.heading(strains, "Strain of each segment: red contracted, blue stretched")
    style.colour_bar(strains, style.strain_kymograph(strains, time, record.strain), style.STRAIN_LABEL)
    style.heading(forces, "Force of each muscle")
    style.colour_bar(forces, style.force_kymograph(forces, time, record.force), style.FORCE_LABEL)
    forces.set_xlabel(style.TIME_LABEL)


def _draw_positions(axes: Axes, time: Array, displacement: Array) -> None:
    """Draw nodes as lines and segments as bands between them, from where the head starts."""
    n = displacement.shape[1] - 1
    x = displacement - displacement[0, 0] - np.arange(n + 1)
    for i in range(n):
        axes.fill_between(time, x[:, i], x[:, i + 1], color="#f2d9b8" if i % 2 else "#faf0e0", lw=0)
    axes.plot(time, x, color="#8a6d3b", lw=0.7)
    axes.plot(time, x[:, 0], color=style.INK, lw=1.6)
    axes.set_ylabel("position ($L$)")
    axes.margins(x=0)
    axes.text(time[0], x[:, 0].max(), " head", va="top", fontsize=9, color=style.INK)
    axes.text(time[0], x[:, -1].min(), " tail", va="bottom", fontsize=9, color=style.INK)
    advance = (displacement[-1].mean() - displacement[0].mean()) / (time[-1] - time[0])
    style.tidy(axes, rf"Position of each segment; the crawler advances by {advance:.4f} $L/\tau_\theta$")
