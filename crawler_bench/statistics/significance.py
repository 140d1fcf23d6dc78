"""Is a difference between paired runs real, and how many pairs would show one."""

import math

import numpy as np
from scipy.stats import norm, permutation_test
from statsmodels.stats.power import TTestPower

from crawler_bench.statistics import estimates
from crawler_bench.statistics.estimates import Array

ALPHA = 0.05
POWER = 0.8
WORTHWHILE = 0.1  # difference to be found, relative to the second's mean
SMALL = 0.01  # effect, in standard deviations, below which the solver fails and a t-test is a normal one
_SEED = 20201122  # of the permutations, where there are too many for all of them


def permutation_p(first: Array, second: Array) -> float:
    """Two-sided p of the mean difference of paired runs under all exchanges within pairs; NaN without runs.

    n paired runs have 2^n exchanges: all are tried up to n = 13, a seeded sample of them beyond. With n = 5
    or fewer no difference whatever can reach 0.05.
    """
    if first.size < 2:
        return 1.0 if first.size else math.nan

    def mean_difference(x: Array, y: Array, axis: int) -> Array:
        return np.asarray(x.mean(axis=axis) - y.mean(axis=axis))

    found = permutation_test(
        (first, second), mean_difference, permutation_type="samples", vectorized=True,
        n_resamples=estimates.RESAMPLES, rng=np.random.default_rng(_SEED),
    )  # fmt: skip
    return float(found.pvalue)


def seeds_needed(first: Array, second: Array) -> float:
    """Paired seeds with which a difference of 10 % would be found.

    That is, a difference of 10 % of the second's mean, by a paired two-sided t-test at 0.05 with a power of
    80 %, if differences spread as they do here. At least 2, which is the answer where they do not
    spread at all; NaN with fewer than 2 runs, or where 10 % of the second's mean is nothing.
    """
    if first.size < 2:
        return math.nan
    spread, sought = float(np.std(first - second, ddof=1)), WORTHWHILE * abs(float(second.mean()))
    if sought == 0:
        return math.nan
    effect = sought / spread if spread > 0 else math.inf
    if effect < SMALL:
        return float(math.ceil((norm.isf(ALPHA / 2) + norm.ppf(POWER)) ** 2 / effect**2))
    test = TTestPower()
    if effect < 1:
        return float(math.ceil(test.solve_power(effect_size=effect, power=POWER, alpha=ALPHA)))
    # The solver fails below 3 seeds; 12 are enough for any effect of 1. Above 30, 2 seeds are.
    few = (n for n in range(2, 13) if effect > 30 or test.power(effect, n, ALPHA) >= POWER)
    return float(next(few))


def seeds_to_decide(first: Array, second: Array, tests: int = 1) -> float:
    """Paired seeds with which a difference as large as this one would pass Holm's correction over some tests.

    That is, by a paired two-sided t-test at 0.05 / tests (Holm's hardest step) with a power of 80 %; and at
    least as many as the permutation test needs to reach that p at all. NaN with fewer than 2 runs or without
    a difference; infinite where more than a million would be needed.
    """
    if first.size < 2 or tests < 1:
        return math.nan
    mean, spread = abs(float(np.mean(first - second))), float(np.std(first - second, ddof=1))
    if mean == 0:
        return math.nan
    alpha = ALPHA / tests
    fewest = math.ceil(1 + math.log2(1 / alpha))  # 2^(1 - n) is the least p of n pairs
    normal = (norm.isf(alpha / 2) + norm.ppf(POWER)) * spread / mean
    if normal > 1000:
        return math.inf
    # A t-test needs a few more than a normal one; its power rises with n.
    test, n = TTestPower(), max(2, math.ceil(normal**2))
    effect = mean / spread if spread > 0 else math.inf
    while effect < 30 and n < 1000 and test.power(effect, n, alpha) < POWER:
        n += 1
    return float(max(n, fewest))
