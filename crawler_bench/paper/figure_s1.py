"""Fig. S1: crawling before anything was learned."""

import numpy as np
from matplotlib.figure import Figure

from crawler_bench.gait.record import Array, Record
from crawler_bench.output.style import (
    FORCE_LABEL,
    GREY,
    INK,
    STRAIN_LABEL,
    TIME_LABEL,
    colour_bar,
    force_kymograph,
    heading,
    new_figure,
    strain_kymograph,
    tidy,
)

SMOOTHING = 2.0  # tau_theta over which the speed of an uncoordinated crawler is averaged


def untrained(record: Record) -> Figure:
    """Fig. S1: speed, strains and muscle forces of a crawler whose neurons are ON at random.

    Args:
        record: of the random policy; the whole of it is shown.
    """
    time = record.time - record.time[0]
    figure = new_figure(9, 7.5, "Fig. S1. Before learning: each neuron is equally likely to be ON")
    speeds, strains, forces = figure.subplots(3, 1, sharex=True, height_ratios=(0.8, 1, 1))
    speeds.plot(time[1:], _smooth_speed(record), color=GREY, lw=1.2)
    speeds.axhline(0, color=INK, lw=0.6)
    speeds.set_ylabel("speed of the centroid\n" + r"($L/\tau_\theta$)")
    tidy(speeds, rf"Speed of the centroid, mean over {SMOOTHING:g} $\tau_\theta$")
    heading(strains, "Strain of each segment: red contracted, blue stretched")
    colour_bar(strains, strain_kymograph(strains, time, record.strain), STRAIN_LABEL)
    heading(forces, "Force of each muscle")
    colour_bar(forces, force_kymograph(forces, time, record.force), FORCE_LABEL)
    forces.set_xlabel(TIME_LABEL)
    return figure


def _smooth_speed(record: Record) -> Array:
    """(T,) speed of the centroid over each decision, averaged over the decisions around it."""
    speed = np.diff(record.centroid) / np.diff(record.time)
    interval = (record.time[-1] - record.time[0]) / max(speed.size, 1)
    width = min(max(round(SMOOTHING / interval), 1), speed.size)
    known = np.convolve(np.ones(speed.size), np.ones(width), mode="same")
    smooth: Array = np.convolve(speed, np.ones(width), mode="same") / known
    return smooth
