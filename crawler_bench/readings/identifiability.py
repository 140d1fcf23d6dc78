"""What the claims can tell about the constants, and what the paper's conclusion owes to them."""

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

MOVES = 1.0  # tolerances by which a group's distance changes along a profile that says something
# Groups of the three conclusions, left out where readings are chosen by which a conclusion is tested.
CONCLUDED = ("wave", "localized", "wiring", "faster", "10 % faster", "low noise", "high noise")


def group_distances(score: Score) -> pd.Series:
    """Distance of each group."""
    distances: pd.Series = score.claims.groupby("group")["distance"].mean()
    return distances.reindex(list(GROUPS))


def profile(field: Field, scored: Sequence[Scored]) -> list[Scored]:
    """The default and the readings that change this field alone, in the order of its values."""
    alone = [each for each in scored if _is_alone(each, field)]
    values = [each.values[field.key] for each in alone]
    if all(isinstance(value, int | float) and not isinstance(value, bool) for value in values):
        alone.sort(key=lambda each: (0 if _is_exact(field, each) else 1, float(str(each.values[field.key]))))
    return alone


def value_word(field: Field, each: Scored) -> str:
    """The value that a reading has for a field, in short."""
    return "exact" if _is_exact(field, each) else word(each.values[field.key])


def _is_exact(field: Field, each: Scored) -> bool:
    """Whether a step of dt is asked for where none is taken."""
    return field.name == "dt" and each.values["parameters.integrator"] == "exact"


def _is_alone(each: Scored, field: Field) -> bool:
    reading = each.reading
    return reading.name == DEFAULT.name or (
        reading.family in ("alone", "given")
        and field.key in reading.changes
        and "decisions" not in reading.changes
    )


def profiles(scored: Sequence[Scored], fields: Sequence[Field] = FIELDS) -> pd.DataFrame:
    """What each field does when it alone is varied.

    Returns:
        One row per field: field, words, tried (values), lowest and highest score, best (its value), tolerated
        (values within tolerance), not_worse (values that the score cannot tell from the best: the 95 %
        interval of the paired difference includes 0), moved (groups whose distance changes by MOVES or more).
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
    """Whether one reading's score is lower by more than the training runs explain."""
    return one is not other and one.score.better_by(other.score)[1] > 0


def _words(along: Sequence[Scored], field: Field) -> str:
    return ", ".join(value_word(field, each) for each in along)


def indistinct(scored: Sequence[Scored]) -> tuple[int, int, list[str]]:
    """Readings within tolerance that the score cannot tell from the best of them.

    Returns:
        How many of how many, and their names.
    """
    within = [each for each in scored if each.score.within and each.reading.family != "given"]
    if not within:
        return 0, 0, []
    best = min(within, key=lambda each: each.score.value)
    names = [each.reading.name for each in within if each is not best and not firmly_better(best, each)]
    return len(names), len(within), names


# What the authors' own figures hold, and where: quantity, experiment, column of a run.
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


def telling(scored: Sequence[Scored]) -> pd.DataFrame:
    """Which number that the paper does not print would tell readings within tolerance apart.

    Returns:
        One row per quantity, the most telling first: quantity, figure, low and high (5th and 95th percentile
        over readings), resolution (spread between readings over the median spread between the seeds of one),
        pins (the continuous field that it follows most closely over those readings) and rho (its rank
        correlation).
    """
    within = [each for each in scored if each.score.within and each.reading.family != "given"]
    columns = ["quantity", "figure", "low", "high", "resolution", "pins", "rho"]
    rows = []
    for quantity, figure, experiment, column in QUANTITIES:
        of_runs = [each.runs.loc[each.runs["experiment"] == experiment, column].dropna() for each in within]
        values = np.array([stats.interquartile_mean(runs.to_numpy(float)) for runs in of_runs])
        known = np.isfinite(values)
        if known.sum() < 3:
            continue
        spread = np.median([runs.std() for runs, found in zip(of_runs, known, strict=True) if found])
        low, high = np.percentile(values[known], [5, 95])
        pins, rho = _follows(
            values[known], [each for each, found in zip(within, known, strict=True) if found]
        )
        resolution = values[known].std(ddof=1) / spread if spread > 0 else np.inf
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
    """In what share of readings each conclusion of the paper holds.

    Three populations: all readings; those whose score over the *other* groups is within tolerance, so that no
    conclusion chooses its own witnesses; those within tolerance. The variations of what the paper does give
    are left out.

    Returns:
        One row per conclusion and population: conclusion, population, readings (number), holds (share),
        firmly (share).
    """
    open_ones = [each for each in scored if each.reading.family != "given"]
    populations = {
        "all readings": open_ones,
        "within tolerance by the other claims": [
            each for each in open_ones if other_score(each) <= TOLERANCE
        ],
        "within tolerance": [each for each in open_ones if each.score.within],
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
    """Score over the groups that none of the three conclusions stands in."""
    return float(group_distances(each.score).drop(list(CONCLUDED)).mean())


def _claim(each: Scored, name: str) -> pd.Series:
    claims = each.score.claims
    row: pd.Series = claims[claims["claim"] == name].iloc[0]
    return row


def _ordering(*names: str) -> tuple[Callable[[Scored], bool], Callable[[Scored], bool]]:
    """All have the paper's sign; all have it firmly."""
    return (
        lambda each: all(_claim(each, name)["ours"] > 0 for name in names),
        lambda each: all(_claim(each, name)["low"] > 0 for name in names),
    )


def _share(name: str) -> tuple[Callable[[Scored], bool], Callable[[Scored], bool]]:
    """It holds in most of the runs; in at least 80 % of them."""
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


# What a regularized run ends as, by the thresholds of the claims.
ENDS: dict[str, Callable[[pd.DataFrame], pd.Series]] = {
    "ends on the diagonal": lambda runs: runs["diagonal_distance"] == 0,
    "wave from tail to head": lambda runs: runs["wave_order"] > ORDERLY,
    "localized wave": lambda runs: (runs["wave_order"] > ORDERLY) & (runs["contracted_segments"] < LOCAL),
}


def ends(scored: Sequence[Scored], fields: Sequence[Field] = GIVEN) -> pd.DataFrame:
    """What the regularized runs end as, along each field; an epsilon of 0 is the unregularized gait.

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
