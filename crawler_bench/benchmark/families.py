"""Which agents are compared with which: by the question that a pair answers; Holm corrects within one."""

from collections.abc import Mapping
from dataclasses import dataclass

import pandas as pd

from crawler_bench.benchmark.keys import Group

ALL, REGULARIZATION = "all", "regularization"
QUESTIONS = {
    "mode": "does an agent crawl better by its best actions or by those that it draws",
    "reference": "does learning beat what knows nothing or everything",
    "tuning": "what is tuning worth",
    "algorithm": "which algorithm, in its library's own form, crawls best on the index",
    "tuned algorithm": "which algorithm crawls best on the index once tuned",
    "keyhole": "what does seeing more buy",
    "memory": "what does remembering buy, against the index alone and against the whole state",
    REGULARIZATION: "what does regularization change in one agent",
}
REFERENCES = ("random", "still", "wave")
RECURRENT = "recurrent"


@dataclass(frozen=True)
class Trait:
    """What an entry is, see `entries.traits`."""

    algorithm: str
    keyhole: str
    tuned: bool

    @property
    def is_reference(self) -> bool:
        """Whether it learns nothing."""
        return self.algorithm in REFERENCES


def traits_of(frame: pd.DataFrame | None) -> dict[str, Trait]:
    """Traits by name of the entry."""
    rows = [] if frame is None else frame.to_dict("records")
    return {row["agent"]: Trait(row["algorithm"], row["keyhole"], bool(row["tuned"])) for row in rows}


def family(
    first: Group, second: Group, traits: Mapping[str, Trait], modes: Mapping[str, int] | None = None
) -> str | None:
    """The question that a pair answers, of QUESTIONS; None if nobody asks.

    Args:
        first: agent, mode and regularization.
        second: the same of the other.
        traits: by agent; where both agents are unknown, every pair answers ALL.
        modes: how many modes each agent has; two agents with two modes each are compared mode by mode.
    """
    if first[2] != second[2]:
        return REGULARIZATION if first[:2] == second[:2] else None
    if first[0] == second[0]:
        return "mode" if traits else ALL
    if not traits:
        return ALL
    counts = modes or {}
    if first[1] != second[1] and min(counts.get(first[0], 2), counts.get(second[0], 2)) > 1:
        return None
    return _question(traits[first[0]], traits[second[0]])


def _question(one: Trait, other: Trait) -> str | None:
    if one.is_reference or other.is_reference:
        learner = other if one.is_reference else one
        return None if learner.is_reference else "reference"
    if one.tuned != other.tuned:
        same = (one.algorithm, one.keyhole) == (other.algorithm, other.keyhole)
        return "tuning" if same else None
    if one.algorithm == other.algorithm:
        return "keyhole" if one.keyhole != other.keyhole else "algorithm"
    if {one.keyhole, other.keyhole} == {"index"}:
        recurrent = (
            one.algorithm == RECURRENT + other.algorithm or other.algorithm == RECURRENT + one.algorithm
        )
        return "memory" if recurrent else "tuned algorithm" if one.tuned else "algorithm"
    remembering, seeing = (one, other) if one.keyhole == "index" else (other, one)
    wants = (seeing.keyhole, remembering.keyhole, remembering.algorithm)
    return "memory" if wants == ("state", "index", RECURRENT + seeing.algorithm) else None
