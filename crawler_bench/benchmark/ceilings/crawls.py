"""Compiled crawls that keep nothing but what they earn: for searches over millions of them."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from crawler_bench.envs.randomness import State
from crawler_bench.envs.transition import Packed, decide
from crawler_bench.gait.rollout import draw
from crawler_bench.physics.compiled import inner_kernel
from crawler_bench.physics.state import Array, Memory

UNDECIDED = -1  # what a table holds at an observation for which nothing is chosen yet


@inner_kernel
def _copy(source: Any, target: Any) -> None:
    """Copy a row: an assignment of slices counts references, which an inner kernel does not."""
    for i in range(target.size):
        target[i] = source[i]


@inner_kernel
def follow(
    memory: Memory,
    observation: int,
    cumulative: Array,
    task: Packed,
    hold: int,
    noise_rng: State,
    policy_rng: State,
    steps: int,
    visited: NDArray[np.bool_],
) -> float:
    """Follow a table of cumulative action probabilities, as `gait.rollout` does.

    Args:
        memory: of the crawler, moved on.
        observation: what it senses first.
        cumulative: (N, N).
        task: one that observes at every interval.
        hold: intervals after which an action is drawn again though the observation is the same.
        noise_rng: of the noise.
        policy_rng: of the draws.
        steps: intervals.
        visited: (N,) set where an action was drawn.

    Returns:
        The sum of rewards, L.
    """
    total, action, acted_on, held = 0.0, 0, -1, 0
    for _ in range(steps):
        if observation != acted_on or held >= hold:
            action = draw(cumulative[observation], policy_rng)
            acted_on, held = observation, 0
            visited[observation] = True
        made = decide(memory, action, task, noise_rng)
        observation = made.observation
        total += made.reward
        held += 1
    return total


@inner_kernel
def look_ahead(
    memory: Memory,
    observation: int,
    cumulative: Array,
    task: Packed,
    rng: State,
    steps: int,
    horizon: int,
    scratch: Memory,
    visited: NDArray[np.bool_],
) -> float:
    """Take, at every decision, the action after which a table earns the most over a horizon.

    This sees all of the state, in that it tries every action on a copy of the body: one step of policy
    improvement on the table ("rollout", Bertsekas, Tsitsiklis & Wu 1997).

    Args:
        memory: of the crawler, moved on.
        observation: what it senses first.
        cumulative: (N, N) of the table that is improved; it must be deterministic.
        task: without noise.
        rng: only breaks ties.
        steps: decisions.
        horizon: decisions, the first included.
        scratch: another memory.
        visited: (N,) scratch.

    Returns:
        The sum of rewards, L.
    """
    total = 0.0
    for _ in range(steps):
        best, chosen = -np.inf, 0
        for action in range(cumulative.shape[0]):
            _copy(memory, scratch)
            made = decide(scratch, action, task, rng)
            worth = made.reward + follow(
                scratch, made.observation, cumulative, task, 1, rng, rng, horizon - 1, visited
            )
            if worth > best:
                best, chosen = worth, action
        total += decide(memory, chosen, task, rng).reward
    return total


@inner_kernel
def explore(
    memories: Array,
    observation: int,
    table: NDArray[np.int64],
    task: Packed,
    rng: State,
    steps: int,
    most_visited: int,
    limit: float,
    best_table: NDArray[np.int64],
    at: NDArray[np.int64],
    counts: NDArray[np.int64],
    totals: Array,
) -> float:
    """Try every deterministic table from one start, depth first, branching where an observation is new.

    A table is only as large as the observations it visits: two that agree there are one policy.

    Args:
        memories: (N + 2, size) of crawlers: row 0 is the start, the others are scratch.
        observation: what the crawler senses first.
        table: (N,) all UNDECIDED.
        task: without noise.
        rng: only breaks ties.
        steps: decisions of a crawl.
        most_visited: observations; a crawl that comes to one more is given up and counted.
        limit: L; a crawl that could not beat the best even if each further decision earned this is cut.
        best_table: (N,) filled; UNDECIDED where the best crawl never came.
        at: (3, N + 1) scratch: observation, next action and step of each branching.
        counts: (3,) filled: crawls that came to their end, given up, cut.
        totals: (N + 1,) scratch: rewards up to each branching.

    Returns:
        The largest sum of rewards, L.
    """
    best, depth, n = -np.inf, 0, table.size
    work = memories[n + 1]
    at[0, 0], at[1, 0], at[2, 0], totals[0] = observation, 0, 0, 0.0
    while depth >= 0:
        here, action = at[0, depth], at[1, depth]
        if action == n:
            table[here] = UNDECIDED
            depth -= 1
            continue
        at[1, depth] += 1
        table[here] = action
        _copy(memories[depth], work)
        seen, total, step = here, totals[depth], at[2, depth]
        while step < steps and table[seen] != UNDECIDED and total + limit * (steps - step) > best:
            made = decide(work, table[seen], task, rng)
            seen = made.observation
            total += made.reward
            step += 1
        if step == steps:
            counts[0] += 1
            if total > best:
                best = total
                _copy(table, best_table)
        elif table[seen] != UNDECIDED or total + limit * (steps - step) <= best:
            counts[2] += 1
        elif depth + 1 == most_visited:
            counts[1] += 1
        else:
            depth += 1
            _copy(work, memories[depth])
            at[0, depth], at[1, depth], at[2, depth], totals[depth] = seen, 0, step, total
    return best
