"""The study of all readings, and the rule that replaces the default; both were fixed before the first run.

The default changes if another reading with at most as many free constants is within tolerance, has a lower
score than the default on the seeds of the study, and on fresh seeds, which nothing was chosen by, is within
tolerance again, has a score lower by a difference whose 95 % interval (paired seeds) excludes 0, and a share
of runs on the diagonal that is no lower. Of several, the first by rank.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import pandas as pd

from crawler_bench.paper.claims import find_claim
from crawler_bench.paper.verdicts import Results
from crawler_bench.readings.catalogue import DEFAULT, Reading
from crawler_bench.readings.frames import summarize
from crawler_bench.readings.laboratory import Laboratory, Scored
from crawler_bench.readings.sizes import Size

CANDIDATES = 4  # readings that are tried on fresh seeds, beside the default


@dataclass(frozen=True)
class Study:
    """What was found.

    Attributes:
        size: how much was run.
        scored: every reading, in the order of its rank.
        confirmed: the default and its rivals on fresh seeds, the default first.
    """

    size: Size
    scored: list[Scored]
    confirmed: list[Scored]

    @property
    def default(self) -> Scored:
        """The default reading."""
        return next(each for each in self.scored if each.reading.name == DEFAULT.name)

    def confirmation(self) -> pd.DataFrame:
        """The rule applied to each rival: free constants, scores on old and on fresh seeds, verdict."""
        default = self.confirmed[0]
        before = {each.reading.name: each for each in self.scored}
        rows = []
        for each in self.confirmed:
            lower, low, high = each.score.better_by(default.score)
            better = each.score.within and low > 0 and diagonal_share(each) >= diagonal_share(default)
            rows.append({
                "reading": each.reading.name, "free": len(each.free), "n": len(self.size.fresh),
                "score_before": before[each.reading.name].score.value, "score": each.score.value,
                "low": each.score.interval[0], "high": each.score.interval[1], "within": each.score.within,
                "core_failures": " ".join(each.score.core_failures), "diagonal": diagonal_share(each),
                "lower_by": lower, "lower_low": low, "lower_high": high,
                "replaces": bool(better and each is not default),
            })  # fmt: skip
        return pd.DataFrame(rows)


def diagonal_share(scored: Scored) -> float:
    """Share of the regularized runs that end on the diagonal."""
    return find_claim("nearest_neighbour").measure(Results(scored.runs, pd.DataFrame())).value


def conduct(laboratory: Laboratory, readings: Sequence[Reading], size: Size) -> Study:
    """Run every reading, and the best again on fresh seeds."""
    scored = laboratory.run(readings, size.seeds)
    default = next(each for each in scored if each.reading.name == DEFAULT.name)
    by_name = {each.reading.name: each for each in scored}
    ordered = [by_name[name] for name in summarize(scored)["reading"]]
    rivals = [each for each in ordered if is_rival(each, default)][:CANDIDATES]
    confirmed = laboratory.run([each.reading for each in (default, *rivals)], size.fresh)
    return Study(size, ordered, confirmed)


def is_rival(scored: Scored, default: Scored) -> bool:
    """Whether a reading might replace the default, by the seeds of the study."""
    return (
        scored.reading.is_open
        and scored.score.within
        and len(scored.free) <= len(default.free)
        and scored.score.value < default.score.value
    )
