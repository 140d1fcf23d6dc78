"""Every claim of the paper, in its order: the sentence or figure, its value, and how we measure it.

The statistic and the threshold for each sentence are fixed here, for every reading and agent alike.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from crawler_bench.config.errors import ConfigError, nearest
from crawler_bench.gait.metrics import ORDERLY
from crawler_bench.paper.verdicts import Claim, Kind, Results
from crawler_bench.statistics import estimates
from crawler_bench.statistics.estimates import Estimate

if TYPE_CHECKING:
    import pandas as pd

LOW_NOISE, HIGH_NOISE = 0.025, 0.2  # amplitudes s of the paper's "low" and "high" noise
LOCAL = 2.0  # a wave is localized if fewer segments than this are contracted at a time, on average
PERIODIC = 0.8  # power is periodic if successive cycles correlate above this
SIMILAR = 2  # entries, of 10, in which similar policies may differ

WAVES_PER_SECOND = 1.5  # of a third instar larva [M20, "Scaling and parameter choices"]
TAU = 0.017  # s, the paper's value of tau_theta, and 0.051 for the slowest first instar larvae
TAU_SLOW = 0.051
SEGMENT_THIRD, SEGMENT_FIRST = 0.4, 100.0  # mm and micrometres: length of a segment

REG, UNREG, RANDOM, GRID = EXPERIMENTS = ("regularized", "unregularized", "untrained", "alpha_gamma")


def _mean(experiment: str, column: str, factor: float = 1.0) -> Callable[[Results], Estimate]:
    return lambda results: estimates.estimate(results.of(experiment, column)).scaled(factor)


def _share(
    experiment: str, column: str, holds: Callable[[pd.Series], pd.Series]
) -> Callable[[Results], Estimate]:
    return lambda results: estimates.share(holds(results.of(experiment, column)))


def _more(first: str, second: str, column: str) -> Callable[[Results], Estimate]:
    return lambda results: estimates.paired_difference(*results.pair(first, second, column))


def _excess(column: str) -> Callable[[Results], Estimate]:
    return lambda results: estimates.relative_excess(*results.pair(UNREG, REG, column)).scaled(100)


def _noise_difference(first: str, second: str, noise: float) -> Callable[[Results], Estimate]:
    def measure(results: Results) -> Estimate:
        a, b = (results.noisy_speed(name) for name in (first, second))
        if noise not in a or noise not in b:
            return estimates.UNKNOWN
        return estimates.paired_difference(*a[noise].align(b[noise], join="inner"))

    return measure


def _kept_speed(experiment: str) -> Callable[[Results], Estimate]:
    """Speed under noise, averaged over amplitudes up to HIGH_NOISE, relative to that without."""

    def measure(results: Results) -> Estimate:
        speeds = results.noisy_speed(experiment)
        if 0.0 not in speeds:
            return estimates.UNKNOWN
        noisy = speeds[[s for s in speeds.columns if 0 < float(s) <= HIGH_NOISE]].mean(axis=1)
        excess = estimates.relative_excess(noisy, speeds[0.0])
        return Estimate(excess.value + 1, excess.low + 1, excess.high + 1, excess.n)

    return measure


def _lost_speed(results: Results) -> Estimate:
    speeds = results.noisy_speed(UNREG)
    if not {0.0, HIGH_NOISE} <= set(speeds.columns):
        return estimates.UNKNOWN
    return estimates.paired_difference(speeds[0.0], speeds[HIGH_NOISE])


def noise_crossover(results: Results) -> tuple[Estimate, float]:
    """Amplitude at which the regularized gait becomes the faster one; share of resamples in which it does."""
    a, b = results.noisy_speed(REG).align(results.noisy_speed(UNREG), join="inner")
    return estimates.crossover(a.columns.to_numpy(float), a.to_numpy(float), b.to_numpy(float))


def _crosses(results: Results) -> Estimate:
    a, b = results.noisy_speed(REG).align(results.noisy_speed(UNREG), join="inner")
    amplitudes = a.columns.to_numpy(float)
    crossings = [estimates.first_crossing(amplitudes, difference) for difference in (a - b).to_numpy(float)]
    return estimates.share(np.isfinite(crossings))


def _on_diagonal(results: Results) -> Estimate:
    """Entries of the table on the diagonal, in percent."""
    distance, n = results.of(REG, "diagonal_distance"), results.of(REG, "observations")
    return estimates.estimate(100 * (1 - distance / n), statistic=np.mean)


def _observed_minus_ours(results: Results) -> Estimate:
    ours = estimates.estimate(results.of(REG, "speed")).scaled(SEGMENT_FIRST / TAU)
    return Estimate(45 - ours.value, 45 - ours.high, 45 - ours.low, ours.n)


def _similar(results: Results) -> Estimate:
    grid = results.runs[results.runs["experiment"] == GRID]
    return estimates.share(grid["diagonal_distance"] <= SIMILAR)


BOTH = (REG, UNREG)
_FASTER = "unregularized gait is faster than the regularized one"

CLAIMS = (
    Claim("wave", "the regularized gait is a wave of contraction from tail to head (share of runs)",
          "Results, Fig. 2A", Kind.SHARE, "yes", _share(REG, "wave_order", lambda x: x > ORDERLY), (REG,)),
    Claim("wave_unregularized", "the unregularized gait is a wave from tail to head, too (share of runs)",
          "Results, Fig. 2B", Kind.SHARE, "yes", _share(UNREG, "wave_order", lambda x: x > ORDERLY), (UNREG,)),
    Claim("localized", f"the regularized wave is localized: fewer than {LOCAL:g} segments contracted at a time (share of runs)",
          "Results, Fig. 2A", Kind.SHARE, "yes", _share(REG, "contracted_segments", lambda x: x < LOCAL), (REG,)),
    Claim("nearest_neighbour", "all-to-all coupling converges to nearest-neighbour wiring (share of runs that end on the diagonal)",
          "abstract, Fig. 2C", Kind.SHARE, "yes", _share(REG, "diagonal_distance", lambda x: x == 0), (REG,)),
    Claim("diagonal_entries", "entries of the regularized policy table that are nearest-neighbour (mean, %)",
          "Fig. 2C", Kind.NUMBER, 100, _on_diagonal, (REG,)),
    Claim("peak_contraction", "peak contraction of a segment (%)",
          "Scaling", Kind.NUMBER, 33, _mean(REG, "peak_contraction", 100), (REG,)),
    Claim("wave_speed", "waves per tau, regularized",
          "Scaling", Kind.NUMBER, 0.026, _mean(REG, "waves_per_tau"), (REG,)),
    Claim("speed", "speed of the regularized gait (L/tau)",
          "Scaling", Kind.NUMBER, 0.0056, _mean(REG, "speed"), (REG,)),
    Claim("tau", f"tau from {WAVES_PER_SECOND} waves/s of a third instar larva (ms)",
          "Scaling", Kind.NUMBER, 17, _mean(REG, "waves_per_tau", 1000 / WAVES_PER_SECOND), (REG,)),
    Claim("speed_third_instar", "speed of a third instar larva, with the paper's tau = 17 ms, L = 0.4 mm (mm/s)",
          "Scaling", Kind.NUMBER, 0.13, _mean(REG, "speed", SEGMENT_THIRD / TAU), (REG,)),
    Claim("speed_first_instar_slow", "speed of a first instar larva, tau = 51 ms, L = 0.1 mm (micrometres/s)",
          "Scaling", Kind.NUMBER, 11, _mean(REG, "speed", SEGMENT_FIRST / TAU_SLOW), (REG,)),
    Claim("speed_first_instar_fast", "speed of a first instar larva, tau = 17 ms, L = 0.1 mm (micrometres/s)",
          "Scaling", Kind.NUMBER, 33, _mean(REG, "speed", SEGMENT_FIRST / TAU), (REG,)),
    Claim("speed_observed", "the model is slower than the 45-120 observed in first instar larvae (45 minus ours, micrometres/s)",
          "Scaling", Kind.ORDERING, "> 0", _observed_minus_ours, (REG,)),
    Claim("faster", f"the {_FASTER} (frozen policy, all starts; difference, L/tau)",
          "Results", Kind.ORDERING, "> 0", _more(UNREG, REG, "speed"), BOTH),
    Claim("faster_by", "the unregularized gait is faster by about 10 % (frozen policy, all starts; excess, %)",
          "Results", Kind.NUMBER, 10, _excess("speed"), BOTH),
    Claim("faster_moving", f"the {_FASTER} (frozen policy, starts that do not stall; difference, L/tau)",
          "Results", Kind.ORDERING, "> 0", _more(UNREG, REG, "speed_moving"), BOTH),
    Claim("faster_moving_by", "the unregularized gait is faster by about 10 % (frozen policy, starts that do not stall; excess, %)",
          "Results", Kind.NUMBER, 10, _excess("speed_moving"), BOTH),
    Claim("faster_learning", f"the {_FASTER} (last tenth of learning; difference, L/tau)",
          "Results", Kind.ORDERING, "> 0", _more(UNREG, REG, "speed_learning_end"), BOTH),
    Claim("faster_learning_by", "the unregularized gait is faster by about 10 % (last tenth of learning; excess, %)",
          "Results", Kind.NUMBER, 10, _excess("speed_learning_end"), BOTH),
    Claim("unused_muscles", "unregularized, some muscles are never activated (share of runs)",
          "Results, Fig. 2B", Kind.SHARE, "yes", _share(UNREG, "unused_muscles", lambda x: x >= 1), (UNREG,)),
    Claim("pairs", "unregularized, segments move in pairs (share of runs with at least 2 pairs of neighbouring nodes whose velocities correlate)",
          "Results", Kind.SHARE, "yes", _share(UNREG, "pairs_together", lambda x: x >= 2), (UNREG,)),
    Claim("larger_gradient", "unregularized, strain varies more from segment to segment (strain gradient, difference)",
          "Results", Kind.ORDERING, "> 0", _more(UNREG, REG, "strain_gradient"), BOTH),
    Claim("larger_range", "\"larger variations in segment strain\", read as range over a cycle (difference)",
          "Results", Kind.ORDERING, "> 0", _more(UNREG, REG, "strain_range"), BOTH),
    Claim("smaller_range", "unregularized, strain \"varies over a smaller range\" over a cycle (difference)",
          "Results", Kind.ORDERING, "> 0", _more(REG, UNREG, "strain_range"), BOTH),
    Claim("power_periodic", f"power is periodic, regularized (share of runs whose successive cycles correlate above {PERIODIC:g})",
          "Results, Fig. 3A", Kind.SHARE, "yes", _share(REG, "power_periodicity", lambda x: x > PERIODIC), (REG,)),
    Claim("power_periodic_unregularized", f"power is periodic, unregularized (share of runs whose successive cycles correlate above {PERIODIC:g})",
          "Results, Fig. 3A", Kind.SHARE, "yes", _share(UNREG, "power_periodicity", lambda x: x > PERIODIC), (UNREG,)),
    Claim("power_maximum", "maximal power is more uniform over interior nodes when regularized (coefficient of variation, difference)",
          "Results, Fig. 3A", Kind.ORDERING, "> 0", _more(UNREG, REG, "power_peak_unevenness"), BOTH),
    Claim("power_duration", "the duration of power is more uniform over interior nodes when regularized (coefficient of variation, difference)",
          "Results, Fig. 3A", Kind.ORDERING, "> 0", _more(UNREG, REG, "power_duration_unevenness"), BOTH),
    Claim("shorter_cycle", "the cycle is shorter when unregularized (difference, tau)",
          "Results, Fig. 3B", Kind.ORDERING, "> 0", _more(REG, UNREG, "cycle_duration"), BOTH),
    Claim("faster_low_noise", f"unregularized is faster at low noise, s = {LOW_NOISE:g} (difference, L/tau)",
          "Results, Fig. 3C", Kind.ORDERING, "> 0", _noise_difference(UNREG, REG, LOW_NOISE), BOTH),
    Claim("slower_high_noise", f"unregularized is slower at high noise, s = {HIGH_NOISE:g} (difference, L/tau)",
          "Results, Fig. 3C", Kind.ORDERING, "> 0", _noise_difference(REG, UNREG, HIGH_NOISE), BOTH),
    Claim("crossing", "the two curves of speed against noise cross (share of paired runs)",
          "Results, Fig. 3C", Kind.SHARE, "yes", _crosses, BOTH),
    Claim("crossover", "noise amplitude s at which the mean curves cross",
          "Fig. 3C", Kind.OPEN, "not given", lambda results: noise_crossover(results)[0], BOTH),
    Claim("maintains_speed", f"the regularized gait maintains its speed (mean over 0 < s <= {HIGH_NOISE:g}, relative to s = 0)",
          "Results, Fig. 3C", Kind.NUMBER, 1, _kept_speed(REG), (REG,)),
    Claim("loses_speed", f"the unregularized gait loses speed under noise (speed at s = 0 minus that at s = {HIGH_NOISE:g}, L/tau)",
          "Results, Fig. 3C", Kind.ORDERING, "> 0", _lost_speed, (UNREG,)),
    Claim("uncoordinated", "the untrained gait is uncoordinated: no wave (share of runs)",
          "Fig. S1", Kind.SHARE, "yes", _share(RANDOM, "wave_order", lambda x: x.abs() < ORDERLY), (RANDOM,)),
    Claim("learning_pays", "learning pays: regularized is faster than random action (implied; difference, L/tau)",
          "implied", Kind.ORDERING, "> 0", _more(REG, RANDOM, "speed"), (REG, RANDOM)),
    Claim("learning_pays_unregularized", "learning pays: unregularized is faster than random action (implied; difference, L/tau)",
          "implied", Kind.ORDERING, "> 0", _more(UNREG, RANDOM, "speed"), (UNREG, RANDOM)),
    Claim("alpha_gamma", f"most reasonable alpha and gamma give similar policies (share of a 3 x 3 grid's runs within {SIMILAR} entries of the diagonal)",
          "Formulation", Kind.SHARE, "yes", _similar, (GRID,)),
)  # fmt: skip


def find_claim(name: str) -> Claim:
    """The claim of a name.

    Raises:
        ConfigError: if there is none, naming the one that was probably meant or all there are.
    """
    for claim in CLAIMS:
        if claim.name == name:
            return claim
    raise ConfigError(f"no claim is called {name!r}{nearest(name, [claim.name for claim in CLAIMS])}")
