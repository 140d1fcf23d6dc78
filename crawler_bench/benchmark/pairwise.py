"""Agents compared in pairs, over paired seeds, by families: a pair that answers no question is not tested."""

import math
from collections.abc import Iterator
from itertools import combinations
from typing import Any

import numpy as np
import pandas as pd
from statsmodels.stats.multitest import multipletests

from crawler_bench.benchmark.curves import noise_curves
from crawler_bench.benchmark.families import family, traits_of
from crawler_bench.benchmark.keys import GROUP, Group
from crawler_bench.benchmark.summary import measure_runs, metric
from crawler_bench.statistics import estimates
from crawler_bench.statistics.estimates import Array, Estimate
from crawler_bench.statistics.significance import ALPHA, permutation_p, seeds_needed, seeds_to_decide

COMPARED = ("speed", "reward", "noise_area", "cycle_duration")
OWN = ("reward",)  # means something else at each regularization: not compared between two
SIDES = ("first", "second")
SAMPLES = "_samples"  # of a pair, until the number of tests is known
FAMILY = [
    "family",
    "metric",
    "first_regularization",
    "second_regularization",
]  # tests that are corrected together


def compare(
    runs: pd.DataFrame, evaluations: pd.DataFrame, traits: pd.DataFrame | None = None
) -> pd.DataFrame:
    """Compare agents at the same regularization, and each agent with itself at another.

    Args:
        runs: one row per run and mode.
        evaluations: one row per run, mode, noise and start.
        traits: of `entries.traits`, which decides who is compared with whom; without it all are with all.

    Returns:
        One row per pair and metric:
        family: the question that the pair answers, of `families.QUESTIONS`;
        first_agent, first_mode, first_regularization and the same of the second;
        metric: of COMPARED; between regularizations, without OWN;
        difference, low, high: interquartile mean of first - second over the seeds that both have, with its
        BCa interval, in the metric's unit;
        n: number of those seeds;
        degenerate: whether the difference is the same in all of them, so that low = high says nothing;
        relative, relative_low, relative_high: excess of the first's interquartile mean over the second's;
        NaN unless all values of the second are above 0;
        improvement, improvement_low, improvement_high: probability that a run of the first has the larger
        value (of a cycle duration the longer, not the better one), see `estimates.improvement`;
        tests: how many pairs its family has at this metric and regularization;
        p, p_holm, p_fdr: two-sided paired permutation test, exact up to 13 seeds; Holm's correction over
        these tests, and Benjamini and Hochberg's. They assume independent runs, which the seeds of an agent
        that neither learns nor draws are not;
        crossover, crossover_low, crossover_high (on the rows of noise_area): amplitude s at which the agent
        that is slower at s = 0 overtakes, NaN where it does not;
        crossover_share: share of resamples of the runs in which it does;
        overtakes: "first" or "second", empty where neither does;
        seeds_needed: see `seeds_needed`;
        seeds_to_decide: see `seeds_to_decide`, over these tests.
    """
    measured = measure_runs(runs, evaluations)
    groups = _by_group(measured.set_index("seed"))
    curves = _by_group(noise_curves(evaluations).reset_index(GROUP))
    known = traits_of(traits)
    counts = {agent: len({key[1] for key in groups if key[0] == agent}) for agent, _, _ in groups}
    rows = []
    for first, second in _pairs(list(groups)):
        if (question := family(first, second, known, counts)) is None:
            continue
        key = {"family": question} | {
            f"{side}_{name}": value
            for side, group in zip(SIDES, (first, second), strict=True)
            for name, value in zip(GROUP, group, strict=True)
        }
        for name in COMPARED:
            if name in OWN and first[2] != second[2]:
                continue
            a, b = metric(name).of(groups[first]).align(metric(name).of(groups[second]), join="inner")
            row = key | {"metric": name} | _compare(a.to_numpy(float), b.to_numpy(float))
            crossed = name == "noise_area" and first in curves and second in curves
            rows.append(row | (_cross(curves[first], curves[second]) if crossed else NO_CROSSING))
    return _correct(pd.DataFrame(rows)) if rows else pd.DataFrame()


def _by_group(frame: pd.DataFrame) -> dict[Any, pd.DataFrame]:
    """The rows of each group, by seed."""
    return {group: rows.drop(columns=GROUP).sort_index() for group, rows in frame.groupby(GROUP, sort=False)}


def _pairs(keys: list[Group]) -> Iterator[tuple[Group, Group]]:
    """Pairs at one regularization, then those of one agent and mode at two, the lower first."""
    levels = sorted({key[2] for key in keys})
    for level in levels:
        yield from combinations([key for key in keys if key[2] == level], 2)
    for name in dict.fromkeys(key[:2] for key in keys):
        yield from combinations([(*name, level) for level in levels if (*name, level) in keys], 2)


def _compare(first: Array, second: Array) -> dict[str, object]:
    known = np.isfinite(first) & np.isfinite(second)
    a, b = first[known], second[known]
    difference = estimates.paired_difference(a, b)
    relative = estimates.relative_excess(a, b) if (b > 0).all() else estimates.UNKNOWN
    return {
        "difference": difference.value, "low": difference.low, "high": difference.high, "n": difference.n,
        "degenerate": difference.n > 0 and difference.degenerate,
        **_columns("relative", relative), **_columns("improvement", estimates.improvement(a, b)),
        "p": permutation_p(a, b), "seeds_needed": seeds_needed(a, b), SAMPLES: (a, b),
    }  # fmt: skip


def _columns(name: str, found: Estimate) -> dict[str, object]:
    return {name: found.value, f"{name}_low": found.low, f"{name}_high": found.high}


NO_CROSSING = _columns("crossover", estimates.UNKNOWN) | {"crossover_share": math.nan, "overtakes": ""}


def _cross(first: pd.DataFrame, second: pd.DataFrame) -> dict[str, object]:
    """Where two noise curves cross, over the seeds that were measured at every amplitude in both."""
    a, b = first.dropna().align(second.dropna(), join="inner")
    if not a.size:
        return NO_CROSSING
    first_is_slower = bool(a.iloc[:, 0].mean() < b.iloc[:, 0].mean())
    rising, falling = (a, b) if first_is_slower else (b, a)
    noise, share = estimates.crossover(a.columns.to_numpy(float), rising.to_numpy(), falling.to_numpy())
    faster = SIDES[0 if first_is_slower else 1] if math.isfinite(noise.value) else ""
    return _columns("crossover", noise) | {"crossover_share": share, "overtakes": faster}


def _correct(pairs: pd.DataFrame) -> pd.DataFrame:
    """Add the corrected p, right after p; the number of tests; and the seeds that these would need."""
    tests = pairs["p"].notna().groupby([pairs[name] for name in FAMILY]).transform("sum").astype(int)
    pairs.insert(pairs.columns.tolist().index("p"), "tests", tests)
    pairs["seeds_to_decide"] = [
        seeds_to_decide(first, second, number)
        for (first, second), number in zip(pairs.pop(SAMPLES), tests, strict=True)
    ]
    for name, method in (("p_fdr", "fdr_bh"), ("p_holm", "holm")):
        corrected = pd.Series(math.nan, index=pairs.index)
        for _, rows in pairs[pairs["p"].notna()].groupby(FAMILY):
            corrected[rows.index] = multipletests(rows["p"].to_numpy(float), ALPHA, method=method)[1]
        pairs.insert(pairs.columns.tolist().index("p") + 1, name, corrected)
    return pairs
