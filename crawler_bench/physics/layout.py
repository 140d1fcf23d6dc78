"""How a crawler lies in memory: one array for its state, one for scratch; a batch is such an array, too."""

import numpy as np
from numpy.typing import NDArray

# Rows of the state.
DISPLACEMENT, VELOCITY, SLIP, NEURON, DRIVE, FORCE = range(6)
N_ROWS = 6
N_WORK_ROWS = 9


def rest_state(n_segments: int) -> NDArray[np.float64]:
    """The undeformed, silent crawler: shape (6, N + 1), all zero."""
    return np.zeros((N_ROWS, n_segments + 1))


def workspace(n_segments: int) -> NDArray[np.float64]:
    """Scratch memory of the kernels, shape (9, N + 1); its content means nothing between calls."""
    return np.empty((N_WORK_ROWS, n_segments + 1))
