"""The best stochastic table: CMA-ES [Hansen & Ostermeier 2001] over the logits of an (N, N) table.

Every candidate meets the same starts and the same draws; the best mean of the search is then measured with
other draws, so that what is said of it was not chosen by luck.
"""

from dataclasses import dataclass

import numpy as np
from cmaes import CMA

from crawler_bench.benchmark.ceilings.objective import Objective, Policy
from crawler_bench.physics.state import Array

SURE = (
    3.0  # logit with which the search begins at the action of the best deterministic table; the others are 0
)
STEP = 1.0  # standard deviation of the first candidates
FRESH = 12  # seeds of the draws with which the result is measured
_SEARCH_SEED = 1000  # of the draws during the search; no run is measured with it


@dataclass(frozen=True)
class Stochastic:
    """What was found.

    Attributes:
        table: (N, N) probabilities.
        worth: L per decision, mean over FRESH seeds of draws.
        error: its standard error.
        candidates: how many tables were measured.
    """

    table: Array
    worth: float
    error: float
    candidates: int


def evolve(objective: Objective, policy: Policy, generations: int, seed: int) -> Stochastic:
    """Search from a softened deterministic table."""
    n = policy.size
    search = CMA(mean=(SURE * np.eye(n)[policy]).ravel(), sigma=STEP, seed=seed)
    candidates = 0
    for _ in range(generations):
        asked = [search.ask() for _ in range(search.population_size)]
        told = [(x, -objective.of_table(soften(x, n), _SEARCH_SEED)[0]) for x in asked]
        search.tell(told)
        candidates += len(told)
    found = [soften(search.mean, n), np.eye(n)[policy]]  # a deterministic table is a stochastic one, too
    worths = [[objective.of_table(table, each)[0] for each in range(FRESH)] for table in found]
    best = int(np.argmax(np.mean(worths, axis=1)))
    chosen = np.array(worths[best])
    return Stochastic(
        found[best], float(chosen.mean()), float(chosen.std(ddof=1) / np.sqrt(FRESH)), candidates
    )


def soften(logits: Array, n: int) -> Array:
    """(N, N) probabilities of N * N logits; every row sums to 1."""
    rows = logits.reshape(n, n)
    powers = np.exp(rows - rows.max(axis=1, keepdims=True))
    return np.asarray(powers / powers.sum(axis=1, keepdims=True))
