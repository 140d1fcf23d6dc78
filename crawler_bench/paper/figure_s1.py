"""Fig. S1: the crawler before learning."""

import numpy as np
from matplotlib.figure import Figure

from crawler_bench.gait.record import Array, Record
from crawler_bench.output.kymographs import draw_strains_and_forces
from crawler_bench.output.style import (
    GREY,
    INK,
    new_figure,
    tidy,
)

SMOOTHING = 2.0  # tau_theta over which the speed is averaged


def untrained(record: Record) -> Figure:
    """Speed, strains and muscle forces of a crawler whose neurons are ON at random; the whole record."""
    time = record.time - record.time[0]
    figure = new_figure(9, 7.5, "Fig. S1. Before learning: each neuron is equally likely to be ON")
    speeds, strains, forces = figure.subplots(3, 1, sharex=True, height_ratios=(0.8, 1, 1))
    speeds.plot(time[1:], _smooth_speed(record), color=GREY, lw=1.2)
    speeds.axhline(0, color=INK, lw=0.6)
    speeds.set_ylabel("speed of the centroid\n" + r"($L/\tau_\theta$)")
    tidy(speeds, rf"Speed of the centroid, mean over {SMOOTHING:g} $\tau_\theta$")
    draw_strains_and_forces(strains, forces, record)
    return figure


def _smooth_speed(record: Record) -> Array:
    """(T,) speed of the centroid, averaged over the decisions around each."""
    speed = np.diff(record.centroid) / np.diff(record.time)
    interval = (record.time[-1] - record.time[0]) / max(speed.size, 1)
    width = min(max(round(SMOOTHING / interval), 1), speed.size)
    known = np.convolve(np.ones(speed.size), np.ones(width), mode="same")
    smooth: Array = np.convolve(speed, np.ones(width), mode="same") / known
    return smooth
