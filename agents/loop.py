"""Eq. 12 of Mishra, van Rees & Mahadevan 2020 [M20], compiled: choose, update, go on to the next decision."""

import numpy as np
from numpy.typing import NDArray

from crawler_bench.envs.randomness import State, random
from crawler_bench.envs.transition import RUNNING, Packed, begin, decide
from crawler_bench.physics.compiled import kernel
from crawler_bench.physics.state import Memory


@kernel
def greedy(values: NDArray[np.float64], rng: State) -> int:
    """Index of the highest of the values, ties broken at random (a tie of m takes m - 1 draws)."""
    best, index, ties = -np.inf, 0, 0
    for a in range(values.size):
        if values[a] > best:
            best, index, ties = values[a], a, 1
        elif values[a] == best:
            ties += 1
            if random(rng) * ties < 1.0:
                index = a
    return index


@kernel
def largest(values: NDArray[np.float64]) -> float:
    """The largest value: NumPy's `max` makes an array, which kernels cannot."""
    best = values[0]
    for value in values[1:]:
        best = max(best, value)
    return float(best)


@kernel
def update(Q: NDArray[np.float64], o: int, a: int, target: float, alpha: float) -> None:
    """Move Q(o, a) towards the target r + gamma max_a' Q(o', a') [M20, eq. 12]."""
    Q[o, a] = (1.0 - alpha) * Q[o, a] + alpha * target


@kernel
def learn_on_crawler(
    Q: NDArray[np.float64],
    o: int,
    n_decisions: int,
    alpha: float,
    gamma: float,
    end_is_terminal: bool,
    rng: State,
    memory: Memory,
    task: Packed,
    env_rng: State,
) -> int:
    """The loop of `QLearning.learn` on the crawler, compiled; gives the same Q to the last bit."""
    for _ in range(n_decisions):
        a = greedy(Q[o], rng)
        o_next, r, _, _, _, end = decide(memory, a, task, env_rng)
        ended = end != RUNNING  # by distance or time, which truncates: worth looking through
        update(Q, o, a, r + (0.0 if ended and end_is_terminal else gamma * largest(Q[o_next])), alpha)
        o = begin(memory, task, env_rng) if ended else o_next
    return o
