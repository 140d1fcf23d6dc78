"""The best deterministic table: climbs from many random tables, and a certificate for where they end.

A climb changes one entry at a time, then two, as long as that earns more. A change of an entry whose
observation the policy never visits changes nothing, so only visited ones are tried.
"""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from crawler_bench.benchmark.ceilings.objective import Objective, Policy

QUICK = (3, 0.5)  # starts and share of the duration with which climbs begin
SAME = 1e-12  # L per decision: less of a difference is rounding


@dataclass(frozen=True)
class Climbed:
    """What climbs found.

    Attributes:
        policy: the best, (N,).
        worth: L per decision.
        climbs: how many random tables they began from.
        ended_there: how many ended at a policy worth as much.
        ends: number of different worths at which they ended.
    """

    policy: Policy
    worth: float
    climbs: int
    ended_there: int
    ends: int


@dataclass(frozen=True)
class Certificate:
    """That no change of one or two entries of a table improves it.

    Attributes:
        worth: of the table, L per decision.
        visited: number of observations that it visits.
        changes: how many changes of one or two entries there are.
        measured: how many of them change what a visited observation does.
        best_change: the worth of the best of these.
    """

    worth: float
    visited: int
    changes: int
    measured: int
    best_change: float

    @property
    def holds(self) -> bool:
        """Whether no change improves the table."""
        return self.best_change <= self.worth + SAME


class _Memo:
    """Worths of policies, each measured once: what a policy does not visit does not matter."""

    def __init__(self, objective: Objective) -> None:
        self.objective = objective
        self.known: dict[tuple[int, ...], tuple[float, tuple[int, ...]]] = {}

    def __call__(self, policy: Policy) -> tuple[float, tuple[int, ...]]:
        """Worth, and the visited observations."""
        key = tuple(policy.tolist())
        if key not in self.known:
            worth, visited = self.objective.of_policy(policy)
            self.known[key] = worth, tuple(np.flatnonzero(visited).tolist())
        return self.known[key]


def climb(objective: Objective, climbs: int, seed: int) -> Climbed:
    """Climb from random tables, quickly at first and then by the whole objective."""
    n = objective.parameters.n_segments
    rng, quick, whole = np.random.default_rng(seed), _Memo(objective.quick(*QUICK)), _Memo(objective)
    summits: dict[tuple[int, ...], tuple[float, Policy]] = {}
    worths: list[float] = []
    best: tuple[float, Policy] = (-np.inf, np.zeros(n, dtype=np.int64))
    for _ in range(climbs):
        slope = _ascend(quick, rng.integers(n, size=n))
        visited = quick(slope)[1]
        key = tuple(slope[list(visited)].tolist()) + visited
        if key not in summits:
            summit = _ascend(whole, slope)
            summits[key] = whole(summit)[0], summit
        worths.append(summits[key][0])
        best = max(best, summits[key], key=lambda each: each[0])
    policy = _ascend(whole, best[1], pairs=True)
    worth = whole(policy)[0]
    ended = sum(each >= worth - SAME for each in worths)
    return Climbed(policy, worth, climbs, ended, len({round(each, 9) for each in worths}))


def _ascend(memo: _Memo, policy: Policy, *, pairs: bool = False) -> Policy:
    """Change entries as long as that earns more: one, or also two at a time."""
    worth, visited = memo(policy)
    improved = True
    while improved:
        improved = False
        for changed in _changes(policy, visited, 2 if pairs else 1):
            found, seen = memo(changed)
            if found > worth + SAME:
                policy, worth, visited, improved = changed, found, seen, True
                break
    return policy


def _changes(policy: Policy, visited: tuple[int, ...], most: int) -> Iterator[Policy]:
    """Every change of 1 to `most` entries that changes what the policy does.

    A change of two entries, only one of them visited, can matter, too: the first may lead to the second.
    """
    n = policy.size
    for count in range(1, most + 1):
        for places in itertools.combinations(range(n), count):
            if not set(places) & set(visited):
                continue
            others = [[a for a in range(n) if a != policy[place]] for place in places]
            for actions in itertools.product(*others):
                changed = policy.copy()
                changed[list(places)] = actions
                yield changed


def certify(objective: Objective, policy: Policy) -> Certificate:
    """Measure every change of one or two entries by the whole objective."""
    n = policy.size
    worth, visited = objective.of_policy(policy)
    seen = tuple(np.flatnonzero(visited).tolist())
    worths = [objective.of_policy(changed)[0] for changed in _changes(policy, seen, 2)]
    changes = n * (n - 1) + n * (n - 1) // 2 * (n - 1) ** 2
    return Certificate(worth, len(seen), changes, len(worths), max(worths))
