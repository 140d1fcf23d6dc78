"""How speeds are measured: pair by pair, in turns, on one core.

On a shared machine speeds drift by tens of percent within minutes, so only ratios of two things that were
measured in turns, A B A B, mean anything. Times are CPU times of this process with all its threads.
"""

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from statistics import median
from typing import Any

Work = Callable[[int], object]  # does so many units
MAKES_NO_SENSE = float("nan")


@dataclass(frozen=True)
class Effort:
    """How long to measure."""

    seconds: float  # of one measurement
    repeats: int  # of each pair
    quick: bool  # whether learning and scaling are cut down, to see that all works

    @property
    def learning_rounds(self) -> int:
        """Repeats of a pair of learners, which take seconds each."""
        return 2 if self.quick else self.repeats


FULL = Effort(seconds=0.3, repeats=7, quick=False)
QUICK = Effort(seconds=0.01, repeats=5, quick=True)


@dataclass(frozen=True)
class Side:
    """One of a pair: `work(n)` does n calls of `units` units each."""

    name: str
    work: Work
    units: float = 1.0


@dataclass(frozen=True)
class Row:
    """A pair as a row of results/performance/ratios.csv; speeds are medians, units per second."""

    what: str
    peer: str
    unit: str
    per_second: float
    peer_per_second: float
    ratio: float
    ratio_min: float
    ratio_max: float
    repeats: int
    goal: float
    note: str = ""

    def as_dict(self) -> dict[str, Any]:
        """The row by column."""
        return asdict(self)


def calls_for(work: Work, seconds: float) -> int:
    """How many calls take so long; the first ones, which compile and fill caches, do not count."""
    work(1)
    calls = 1
    while True:
        start = time.process_time()
        work(calls)
        taken = time.process_time() - start
        if taken >= seconds / 4:
            return max(1, round(calls * seconds / taken))
        calls *= 4


def speed(side: Side, calls: int) -> float:
    """Units per second."""
    start = time.process_time()
    side.work(calls)
    return calls * side.units / (time.process_time() - start)


def compare(
    ours: Side, peer: Side, unit: str, effort: Effort, goal: float = MAKES_NO_SENSE, note: str = ""
) -> Row:
    """Measure a pair in turns.

    Args:
        ours: what is to be fast.
        peer: what it is held against.
        unit: of which each does so many a second.
        effort: how long.
        goal: ratio that is aimed at; NaN if none is.
        note: anything to know.
    """
    calls = [calls_for(side.work, effort.seconds) for side in (ours, peer)]
    pairs = [(speed(ours, calls[0]), speed(peer, calls[1])) for _ in range(effort.repeats)]
    return summarize(ours.name, peer.name, unit, pairs, goal, note)


def summarize(
    what: str, peer: str, unit: str, pairs: list[tuple[float, float]], goal: float, note: str = ""
) -> Row:
    """A row from the speeds of both sides, repeat by repeat."""
    ratios = [mine / other for mine, other in pairs]
    return Row(
        what, peer, unit, median(mine for mine, _ in pairs), median(other for _, other in pairs),
        median(ratios), min(ratios), max(ratios), len(pairs), goal, note,
    )  # fmt: skip


def missing(what: str, peer: str, unit: str, reason: str) -> Row:
    """The row of a pair of which one side is not installed."""
    nothing = MAKES_NO_SENSE
    return Row(what, peer, unit, nothing, nothing, nothing, nothing, nothing, 0, nothing, reason)


def median_speed(side: Side, effort: Effort) -> float:
    """Units per second of something without a peer."""
    calls = calls_for(side.work, effort.seconds)
    return median(speed(side, calls) for _ in range(effort.repeats))
