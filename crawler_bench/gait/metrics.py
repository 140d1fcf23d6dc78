"""What a gait is like, in numbers: pure functions of a record.

A gait is measured on the part of a record that `Record.after` leaves once the policy has settled; speed and
stalling on the whole record. Thresholds are named here and stated wherever their results are shown.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from crawler_bench.gait.record import Array, Record

CONTRACTED = 0.1  # strain from which on a segment counts as contracted
STALL_ADVANCE = 0.01  # L in the last quarter of a record: less is a stall (a wave carries the body 0.2 L)
ORDERLY = 1 / 3  # wave order from which on a gait is said to have waves at all
TOGETHER = 0.5  # correlation of velocity from which on two neighbouring nodes move together
POWERED = 0.01  # share of the body's peak power from which on a node counts as working
PHASES = 50  # bins of a cycle
BRIEF = 1.0  # tau: a shorter visit to a zone is an excursion (a wave stays ten times as long)
ZONES = 3  # tail, middle, head: a wave has passed when it has gone round them


@dataclass(frozen=True)
class Wave:
    """How the place of greatest contraction travels.

    Attributes:
        order: progress towards the head per distance travelled: 1 is a perfect wave from tail to head, -1 one
            from head to tail, 0 no wave.
        boundaries: times at which a passage ends and the next begins, tau_theta; empty without waves.
    """

    order: float
    boundaries: Array

    @property
    def durations(self) -> Array:
        """Duration of every cycle, tau_theta; empty where no cycle was found."""
        return np.diff(self.boundaries)


def speed(record: Record) -> float:
    """Mean speed of the centroid, L / tau_theta."""
    return float((record.centroid[-1] - record.centroid[0]) / (record.time[-1] - record.time[0]))


def reward(record: Record, regularization: float) -> float:
    """Mean reward of a decision without noise, L [M20, eq. 11]."""
    advance = (record.centroid[-1] - record.centroid[0]) / record.action.size
    return float(advance - regularization * _gradient(record)[1:].mean())


def stalls(record: Record) -> bool:
    """Whether the crawler has come to a stop: less than STALL_ADVANCE in the last quarter of the record."""
    tail = record.after(record.time[0] + 0.75 * (record.time[-1] - record.time[0]))
    return bool(tail.centroid[-1] - tail.centroid[0] < STALL_ADVANCE)


def most_contracted(record: Record) -> NDArray[np.int64]:
    """(T + 1,) index of the most contracted segment, without noise."""
    return np.asarray(record.strain.argmax(axis=1), dtype=np.int64)


def wave(record: Record) -> Wave:
    """Follow the most contracted segment through tail, middle and head.

    Between three zones every change has one direction, while a jump of the index over half of the body has
    none. A visit to a zone that is shorter than BRIEF is an excursion and does not count. Net progress round
    the zones, in units of segments, over the distance that the index travels is the order. A cycle is one
    round: from the moment at which the wave leaves one end of the body for the other to the next such moment.
    """
    n = record.n_segments
    index = most_contracted(record)
    half = n // 2
    travelled = int(np.abs((index[:-1] - index[1:] + half) % n - half).sum())
    times, zones = _zone_visits(record.time, index * ZONES // n)
    progress = np.cumsum((zones[:-1] - zones[1:] + 1) % ZONES - 1)  # towards the head
    if not travelled or not progress.size:
        return Wave(0.0, np.empty(0))
    order = float(np.clip(progress[-1] / ZONES * n / travelled, -1, 1))
    if abs(order) < ORDERLY:
        return Wave(order, np.empty(0))
    # The first passage begins so many zones from the start: where the wave has left the other end.
    first = int(zones[0]) + 1 if order > 0 else ZONES - int(zones[0])
    furthest = np.maximum.accumulate(progress if order > 0 else -progress)
    rounds = np.maximum(furthest - first + ZONES, 0) // ZONES
    return Wave(order, times[1:][np.diff(rounds, prepend=0) > 0])


def _zone_visits(time: Array, zone: NDArray[np.int64]) -> tuple[Array, NDArray[np.int64]]:
    """When each lasting visit to a zone begins, and which zone; successive visits are to different zones.

    The last visit, which the end of the record cuts off, counts as lasting.
    """
    begins = np.flatnonzero(np.diff(zone, prepend=zone[0] - 1))
    lasting = np.diff(time[begins], append=np.inf) >= BRIEF
    begins = begins[lasting]
    visited = zone[begins]
    new = np.diff(visited, prepend=-1) != 0
    return time[begins][new], visited[new]


def peak_contraction(record: Record) -> float:
    """Largest contraction of any segment, in rest lengths."""
    return float(record.strain.max())


def strain_range(record: Record) -> float:
    """Range of a segment's strain, averaged over segments."""
    return float(np.ptp(record.strain, axis=0).mean())


def strain_gradient(record: Record) -> float:
    """Mean over time of the largest change of strain between neighbours, r_2 of [M20, eq. 11]."""
    return float(_gradient(record).mean())


def _gradient(record: Record) -> Array:
    return np.asarray(np.abs(np.diff(record.strain, axis=1)).max(axis=1))


def contracted_segments(record: Record) -> float:
    """Mean number of segments that are contracted by more than CONTRACTED at the same time."""
    return float((record.strain > CONTRACTED).sum(axis=1).mean())


def unused_muscles(record: Record) -> list[int]:
    """Actions that the gait never takes."""
    return sorted(set(range(record.n_segments)) - set(record.action.tolist()))


def visited_observations(record: Record) -> list[int]:
    """Observations that the gait comes across, without noise."""
    return sorted(set(most_contracted(record).tolist()))


def pairs_together(record: Record) -> int:
    """Number of pairs of neighbouring nodes that move together, carrying the segment between them."""
    velocity = record.velocity
    count = 0
    for left, right in pairwise(range(velocity.shape[1])):
        a, b = velocity[:, left], velocity[:, right]
        if a.std() > 0 and b.std() > 0:
            count += bool(np.corrcoef(a, b)[0, 1] > TOGETHER)
    return count


def power_by_phase(record: Record, boundaries: Array) -> Array:
    """Power of each node against the phase of the cycle.

    Args:
        record: the record.
        boundaries: (C + 1,) times between cycles.

    Returns:
        (C, PHASES, N + 1) mean power in each phase bin of each cycle; NaN in a bin without a sample.
    """
    cycles = []
    for start, end in pairwise(boundaries):
        inside = (record.time >= start) & (record.time < end)
        phase = (record.time[inside] - start) / (end - start)
        bins = np.minimum((phase * PHASES).astype(np.int64), PHASES - 1)
        sums = np.zeros((PHASES, record.n_segments + 1))
        np.add.at(sums, bins, record.power[inside])
        counts = np.bincount(bins, minlength=PHASES)[:, None]
        cycles.append(np.where(counts > 0, sums / np.maximum(counts, 1), np.nan))
    return np.array(cycles).reshape(-1, PHASES, record.n_segments + 1)


def power_periodicity(phased: Array) -> float:
    """Mean correlation of one cycle's power profile (all nodes) with the next one's; NaN below 2 cycles."""
    correlations = []
    for one, other in pairwise(phased):
        known = np.isfinite(one) & np.isfinite(other)
        if one[known].std() > 0 and other[known].std() > 0:
            correlations.append(np.corrcoef(one[known], other[known])[0, 1])
    return float(np.mean(correlations)) if correlations else float("nan")


def power_peaks(record: Record) -> Array:
    """(N + 1,) greatest power of each node."""
    return np.asarray(record.power.max(axis=0))


def power_durations(record: Record) -> Array:
    """(N + 1,) share of time in which a node's power exceeds POWERED of the body's greatest."""
    return np.asarray((record.power > POWERED * record.power.max()).mean(axis=0))


def unevenness(of_nodes: Array) -> float:
    """Standard deviation over mean of a quantity over the interior nodes, 1 to N - 1; NaN if it is 0."""
    interior = of_nodes[1:-1]
    mean = interior.mean()
    return float(interior.std() / mean) if mean > 0 else float("nan")


def power_per_distance(record: Record) -> float:
    """Mean power of the whole body over its speed, k L; NaN for a body that does not advance."""
    advance = speed(record)
    return float(record.power.sum(axis=1).mean() / advance) if advance > 0 else float("nan")


def diagonal_distance(policy: NDArray[np.int64]) -> int:
    """Number of observations at which a policy is not nearest-neighbour wiring, action = observation."""
    return int((policy != np.arange(policy.size)).sum())


def off_diagonal(table: Array) -> float:
    """Mean probability of an action other than nearest-neighbour wiring's: 0 on the diagonal."""
    return float(1 - np.diagonal(table).mean())


def policy_text(table: Array) -> str:
    """A policy in short: the action for each observation in turn, one digit each (0-9a-z), * where it draws.

    With more than 36 segments the actions are joined by hyphens.
    """
    actions = table.argmax(axis=1).tolist()
    words = [np.base_repr(action, 36).lower() if len(actions) <= 36 else str(action) for action in actions]
    sure = table.max(axis=1) == 1
    return ("" if len(actions) <= 36 else "-").join(
        word if known else "*" for word, known in zip(words, sure, strict=True)
    )
