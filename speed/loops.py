"""Compiled loops around what is measured, so that Python takes no part in it.

They call nothing of this package but what is in this file: numba's cache would miss an edit elsewhere.
"""

import numpy as np
from numpy.typing import NDArray

from crawler_bench.envs.randomness import State
from crawler_bench.envs.transition import Packed, begin, decide
from crawler_bench.physics.compiled import kernel
from crawler_bench.physics.state import Memory

Array = NDArray[np.float64]


@kernel
def solve_tridiagonal(
    lower: Array, diagonal: Array, upper: Array, sides: Array, work: Array, n_solves: int
) -> float:
    """Solve a general tridiagonal system by the Thomas algorithm, again and again.

    Args:
        lower: (n,) below the diagonal; entry 0 is not read.
        diagonal: (n,).
        upper: (n,) above the diagonal; the last entry does not matter.
        sides: (m, n) right-hand sides, taken in turn.
        work: (2, n) overwritten: kernels make no arrays.
        n_solves: how many.

    Returns:
        The sum of the first unknowns, so that no solve can be left out.
    """
    n = diagonal.size
    factor, x = work[0], work[1]
    total = 0.0
    for solve in range(n_solves):
        side = sides[solve % sides.shape[0]]
        factor[0] = upper[0] / diagonal[0]
        x[0] = side[0] / diagonal[0]
        for i in range(1, n):
            scale = 1.0 / (diagonal[i] - lower[i] * factor[i - 1])
            factor[i] = upper[i] * scale
            x[i] = (side[i] - lower[i] * x[i - 1]) * scale
        for i in range(n - 2, -1, -1):
            x[i] -= factor[i] * x[i + 1]
        total += x[0]
    return total


@kernel
def replay(memory: Memory, task: Packed, actions: NDArray[np.int64], rng: State, n_rounds: int) -> None:
    """Take a fixed sequence of actions from rest, again and again.

    Args:
        memory: of one crawler.
        task: its task.
        actions: (n,) one per decision.
        rng: breaks ties.
        n_rounds: how often.
    """
    for _ in range(n_rounds):
        begin(memory, task, rng)
        for action in actions:
            decide(memory, action, task, rng)
