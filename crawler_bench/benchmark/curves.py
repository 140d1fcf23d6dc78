"""The two curves of a run as numbers: speed against noise, and speed while learning."""

import math

import numpy as np
import pandas as pd

from crawler_bench.benchmark.keys import LEARNER, RUN
from crawler_bench.statistics.estimates import Array

SMOOTHING = 5  # windows of the running mean, two on each side
FINAL = 0.1  # the final speed is the mean over this last share of the windows
REACHED = 0.9  # share of the final speed


def noise_curves(evaluations: pd.DataFrame) -> pd.DataFrame:
    """Speed against noise.

    Args:
        evaluations: one row per run, mode, noise and start, with `speed` in L / tau_theta.

    Returns:
        One row per run and mode (indexed by RUN), one column per amplitude s in rising order: the mean over
        the starts, NaN where a run was not measured.
    """
    return evaluations.pivot_table(index=RUN, columns="noise", values="speed", aggfunc="mean")


def noise_area(curves: pd.DataFrame) -> pd.Series:
    """Mean speed of each curve over the range of s (0 to 0.4 by default), L / tau_theta; trapezoid rule.

    NaN where an amplitude is missing or there is only one.
    """
    amplitudes = curves.columns.to_numpy(float)
    if amplitudes.size < 2:
        return pd.Series(math.nan, index=curves.index)
    area = np.trapezoid(curves.to_numpy(float), amplitudes, axis=1)
    return pd.Series(area / np.ptp(amplitudes), index=curves.index)


def decisions_to_final(decisions: Array, speed: Array) -> float:
    """Decisions after which a learning curve stays at or above 90 % of its final speed.

    The curve is smoothed by a running mean over 5 windows, fewer at its ends. The answer is the end of the
    first window from which the smoothed speed never falls below 90 % of the final one, so that an early burst
    (acting at random is fast here) does not count. An agent that is as fast from the start gets the first
    window.

    NaN where the agent never learns: it has no curve, no final speed above 0, a final speed below 90 % of the
    first smoothed one, or does not hold 90 % to the end.

    Args:
        decisions: (W,) decisions taken at the end of each window, increasing.
        speed: (W,) mean speed in the window, L / tau_theta; NaN where unknown.
    """
    if not speed.size:
        return math.nan
    last = pd.Series(speed[-max(1, math.ceil(FINAL * speed.size)) :])
    smooth = pd.Series(speed).rolling(SMOOTHING, center=True, min_periods=1).mean().to_numpy()
    final = float(last.mean())
    known = smooth[np.isfinite(smooth)]
    if not final > 0 or final < REACHED * known[0]:
        return math.nan
    # An unknown window is neither above nor below.
    below = np.flatnonzero(smooth < REACHED * final)
    reached = int(below[-1]) + 1 if below.size else 0
    return float(decisions[reached]) if reached < speed.size else math.nan


def learning_decisions(curves: pd.DataFrame) -> pd.DataFrame:
    """`decisions_to_final` of every learning curve: one row per run that has one, keyed by LEARNER."""
    rows = [
        (*key, decisions_to_final(rows["decisions"].to_numpy(float), rows["speed"].to_numpy(float)))
        for key, rows in (curves.groupby(LEARNER, sort=False) if len(curves) else ())
    ]
    return pd.DataFrame(rows, columns=[*LEARNER, "decisions_to_final"])
