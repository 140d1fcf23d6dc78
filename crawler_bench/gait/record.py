"""What a crawler did, as arrays: metrics, figures and films are computed from this alone."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Record:
    """What a crawler did, sampled at the ends of T decisions; sample 0 is the state before the first.

    Attributes:
        time: (T + 1,) tau_theta, from 0.
        displacement: (T + 1, N + 1) u of each node, L.
        velocity: (T + 1, N + 1) du/dt, L / tau_theta.
        force: (T + 1, N + 1) muscle forces, k L.
        power: (T + 1, N + 1) net muscle force on a node times its speed, k L^2 / tau_theta [M20, eq. 13].
        action: (T,) the neuron that was ON during each decision.
    """

    time: Array
    displacement: Array
    velocity: Array
    force: Array
    power: Array
    action: NDArray[np.int64]

    @property
    def strain(self) -> Array:
        """(T + 1, N) strain of each segment, contraction positive."""
        return np.diff(self.displacement, axis=1)

    @property
    def centroid(self) -> Array:
        """(T + 1,) displacement of the centroid, L."""
        return np.asarray(self.displacement.mean(axis=1))

    @property
    def n_segments(self) -> int:
        """Number of segments N."""
        return int(self.displacement.shape[1]) - 1

    def after(self, time: float) -> "Record":
        """The record from a time on, which becomes its first sample."""
        return self._samples(slice(self._index(time), None), slice(self._index(time), None))

    def before(self, time: float) -> "Record":
        """The record up to and including a time."""
        last = self._index(time)
        return self._samples(slice(last + 1), slice(last))

    def _index(self, time: float) -> int:
        return int(np.searchsorted(self.time, time * (1 - 1e-12)))

    def _samples(self, states: slice, decisions: slice) -> "Record":
        return Record(
            self.time[states], self.displacement[states], self.velocity[states], self.force[states],
            self.power[states], self.action[decisions],
        )  # fmt: skip
