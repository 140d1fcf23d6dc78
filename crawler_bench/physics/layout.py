"""How a crawler lies in memory: one array, (ROWS, N + 1); a batch of crawlers is such an array, too."""

import numpy as np
from numpy.typing import NDArray

# The state proper, which decides the future ...
DISPLACEMENT, SLIP, NEURON, DRIVE, VELOCITY, FORCE = range(6)
STATE_ROWS = 6
# ... what follows from it: power of each node, strain of each segment (the last entry means nothing) ...
POWER, STRAIN = 6, 7
# ... the odometer: decisions in this episode, decisions and distance in all episodes (two nodes would be too
# few for it; N >= 2 has three) ...
ODOMETER = 8
EPISODE_DECISIONS, LIFETIME_DECISIONS, LIFETIME_DISTANCE = range(3)
# ... and scratch for the kernels.
WORK = 9
WORK_ROWS = 16
ROWS = WORK + WORK_ROWS


def make_memory(n_segments: int) -> NDArray[np.float64]:
    """The memory of a crawler at rest: undeformed, silent, shape (ROWS, N + 1), all zero."""
    return np.zeros((ROWS, n_segments + 1))


def rest_state(n_segments: int) -> NDArray[np.float64]:
    """The state alone of a crawler at rest: shape (6, N + 1), all zero."""
    return np.zeros((STATE_ROWS, n_segments + 1))


def workspace(n_segments: int) -> NDArray[np.float64]:
    """Scratch memory alone, shape (16, N + 1); its content means nothing between calls."""
    return np.empty((WORK_ROWS, n_segments + 1))
