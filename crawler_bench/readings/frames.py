"""Scored readings as tidy tables: one row per reading, one row per claim, one row per run."""

import json
from collections.abc import Sequence

import pandas as pd

from crawler_bench.paper.claims import find_claim
from crawler_bench.paper.verdicts import judge
from crawler_bench.readings.catalogue import Reading
from crawler_bench.readings.fields import FIELDS, GIVEN
from crawler_bench.readings.laboratory import Scored
from crawler_bench.readings.scoring import rank
from crawler_bench.statistics.estimates import Estimate

SHOWN = ["rank", "reading", "free", "score", "low", "high", "n", "within", "core_failures"]  # in short
OF_RUNS = (
    "experiment", "seed", "policy", "diagonal_distance", "speed", "speed_moving", "speed_learning_end",
    "stall_share", "wave_order", "waves_per_tau", "cycle_duration", "peak_contraction", "strain_range",
    "strain_gradient", "contracted_segments", "unused_muscles", "pairs_together", "power_per_distance", "run",
)  # fmt: skip


def summarize(scored: Sequence[Scored]) -> pd.DataFrame:
    """One row per reading, in the order of their ranks; variations of what the paper gives follow without
    one.

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
    ranked = rank(frame[~given])
    unranked = frame[given].sort_values("score", kind="stable")
    both = pd.concat([ranked, unranked], ignore_index=True).astype({"rank": "Int64"})
    return both[["rank", *(name for name in both if name != "rank")]]


def read_reading(row: dict[str, object]) -> Reading:
    """The reading of a row of `summarize`."""
    return Reading(str(row["reading"]), str(row["family"]), json.loads(str(row["changes"])))


def claims_of(scored: Sequence[Scored]) -> pd.DataFrame:
    """One row per reading and claim, with its verdict and its distance (NaN where it is not counted)."""
    frames = [each.score.claims.assign(reading=each.reading.name) for each in scored]
    claims = pd.concat(frames, ignore_index=True)
    claims["verdict"] = [
        judge(find_claim(row["claim"]), Estimate(row["ours"], row["low"], row["high"], row["n"])).value
        for row in claims.to_dict("records")
    ]
    return claims[["reading", *(name for name in claims if name != "reading")]]


def runs_of(scored: Sequence[Scored]) -> pd.DataFrame:
    """One row per run of every reading."""
    frames = []
    for each in scored:
        if not each.runs.empty:
            noisy = [name for name in each.runs if str(name).startswith("speed_at_noise")]
            frames.append(each.runs[[*OF_RUNS, *noisy]].assign(reading=each.reading.name))
    runs = pd.concat(frames, ignore_index=True)
    return runs[["reading", *(name for name in runs if name != "reading")]]
