"""The best deterministic table: climbs from many random tables, and a certificate for where they end.

A climb changes one entry at a time, as long as that earns more. Among deterministic tables it would soon be
stuck: most stop the body after a few decisions, and no entry of an observation that is never visited matters.
So a climb begins with tables that act at random every other time and visit everything, and lowers that share
step by step to zero. The best of the summits are climbed on by the whole objective, the best of these by
changes of two entries, too.
"""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from crawler_bench.benchmark.ceilings.objective import Objective, Policy

QUICK = (3, 0.5)  # starts and share of the duration with which climbs begin
EXPLORING = (0.5, 0.2, 0.05, 0.0)  # shares of random action, one after the other
FINALISTS = 20  # different summits that are climbed on by the whole objective
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
    """Worths of policies that act at random now and then, each measured once."""

    def __init__(self, objective: Objective, exploring: float = 0.0) -> None:
        self.objective, self.exploring = objective, exploring
        self.known: dict[tuple[int, ...], tuple[float, tuple[int, ...]]] = {}

    def __call__(self, policy: Policy) -> tuple[float, tuple[int, ...]]:
        """Worth, and the visited observations."""
        key = tuple(policy.tolist())
        if key not in self.known:
            table = (1 - self.exploring) * np.eye(policy.size)[policy] + self.exploring / policy.size
            worth, visited = self.objective.of_table(table)
            self.known[key] = worth, tuple(np.flatnonzero(visited).tolist())
        return self.known[key]


def climb(objective: Objective, climbs: int, seed: int) -> Climbed:
    """Climb from random tables, quickly at first and then by the whole objective."""
    n, rng = objective.parameters.n_segments, np.random.default_rng(seed)
    quick = [_Memo(objective.quick(*QUICK), exploring) for exploring in EXPLORING]
    whole = _Memo(objective)
    summits = []
    for _ in range(climbs):
        policy = rng.integers(n, size=n)
        for memo in quick:
            policy = _ascend(memo, policy, rng)
        summits.append(policy)
    order = sorted(summits, key=lambda each: -whole(each)[0])
    finalists = {whole(each)[0]: each for each in reversed(order)}  # tables of one worth do the same
    ends = {
        worth: whole(_ascend(whole, each, rng))[0]
        for worth, each in sorted(finalists.items(), key=lambda each: each[0])[-FINALISTS:]
    }
    policy = _ascend(whole, finalists[max(ends, key=lambda each: ends[each])], rng)
    policy = _ascend(whole, policy, rng, most=2)
    worth = whole(policy)[0]
    worths = [ends.get(whole(each)[0], whole(each)[0]) for each in summits]
    ended = sum(each >= worth - SAME for each in worths)
    return Climbed(policy, worth, climbs, ended, len({round(each, 9) for each in worths}))


def _ascend(memo: _Memo, policy: Policy, rng: np.random.Generator, most: int = 1) -> Policy:
    """Change up to `most` entries at a time, in random order, as long as that earns more."""
    worth, visited = memo(policy)
    moves = list(_moves(policy.size, most))
    improved = True
    while improved:
        improved = False
        for number in rng.permutation(len(moves)):
            changed = _changed(policy, visited, *moves[number])
            if changed is None:
                continue
            found, seen = memo(changed)
            if found > worth + SAME:
                policy, worth, visited, improved = changed, found, seen, True
    return policy


def _moves(n: int, most: int) -> Iterator[tuple[list[int], list[int]]]:
    """All choices of 1 to `most` entries and of actions for them."""
    for count in range(1, most + 1):
        for places in itertools.combinations(range(n), count):
            for actions in itertools.product(range(n), repeat=count):
                yield list(places), list(actions)


def _changed(
    policy: Policy, visited: tuple[int, ...], places: list[int], actions: list[int]
) -> Policy | None:
    """A policy with other actions at all of these places; None if that cannot change what it does.

    A change of two entries, only one of them visited, can matter: the first may lead to the second.
    """
    if not set(places) & set(visited) or (policy[places] == actions).any():
        return None
    changed = policy.copy()
    changed[places] = actions
    return changed


def certify(objective: Objective, policy: Policy) -> Certificate:
    """Measure every change of one or two entries by the whole objective."""
    n = policy.size
    worth, visited = objective.of_policy(policy)
    seen = tuple(np.flatnonzero(visited).tolist())
    changed = (_changed(policy, seen, *move) for move in _moves(n, 2))
    worths = [objective.of_policy(each)[0] for each in changed if each is not None]
    changes = n * (n - 1) + n * (n - 1) // 2 * (n - 1) ** 2
    return Certificate(worth, len(seen), changes, len(worths), max(worths))
