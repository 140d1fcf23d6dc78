"""How speeds are measured: pair by pair, in turns, on one core.

On a shared machine speeds drift by tens of percent within minutes, so only ratios of two things that were
measured in turns, A B A B, mean anything. Times are CPU times of this process with all its threads.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass
from math import nan
from statistics import median

Work = Callable[[int], object]  # makes that number of calls


@dataclass(frozen=True)
class Effort:
    """How long to measure."""

    seconds: float  # of one measurement
    repeats: int  # of each pair
    decisions: int  # in a replayed sequence of actions
    quick: bool  # whether sizes are left out and learning is cut short


FULL = Effort(seconds=0.3, repeats=7, decisions=5000, quick=False)
QUICK = Effort(seconds=0.002, repeats=3, decisions=100, quick=True)


@dataclass(frozen=True)
class Side:
    """One side of a pair: `work(n)` makes n calls of `units` units each."""

    name: str
    work: Work
    units: float = 1.0


@dataclass(frozen=True)
class Measurement:
    """One row of results/speed/measurements.csv."""

    kind: str  # which table it belongs to: ratio, segments, batch, learning or value
    what: str
    value: float  # of a ratio the median over repeats
    unit: str  # of the value; of a ratio what both sides are counted in
    against: str = ""  # the peer of a ratio
    size: int | None = None  # segments, or crawlers in a batch
    low: float = nan  # of the ratio over repeats
    high: float = nan
    per_second: float = nan  # units per second of `what`, median over repeats
    at_least: float = nan  # the goal, NaN for none
    at_most: float = nan

    @property
    def goal_met(self) -> bool:
        """False if there is a goal and the value, or a value that is no number, does not reach it."""
        low_enough = self.at_most != self.at_most or self.value <= self.at_most
        return low_enough and (self.at_least != self.at_least or self.value >= self.at_least)

    def describe(self) -> str:
        """What was measured, its value and its goal in one line."""
        goal = f">= {self.at_least:g}" if self.at_least == self.at_least else f"<= {self.at_most:g}"
        size = f", {self.size}" if self.size else ""
        against = f" against {self.against}" if self.against else f" ({self.unit})"
        return f"{self.what}{size}{against}: {self.value:.3g}, to be {goal}"


def calls_for(work: Work, seconds: float) -> int:
    """How many calls take that long; the first call, which compiles and fills caches, does not count."""
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
    """Units per second of CPU time."""
    start = time.process_time()
    side.work(calls)
    return calls * side.units / (time.process_time() - start)


def compare(ours: Side, peer: Side, unit: str, effort: Effort, at_least: float = nan) -> Measurement:
    """Measure a pair in turns.

    Args:
        ours: what is to be fast.
        peer: what it is held against.
        unit: what both sides are counted in.
        effort: how long.
        at_least: the ratio to reach; NaN for no goal.
    """
    calls = [calls_for(side.work, effort.seconds) for side in (ours, peer)]
    pairs = [(speed(ours, calls[0]), speed(peer, calls[1])) for _ in range(effort.repeats)]
    return summarize(ours.name, peer.name, unit, pairs, at_least)


def summarize(
    what: str, against: str, unit: str, pairs: list[tuple[float, float]], at_least: float = nan
) -> Measurement:
    """A ratio from the speeds of both sides, repeat by repeat."""
    ratios = [ours / peer for ours, peer in pairs]
    return Measurement(
        "ratio", what, median(ratios), unit, against, low=min(ratios), high=max(ratios),
        per_second=median(ours for ours, _ in pairs), at_least=at_least,
    )  # fmt: skip


def seconds_per_unit(side: Side, effort: Effort) -> float:
    """Seconds that a unit of something without a peer takes, median over repeats."""
    calls = calls_for(side.work, effort.seconds)
    return 1.0 / median(speed(side, calls) for _ in range(effort.repeats))
