"""How a crawler lies in memory: one array, (ROWS, N + 1); a batch of crawlers is such an array, too."""

import numpy as np
from numpy.typing import NDArray

# The state as of now. The exact integrator keeps DISPLACEMENT and SLIP up to date and writes the other rows
# when asked (`course.report`) ...
DISPLACEMENT, SLIP, NEURON, DRIVE, VELOCITY, FORCE = range(6)
STATE_ROWS = 6
# ... what follows from it: power of each node, strain of each segment (the last entry means nothing) ...
POWER, STRAIN = 6, 7
# ... the odometer: decisions in this episode, decisions and distance in all episodes (two nodes would be too
# few for it; N >= 2 has three) ...
ODOMETER = 8
EPISODE_DECISIONS, LIFETIME_DECISIONS, LIFETIME_DISTANCE = range(3)
# ... the course that the exact integrator follows from event to event, see physics/course.py. Three rows of
# single numbers: the time since the epoch, whether there is a course, the centroid after the last decision;
# and the six responses at this time ...
EPOCH, RESPONSES = 9, 10
CLOCK, IS_LAID, CENTROID = range(3)
# ... and rows of nodes: what displacements, cotangents of half the phases of neurons, and drives would have
# been at the epoch; force of each muscle, net muscle force on each node, and w, each as its parts that are
# constant, go as e_f, go as r_f; when each neuron spikes, drive falls through its limit; and what keeps each
# node in its state, as parts again.
ORIGIN, PHASE, CHARGE = 12, 13, 14
PULL, PULL_F, PULL_R, NET, NET_F, NET_R, W, W_F, W_R = range(15, 24)
SPIKE_AT, LIMIT_AT = 24, 25
HOLD, HOLD_F, HOLD_R = 26, 27, 28  # they are read up to three entries beyond, see physics/outlook.py
# A copy of all rows up to here goes on like the original; those that follow are scratch for the kernels.
WORK = 29
WORK_ROWS = 7  # a row, those that exact.py keeps, and when each node leaves its state
LEAVE_AT = WORK + WORK_ROWS - 1
ROWS = WORK + WORK_ROWS
PAPER_NODES = 11  # of the crawler of [M20], for which kernels are compiled apart, see envs/transition.py

Memory = NDArray[np.float64]  # (ROWS, N + 1)

NEVER = 1e300  # a time that does not come; finite, so that JSON can hold it


def make_memory(n_segments: int) -> NDArray[np.float64]:
    """The memory of a crawler at rest: undeformed, silent, shape (ROWS, N + 1), all zero."""
    return np.zeros((ROWS, n_segments + 1))


def rest_state(n_segments: int) -> NDArray[np.float64]:
    """The state alone of a crawler at rest: shape (6, N + 1), all zero."""
    return np.zeros((STATE_ROWS, n_segments + 1))


def workspace(n_segments: int) -> NDArray[np.float64]:
    """Scratch memory alone, shape (WORK_ROWS, N + 1); its content means nothing between calls."""
    return np.empty((WORK_ROWS, n_segments + 1))
