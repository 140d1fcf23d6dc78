"""Performance profiles [Agarwal et al. 2021]: the share of runs that score more than each threshold."""

import numpy as np
from numpy.typing import ArrayLike

from crawler_bench.statistics.estimates import CONFIDENCE, RESAMPLES, Array

_SEED = 20201122


def performance_profile(scores: ArrayLike, thresholds: ArrayLike) -> tuple[Array, Array, Array]:
    """Share of runs above each threshold, with its pointwise percentile interval over resampled runs.

    Args:
        scores: (runs,); NaN is left out.
        thresholds: (T,).

    Returns:
        (T,) share, low and high; all NaN without runs.
    """
    known, at = np.asarray(scores, dtype=np.float64), np.asarray(thresholds, dtype=np.float64)
    known = known[np.isfinite(known)]
    if not known.size:
        unknown = np.full(at.size, np.nan)
        return unknown, unknown, unknown
    above = (known[:, None] > at).astype(np.float64)
    chosen = np.random.default_rng(_SEED).integers(known.size, size=(RESAMPLES // 10, known.size))
    shares = above[chosen].mean(axis=1)
    tail = (1 - CONFIDENCE) / 2
    low, high = np.quantile(shares, [tail, 1 - tail], axis=0)
    return above.mean(axis=0), low, high
