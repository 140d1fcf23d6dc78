"""The state of a crawler by name, for kernels and for Python.

A crawler is one row of floats, so a batch of crawlers is one array, and a copy of a row goes on like the
original. `parts` (in kernels) and `nodes_of`, `odometer_of` (in Python) show the same memory as records with
named fields: N + 1 nodes, a clock, an odometer. A field costs no more to read than an entry of an array.
"""

import functools
from collections.abc import Iterator, Sequence
from typing import Any, Protocol, get_type_hints

import numpy as np
from numpy.typing import NDArray

from crawler_bench.physics.compiled import inline_kernel
from crawler_bench.physics.relaxation import Response

Array = NDArray[np.float64]
Memory = Array  # a crawler's row of floats


class Terms(Protocol):
    """A sum: constant + as_e_f e_f(t) + as_r_f r_f(t), with the functions of time of relaxation.py."""

    constant: float
    as_e_f: float
    as_r_f: float


class Node(Protocol):
    """Node i of the body with muscle i and neuron i.

    The exact integrator writes `displacement` and `slip` in each decision, and the rest of the state when
    asked: `exact.trajectory.write_state`.
    """

    # The state [M20, eq. 1-8].
    displacement: float  # u_i, L
    slip: float  # FORWARD, STUCK or BACKWARD, see body.py
    neuron: float  # V_i = tan(theta_i / 2), see neuron.py
    drive: float  # F_i
    velocity: float  # du_i / dt, L / tau_theta
    force: float  # f_i, k L
    # What follows from it.
    power: float  # k L^2 / tau_theta [M20, eq. 13]
    strain: float  # u_{i+1} - u_i, contraction positive; on the tail it means nothing
    # Both integrators: the force balance A w = B f - friction, see body.py.
    muscle: Terms  # f_i, k L
    net: Terms  # row i of B f, k L
    w: Terms  # c du_i / dt + k u_i, k L; u_i on a stuck node
    inverse_pivot: float  # of the elimination; 0 on a stuck node
    # The exact integrator's trajectory, see exact/trajectory.py.
    displacement_at_epoch: float  # what u_i would have been, had node i always moved as now
    cotangent_at_epoch: float  # what cot(theta_i / 2) would have been, had neuron i always been OFF
    drive_at_epoch: float  # what F_i would have been without a spike since
    spike_time: float  # when the neuron spikes next, since the epoch
    limit_time: float  # when the drive falls through 1
    slip_time: float  # when the node starts or stops sliding
    margin: Terms  # what keeps the node in its slip state
    slip_before: float  # slip at the start of the decision


class Nodes(Protocol):
    """N + 1 nodes, head first."""

    size: int

    def __getitem__(self, i: int) -> Node:
        """Node i, which is read and written in place."""

    def __iter__(self) -> Iterator[Node]:
        """Each node in turn."""


class Odometer(Protocol):
    """What is counted over decisions, and what the last one left."""

    lifetime_intervals: float  # decision intervals in all episodes
    lifetime_distance: float  # L
    episode_intervals: float  # decision intervals in this episode
    observation: float  # after the last decision
    centroid: float  # of the nodes, after the last decision, L


class Clock(Protocol):
    """How far the exact integrator has followed its trajectory."""

    has_trajectory: float  # 0 where only the state is known
    now: Response  # the responses at the end of the last decision, counted from the epoch


STATE = ("displacement", "slip", "neuron", "drive", "velocity", "force")
_KINDS = {float: np.float64, int: np.int64, bool: np.int64}  # eight bytes each, so that rows may be floats


@functools.cache
def dtype_of(kind: Any) -> Any:
    """The NumPy record type whose fields are those of an annotated class."""
    hints = get_type_hints(kind)
    return np.dtype((np.record, [(name, _KINDS.get(hint) or dtype_of(hint)) for name, hint in hints.items()]))


ODOMETER, CLOCK, NODE = dtype_of(Odometer), dtype_of(Clock), dtype_of(Node)
LIFETIME = 2  # floats at the start of a row that outlive an episode
_CLOCK = ODOMETER.itemsize // 8
_NODES = _CLOCK + CLOCK.itemsize // 8


@inline_kernel
def parts(memory: Any) -> tuple[Sequence[Odometer], Sequence[Clock], Nodes]:
    """For kernels: the odometer and the clock of a crawler, each the only one of its kind, and its nodes."""
    return memory[:_CLOCK].view(ODOMETER), memory[_CLOCK:_NODES].view(CLOCK), memory[_NODES:].view(NODE)


def nodes_of(memory: Array) -> Any:
    """The nodes of one crawler, (N + 1,) records, or of many, (K, N + 1); the same memory."""
    return memory[..., _NODES:].view(NODE)


def odometer_of(memory: Array) -> Any:
    """The odometer of one crawler, a record, or of many, (K,) records; the same memory."""
    return memory[..., :_CLOCK].view(ODOMETER)[..., 0][()]


def make_memory(n_segments: int) -> Array:
    """The memory of a crawler at rest: undeformed, silent, all zero."""
    return np.zeros(_NODES + (n_segments + 1) * (NODE.itemsize // 8))


def layout() -> list[str]:
    """The names of all floats of a node and of a clock: where they differ, rows of memory do not fit."""
    return [name for kind in (ODOMETER, CLOCK, NODE) for name in _names(kind)]


def _names(kind: Any) -> Iterator[str]:
    for name in kind.names:
        inner = kind[name]
        yield from (f"{name}.{each}" for each in _names(inner)) if inner.names else [name]
