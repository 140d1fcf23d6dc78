"""Scored readings as tidy frames of readings, of claims and of runs."""

import json
from collections.abc import Iterable, Sequence

import pandas as pd

from crawler_bench.paper.claims import find_claim
from crawler_bench.paper.verdicts import judge
from crawler_bench.readings.catalogue import Reading
from crawler_bench.readings.fields import FIELDS, GIVEN
from crawler_bench.readings.laboratory import Scored
from crawler_bench.readings.scoring import rank
from crawler_bench.statistics.estimates import Estimate

SHOWN = ["rank", "reading", "free", "score", "low", "high", "n", "within", "core_failures"]  # on the console
OF_RUNS = (
    "experiment", "seed", "policy", "diagonal_distance", "speed", "speed_moving", "speed_learning_end",
    "stall_share", "wave_order", "waves_per_tau", "cycle_duration", "peak_contraction", "strain_range",
    "strain_gradient", "contracted_segments", "unused_muscles", "pairs_together", "power_per_distance", "run",
)  # fmt: skip


def summarize(scored: Sequence[Scored]) -> pd.DataFrame:
    """One row per reading by rank; variations of what the paper gives follow, without a rank.

    Returns:
        rank, reading, family, score, low, high, within, core_failures, free, free_constants, n, failed,
        changes (JSON), and the value of every field.
    """
    rows = []
    for each in scored:
        low, high = each.score.interval
        rows.append({
            "reading": each.reading.name, "family": each.reading.family, "score": each.score.value,
            "low": low, "high": high, "within": each.score.within,
            "core_failures": " ".join(each.score.core_failures),
            "free": len(each.free), "free_constants": " ".join(each.free),
            "n": int(each.score.claims["n"].max()), "failed": len(each.errors),
            "changes": json.dumps(dict(each.reading.changes)),
            **{field.name: each.values[field.key] for field in (*FIELDS, *GIVEN)},
        })  # fmt: skip
    frame = pd.DataFrame(rows)
    given = frame["family"] == "given"
    unranked = frame[given].sort_values("score", kind="stable")
    both = pd.concat([rank(frame[~given]), unranked], ignore_index=True).astype({"rank": "Int64"})
    both.insert(0, "rank", both.pop("rank"))
    return both


def read_reading(row: dict[str, object]) -> Reading:
    """The reading of a row of `summarize`."""
    return Reading(str(row["reading"]), str(row["family"]), json.loads(str(row["changes"])))


def claims_of(scored: Sequence[Scored]) -> pd.DataFrame:
    """One row per reading and claim, with its verdict and its distance (NaN where it is not counted)."""
    claims = _by_reading((each.reading, each.score.claims) for each in scored)
    claims["verdict"] = [
        judge(find_claim(row["claim"]), Estimate(row["ours"], row["low"], row["high"], row["n"])).value
        for row in claims.to_dict("records")
    ]
    return claims


def runs_of(scored: Sequence[Scored]) -> pd.DataFrame:
    """One row per run of every reading."""
    return _by_reading(
        (each.reading, each.runs[[*OF_RUNS, *each.runs.filter(like="speed_at_noise")]])
        for each in scored
        if not each.runs.empty
    )


def _by_reading(frames: Iterable[tuple[Reading, pd.DataFrame]]) -> pd.DataFrame:
    """All frames as one, with the name of the reading in the first column."""
    named = {reading.name: frame for reading, frame in frames}
    return pd.concat(named, names=["reading"]).reset_index(level="reading").reset_index(drop=True)
