"""A made-up record, and what a figure says."""

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from crawler_bench.gait.record import Record


def travelling_wave(n=10, duration=130.0, interval=0.2):
    """A contraction that moves from tail to head once in 40 tau while the body drifts forward."""
    time = np.arange(round(duration / interval) + 1) * interval
    node = np.arange(n + 1)
    phase = 2 * np.pi * (time[:, None] / 40 + node / (n + 1))
    displacement = 0.005 * time[:, None] + 0.15 * np.sin(phase)
    force = np.clip(np.sin(phase), 0, 1)
    velocity = np.gradient(displacement, time, axis=0)
    return Record(
        time, displacement, velocity, force, np.abs(force * velocity), np.zeros(time.size - 1, dtype=np.int64)
    )


def texts(figure: Figure) -> str:
    return " ".join(text.get_text() for text in figure.findobj(matplotlib.text.Text))
