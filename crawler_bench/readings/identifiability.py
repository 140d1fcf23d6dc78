"""What the claims say about the constants, and what the paper's conclusions owe to them."""

from collections.abc import Callable, Sequence

import numpy as np
import pandas as pd
from scipy import stats as scipy_stats

from crawler_bench.gait.metrics import ORDERLY
from crawler_bench.paper.claims import LOCAL
from crawler_bench.readings.catalogue import DEFAULT
from crawler_bench.readings.fields import FIELDS, GIVEN, REGULARIZATION, Field, word
from crawler_bench.readings.laboratory import REGULARIZED, UNREGULARIZED, Scored, noisy_speed
from crawler_bench.readings.scoring import GROUPS, TOLERANCE, Score
from crawler_bench.statistics import estimates as stats

MOVES = 1.0  # a field moves a group whose distance changes by this along the profile, in tolerances
# Groups of the three conclusions, left out where the readings that test a conclusion are chosen.
CONCLUDED = ("wave", "localized", "wiring", "faster", "10 % faster", "low noise", "high noise")


def group_distances(score: Score) -> pd.Series:
    """Distance of each group."""
    distances: pd.Series = score.claims.groupby("group")["distance"].mean()
    return distances.reindex(list(GROUPS))


def profile(field: Field, scored: Sequence[Scored]) -> list[Scored]:
    """The default and the readings that change only this field, in the order of its values."""
    alone = [each for each in scored if _is_alone(each, field)]
    values = [each.values[field.key] for each in alone]
    if all(isinstance(value, int | float) and not isinstance(value, bool) for value in values):
        alone.sort(key=lambda each: (0 if _is_exact(field, each) else 1, float(str(each.values[field.key]))))
    return alone


def value_word(field: Field, each: Scored) -> str:
    """The value of a field in a reading, as tables write it."""
    return "exact" if _is_exact(field, each) else word(each.values[field.key])


def _is_exact(field: Field, each: Scored) -> bool:
    """Whether the field is dt and no steps of it are taken."""
    return field.name == "dt" and each.values["parameters.integrator"] == "exact"


def _is_alone(each: Scored, field: Field) -> bool:
    reading = each.reading
    return reading.name == DEFAULT.name or (
        reading.family in ("alone", "given")
        and field.key in reading.changes
        and "decisions" not in reading.changes
    )


def profiles(scored: Sequence[Scored], fields: Sequence[Field] = FIELDS) -> pd.DataFrame:
    """What each field does when only it varies.

    Returns:
        One row per field: field, words, tried (values), lowest and highest score, best (its value), tolerated
        (values within tolerance), not_worse (values whose score is not firmly above the
        best), moved (groups whose distance changes by MOVES or more).
    """
    rows = []
    for field in fields:
        along = profile(field, scored)
        best = min(along, key=lambda each: each.score.value)
        distances = pd.DataFrame([group_distances(each.score) for each in along])
        swing = distances.max() - distances.min()
        rows.append({
            "field": field.name, "words": field.words,
            "sourced": ", ".join(f"{word(value)} ({where})" for value, where in field.sourced.items()),
            "default": value_word(field, along_default(along)),
            "tried": _words(along, field), "lowest": best.score.value,
            "highest": max(each.score.value for each in along), "best": value_word(field, best),
            "tolerated": _words([each for each in along if each.score.within], field),
            "not_worse": _words([each for each in along if not firmly_better(best, each)], field),
            "moved": ", ".join(swing[swing >= MOVES].sort_values(ascending=False, kind="stable").index),
        })  # fmt: skip
    return pd.DataFrame(rows)


def along_default(along: Sequence[Scored]) -> Scored:
    """The default among the readings of a profile."""
    return next(each for each in along if each.reading.name == DEFAULT.name)


def firmly_better(one: Scored, other: Scored) -> bool:
    """Whether one score is lower and the 95 % interval of the paired difference excludes 0."""
    return one is not other and one.score.better_by(other.score)[1] > 0


def _words(along: Sequence[Scored], field: Field) -> str:
    return ", ".join(value_word(field, each) for each in along)


def indistinct(scored: Sequence[Scored]) -> tuple[int, int, list[str]]:
    """Readings within tolerance that are not firmly worse than the best of them.

    Returns:
        Their number, the number of readings within tolerance, and their names.
    """
    within = _within(scored)
    if not within:
        return 0, 0, []
    best = min(within, key=lambda each: each.score.value)
    names = [each.reading.name for each in within if each is not best and not firmly_better(best, each)]
    return len(names), len(within), names


def _within(scored: Sequence[Scored]) -> list[Scored]:
    return [each for each in scored if each.score.within and each.reading.is_open]


# What the authors' own figures show, and where: quantity, figure, experiment, column of a run.
QUANTITIES = (
    ("speed of the untrained crawler", "Fig. S1", "untrained", "speed"),
    ("speed of the regularized gait at s = 0.05", "Fig. 3C", "regularized", noisy_speed(0.05)),
    ("speed of the regularized gait at s = 0.2", "Fig. 3C", "regularized", noisy_speed(0.2)),
    ("speed of the unregularized gait at s = 0.05", "Fig. 3C", "unregularized", noisy_speed(0.05)),
    ("speed of the unregularized gait at s = 0.2", "Fig. 3C", "unregularized", noisy_speed(0.2)),
    ("duration of an unregularized cycle", "Fig. 3B", "unregularized", "cycle_duration"),
    ("muscles that the unregularized gait never uses", "Fig. 2B", "unregularized", "unused_muscles"),
    ("peak contraction of the unregularized gait", "Fig. 2B", "unregularized", "peak_contraction"),
    ("range of strain of the regularized gait", "Fig. 2A", "regularized", "strain_range"),
    ("segments contracted at a time, regularized", "Fig. 2A", "regularized", "contracted_segments"),
    ("power per distance, regularized", "Fig. 3A", "regularized", "power_per_distance"),
)  # fmt: skip


def most_discriminating(scored: Sequence[Scored]) -> pd.DataFrame:
    """Which unprinted number would best discriminate between readings within tolerance.

    Returns:
        One row per quantity, the most discriminating first: quantity, figure, low and high (5th and 95th
        percentile over readings), resolution (spread between readings over the median spread between the
        seeds of one), pins (the continuous field that it follows most closely over those readings) and rho
        (its rank correlation).
    """
    within = _within(scored)
    columns = ["quantity", "figure", "low", "high", "resolution", "pins", "rho"]
    rows = []
    for quantity, figure, experiment, column in QUANTITIES:
        of_runs = [each.runs.loc[each.runs["experiment"] == experiment, column].dropna() for each in within]
        middles = [float(stats.interquartile_mean(runs.to_numpy(float))) for runs in of_runs]
        known = np.flatnonzero(np.isfinite(middles))
        if known.size < 3:
            continue
        values = np.array(middles)[known]
        spread = np.median([of_runs[i].std() for i in known])
        low, high = np.percentile(values, [5, 95])
        pins, rho = _follows(values, [within[i] for i in known])
        resolution = values.std(ddof=1) / spread if spread > 0 else np.inf
        rows.append((quantity, figure, low, high, resolution, pins, rho))
    return pd.DataFrame(rows, columns=columns).sort_values("resolution", ascending=False, kind="stable")


def _follows(values: np.ndarray, readings: Sequence[Scored]) -> tuple[str, float]:
    """The continuous field that values follow most closely, and the rank correlation."""
    found = []
    for field in FIELDS:
        constants = [float(str(each.values[field.key])) for each in readings] if field.continuous else [0.0]
        if len(set(constants)) > 2:
            rho = float(scipy_stats.spearmanr(values, constants).statistic)
            found.append((abs(rho), field.name, rho))
    _, name, rho = max(found, default=(0.0, "", float("nan")))
    return name, rho


def conclusions(scored: Sequence[Scored]) -> pd.DataFrame:
    """The share of readings in which each conclusion of the paper holds.

    Three populations: all readings; those whose score over the *other* groups is within tolerance, so that no
    conclusion selects the readings that test it; those within tolerance. Variations of what the paper gives
    are left out.

    Returns:
        One row per conclusion and population: conclusion, population, readings (number), holds (share),
        firmly (share).
    """
    open_ones = [each for each in scored if each.reading.is_open]
    populations = {
        "all readings": open_ones,
        "within tolerance by the other claims": [one for one in open_ones if other_score(one) <= TOLERANCE],
        "within tolerance": _within(scored),
    }
    rows = []
    for conclusion, (holds, firmly) in CONCLUSIONS.items():
        for population, chosen in populations.items():
            shares = [
                np.mean([test(each) for each in chosen]) if chosen else np.nan for test in (holds, firmly)
            ]
            rows.append((conclusion, population, len(chosen), *shares))
    return pd.DataFrame(rows, columns=["conclusion", "population", "readings", "holds", "firmly"])


def other_score(each: Scored) -> float:
    """Score over the groups that belong to none of the three conclusions."""
    return float(group_distances(each.score).drop(list(CONCLUDED)).mean())


def _claim(each: Scored, name: str) -> pd.Series:
    claims = each.score.claims
    row: pd.Series = claims[claims["claim"] == name].iloc[0]
    return row


def _ordering(*names: str) -> tuple[Callable[[Scored], bool], Callable[[Scored], bool]]:
    """Whether all differences have the paper's sign; whether all intervals have it."""
    return (
        lambda each: all(_claim(each, name)["ours"] > 0 for name in names),
        lambda each: all(_claim(each, name)["low"] > 0 for name in names),
    )


def _share(name: str) -> tuple[Callable[[Scored], bool], Callable[[Scored], bool]]:
    """Whether it holds in most of the runs; in at least 80 % of them."""
    return (lambda each: _claim(each, name)["ours"] > 0.5, lambda each: _claim(each, name)["ours"] >= 0.8)


CONCLUSIONS = {
    "the regularized learner finds the nearest-neighbour wiring": _share("nearest_neighbour"),
    "the regularized gait is a wave from tail to head": _share("wave"),
    "the unregularized gait is faster": _ordering("faster"),
    "the unregularized gait is faster (starts that move)": _ordering("faster_moving"),
    "noise reverses the order": _ordering("faster_low_noise", "slower_high_noise"),
    "learning pays, regularized": _ordering("learning_pays"),
    "learning pays, unregularized": _ordering("learning_pays_unregularized"),
}


# How a regularized run ends, by the thresholds of the claims.
ENDS: dict[str, Callable[[pd.DataFrame], pd.Series]] = {
    "ends on the diagonal": lambda runs: runs["diagonal_distance"] == 0,
    "wave from tail to head": lambda runs: runs["wave_order"] > ORDERLY,
    "localized wave": lambda runs: (runs["wave_order"] > ORDERLY) & (runs["contracted_segments"] < LOCAL),
}


def ends(scored: Sequence[Scored], fields: Sequence[Field] = GIVEN) -> pd.DataFrame:
    """How the regularized runs end, along each field; an epsilon of 0 is the unregularized gait.

    Returns:
        One row per field, value and end: field, value, end, share, low, high, n.
    """
    rows = []
    for field in fields:
        along = profile(field, scored)
        chosen = [(each.values[field.key], each, REGULARIZED) for each in along]
        if field.key == REGULARIZATION:
            chosen.insert(0, (0.0, along_default(along), UNREGULARIZED))
        for value, each, experiment in chosen:
            runs = each.runs[each.runs["experiment"] == experiment]
            for end, holds in ENDS.items():
                found = stats.share(holds(runs))
                rows.append((field.name, value, end, found.value, found.low, found.high, found.n))
    return pd.DataFrame(rows, columns=["field", "value", "end", "share", "low", "high", "n"])
