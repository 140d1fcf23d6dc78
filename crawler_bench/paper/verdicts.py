"""What a claim is and how it is judged: one fixed rule for each kind.

A number is reproduced within 10 % of the paper's, partly within 25 %; an ordering is reproduced if the 95 %
interval of the paired difference excludes 0, partly if the difference has the right sign; a share of runs is
reproduced from 80 %, partly from 50 %.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import astuple, dataclass
from enum import Enum
from typing import TYPE_CHECKING

import numpy as np

from crawler_bench.statistics.estimates import Estimate

if TYPE_CHECKING:
    import pandas as pd


class Kind(Enum):
    """What decides how a claim is judged."""

    NUMBER = "number"
    ORDERING = "ordering"
    SHARE = "share"
    OPEN = "open"  # the paper gives nothing to judge by


class Verdict(Enum):
    """How a claim fares."""

    REPRODUCED = "reproduced"
    PARTLY = "partly"
    NOT = "not reproduced"
    OPEN = "no number given"
    MISSING = "no data"


@dataclass(frozen=True)
class Results:
    """Runs and evaluations, as `crawler_bench.runs.results.read_outcomes` returns them."""

    runs: pd.DataFrame
    evaluations: pd.DataFrame

    def of(self, experiment: str, column: str) -> pd.Series:
        """A column of the runs of one experiment, by seed."""
        if self.runs.empty:  # every run failed: there are no columns
            return pd.Series(dtype=float, index=pd.Index([], name="seed", dtype=int))
        runs = self.runs[self.runs["experiment"] == experiment]
        return runs.set_index("seed")[column].astype(float)

    def pair(self, first: str, second: str, column: str) -> tuple[pd.Series, pd.Series]:
        """A column of two experiments, aligned on the seeds that both have."""
        a, b = self.of(first, column).align(self.of(second, column), join="inner")
        return a, b

    def noisy_speed(self, experiment: str) -> pd.DataFrame:
        """Speed against noise, the mean over all starts: one row per seed, one column per amplitude."""
        if self.evaluations.empty:
            return pd.DataFrame()
        chosen = self.evaluations[self.evaluations["experiment"] == experiment]
        return chosen.pivot_table(index="seed", columns="noise", values="speed", aggfunc="mean")


@dataclass(frozen=True)
class Claim:
    """One claim of the paper.

    Attributes:
        name: for the command line.
        text: the claim, and in brackets what we measure.
        source: where the paper makes it.
        kind: decides the rule.
        paper: the paper's value; for an ordering or a share, what it says.
        measure: our estimate; for an ordering a difference that is positive if the paper is right.
        experiments: names of the experiments that it needs.
    """

    name: str
    text: str
    source: str
    kind: Kind
    paper: float | str
    measure: Callable[[Results], Estimate]
    experiments: tuple[str, ...]


def judge(claim: Claim, ours: Estimate) -> Verdict:
    """Apply the rule of the claim's kind."""
    if claim.kind is Kind.OPEN:
        return Verdict.OPEN
    if ours.n == 0 or not np.isfinite(ours.value):
        return Verdict.MISSING
    if claim.kind is Kind.NUMBER:
        distance = abs(ours.value - float(claim.paper)) / abs(float(claim.paper))
        grades = (distance <= 0.10, distance <= 0.25)
    elif claim.kind is Kind.ORDERING:
        grades = (ours.low > 0 and ours.n > 1, ours.value > 0)  # one run alone has no interval
    else:
        grades = (ours.value >= 0.8, ours.value >= 0.5)
    if grades[0]:
        return Verdict.REPRODUCED
    return Verdict.PARTLY if grades[1] else Verdict.NOT


def judge_claims(results: Results, claims: tuple[Claim, ...], options: str = "") -> pd.DataFrame:
    """Judge claims by results.

    Returns:
        One row per claim: claim, source, paper, ours, low, high, n, verdict, command.
    """
    import pandas as pd

    rows = []
    for claim in claims:
        ours = claim.measure(results)
        verdict, command = judge(claim, ours).value, f"crawler-bench reproduce --claim {claim.name}{options}"
        rows.append((claim.text, claim.source, claim.paper, *astuple(ours), verdict, command))
    columns = ["claim", "source", "paper", "ours", "low", "high", "n", "verdict", "command"]
    return pd.DataFrame(rows, columns=columns)
