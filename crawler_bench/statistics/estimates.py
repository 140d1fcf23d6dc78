"""Statistics over independent training runs: interquartile means, bootstrap intervals, shares, crossovers."""

import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

CONFIDENCE = 0.95
RESAMPLES = 9999
_SEED = 20201122  # of every bootstrap: equal data give equal intervals
_intervals = ContextVar("intervals", default=True)


@contextmanager
def without_intervals() -> Iterator[None]:
    """Skip every interval (low = high = value), for a caller who resamples whole runs."""
    token = _intervals.set(False)
    try:
        yield
    finally:
        _intervals.reset(token)


@dataclass(frozen=True)
class Estimate:
    """A number with its interval.

    Attributes:
        value: the estimate.
        low: lower end of the 95 % interval.
        high: upper end.
        n: number of independent runs.
    """

    value: float
    low: float
    high: float
    n: int

    @property
    def degenerate(self) -> bool:
        """Whether all runs agree, so that the interval says nothing."""
        return self.low == self.high

    def scaled(self, factor: float) -> "Estimate":
        """The estimate in other units; a negative factor swaps the ends of the interval."""
        low, high = sorted((self.low * factor, self.high * factor))
        return Estimate(self.value * factor, low, high, self.n)


UNKNOWN = Estimate(float("nan"), float("nan"), float("nan"), 0)


def interquartile_mean(values: Array, axis: int = -1) -> Any:
    """Mean of the middle half of the values."""
    from scipy import stats  # slow to import: a list of the claims can do without

    return stats.trim_mean(values, 0.25, axis=axis)


def estimate(values: ArrayLike, statistic: Callable[..., Any] = interquartile_mean) -> Estimate:
    """Interquartile mean over runs (or another statistic) with its bootstrap BCa interval.

    Missing values (NaN) are left out and not counted in n. Where all values are equal, or the interval is
    undefined for another reason, low = high = value and `degenerate` says so.
    """
    return _estimate((values,), statistic)


def estimate_pairs(first: ArrayLike, second: ArrayLike, statistic: Callable[..., Any]) -> Estimate:
    """A statistic of two samples over paired runs, with its interval; pairs are resampled together.

    Args:
        first: (runs,) values.
        second: (runs,) values of the paired runs; a pair that lacks either is left out.
        statistic: (x, y, axis) -> value.
    """
    return _estimate((first, second), statistic)


def _estimate(samples: tuple[ArrayLike, ...], statistic: Callable[..., Any]) -> Estimate:
    arrays = [np.asarray(sample, dtype=np.float64) for sample in samples]
    complete = np.logical_and.reduce([np.isfinite(array) for array in arrays])
    arrays = [array[complete] for array in arrays]
    n = arrays[0].size
    if n == 0:
        return UNKNOWN
    value = float(statistic(*arrays, axis=-1))
    if n == 1 or not any(np.ptp(array) for array in arrays) or not _intervals.get():
        return Estimate(value, value, value, n)
    return Estimate(value, *_interval(arrays, statistic), n)


def _interval(data: Sequence[Array], statistic: Callable[..., Any]) -> tuple[float, float]:
    """BCa interval; percentiles where the acceleration is undefined (the jackknife does not vary)."""
    from scipy import stats

    bootstrap = partial(
        stats.bootstrap, data, statistic, paired=len(data) > 1, n_resamples=RESAMPLES,
        confidence_level=CONFIDENCE, vectorized=True,
    )  # fmt: skip
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore", stats.DegenerateDataWarning)
        for method in ("BCa", "percentile"):
            interval = bootstrap(method=method, rng=np.random.default_rng(_SEED)).confidence_interval
            if np.isfinite([interval.low, interval.high]).all():
                break
    return float(interval.low), float(interval.high)


def share(outcomes: ArrayLike) -> Estimate:
    """Share of runs with an outcome, with its Wilson interval."""
    from scipy.stats import binomtest

    happened = np.asarray(outcomes, dtype=bool)
    if happened.size == 0:
        return UNKNOWN
    value = float(happened.mean())
    if not _intervals.get():
        return Estimate(value, value, value, happened.size)
    interval = binomtest(int(happened.sum()), happened.size).proportion_ci(CONFIDENCE, method="wilson")
    return Estimate(value, float(interval.low), float(interval.high), happened.size)


def paired_difference(first: ArrayLike, second: ArrayLike) -> Estimate:
    """Interquartile mean of first - second over paired runs, with its interval."""
    return estimate(np.asarray(first, dtype=np.float64) - np.asarray(second, dtype=np.float64))


def relative_excess(first: ArrayLike, second: ArrayLike) -> Estimate:
    """Relative excess of the interquartile mean of `first` over that of `second`; runs are paired."""

    def excess(x: Array, y: Array, axis: int = -1) -> Any:
        with np.errstate(divide="ignore", invalid="ignore"):  # a crawler that stands still has no excess
            return interquartile_mean(x, axis) / interquartile_mean(y, axis) - 1

    return estimate_pairs(first, second, excess)


def improvement(first: ArrayLike, second: ArrayLike) -> Estimate:
    """Probability that a run of `first` exceeds a run of `second`, whichever two; a tie counts half.

    All n * n combinations of n paired runs are compared, because either agent could have had another seed;
    the interval resamples pairs.
    """

    def wins(x: Array, y: Array, axis: int = -1) -> Any:
        one, other = np.moveaxis(x, axis, -1)[..., :, None], np.moveaxis(y, axis, -1)[..., None, :]
        return (0.5 + 0.5 * np.sign(one - other)).mean(axis=(-2, -1))

    return estimate_pairs(first, second, wins)


def first_crossing(x: Array, difference: Array) -> float:
    """Where a difference, given at increasing x, first turns from negative to positive; else NaN."""
    for i in range(1, x.size):
        if difference[i - 1] < 0 <= difference[i]:
            weight = -difference[i - 1] / (difference[i] - difference[i - 1])
            return float(x[i - 1] + weight * (x[i] - x[i - 1]))
    return float("nan")


def crossover(x: ArrayLike, rising: ArrayLike, falling: ArrayLike) -> tuple[Estimate, float]:
    """Where one curve overtakes another, both measured in the same runs.

    Args:
        x: (K,) increasing.
        rising: (runs, K) the curve that starts lower.
        falling: (runs, K) the curve that starts higher, from the paired runs.

    Returns:
        The crossing of the mean curves with the bootstrap interval of those resamples that cross, and the
        share of resamples that do.
    """
    at = np.asarray(x, dtype=np.float64)
    difference = np.asarray(rising, dtype=np.float64) - np.asarray(falling, dtype=np.float64)
    if len(difference) == 0:
        return UNKNOWN, float("nan")
    rng = np.random.default_rng(_SEED)
    resamples = rng.integers(len(difference), size=(RESAMPLES // 5, len(difference)))
    crossings = np.array([first_crossing(at, difference[chosen].mean(axis=0)) for chosen in resamples])
    found = crossings[np.isfinite(crossings)]
    value = first_crossing(at, difference.mean(axis=0))
    tail = (1 - CONFIDENCE) / 2
    known = found.size and np.isfinite(value)
    low, high = np.quantile(found, [tail, 1 - tail]) if known else (np.nan, np.nan)
    return Estimate(value, float(low), float(high), len(difference)), float(found.size / crossings.size)
