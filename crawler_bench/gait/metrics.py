"""A gait in numbers: pure functions of a record.

Speed and stalling are measured on the whole record; everything else on its last part, once the gait has
settled. Thresholds are named here and stated wherever their results are shown.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from crawler_bench.gait.record import Array, Record

CONTRACTED = 0.1  # strain above which a segment counts as contracted
STALL_ADVANCE = 0.01  # L in the last quarter of a record: less is a stall (a wave carries the body 0.2 L)
ORDERLY = 1 / 3  # least wave order of a gait that has waves
TOGETHER = 0.5  # two neighbouring nodes move together if their velocities correlate above this
POWERED = 0.01  # share of the body's peak power above which a node counts as working
PHASES = 50  # bins per cycle
BRIEF = 1.0  # tau: a shorter visit to a zone is an excursion (a wave stays ten times as long)
ZONES = 3  # tail, middle, head: a wave that has gone round them has passed


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
    """Mean speed of the centroid over the record, L / tau_theta."""
    return float((record.centroid[-1] - record.centroid[0]) / (record.time[-1] - record.time[0]))


def reward(record: Record, regularization: float) -> float:
    """Mean reward per decision, from true strains, L [M20, eq. 11]."""
    advance = (record.centroid[-1] - record.centroid[0]) / record.action.size
    return float(advance - regularization * _gradient(record)[1:].mean())


def stalls(record: Record) -> bool:
    """Whether the crawler has come to a stop: less than STALL_ADVANCE in the last quarter of the record."""
    tail = record.after(record.time[0] + 0.75 * (record.time[-1] - record.time[0]))
    return bool(tail.centroid[-1] - tail.centroid[0] < STALL_ADVANCE)


def most_contracted(record: Record) -> NDArray[np.int64]:
    """(T + 1,) index of the most contracted segment [M20, eq. 9], from true strains."""
    return np.asarray(record.strain.argmax(axis=1), dtype=np.int64)


def wave(record: Record) -> Wave:
    """Follow the most contracted segment through tail, middle and head.

    Every change between three zones has a direction, while a jump of the index over half of the body has
    none. A visit to a zone shorter than BRIEF is an excursion and does not count. The order is the net
    progress round the zones, in segments, over the distance that the index travels. A cycle is one round: it
    begins when the wave leaves one end of the body for the other.
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
    # Zones from the first visit to where the wave leaves the far end, which ends the first passage.
    first = int(zones[0]) + 1 if order > 0 else ZONES - int(zones[0])
    furthest = np.maximum.accumulate(progress if order > 0 else -progress)
    rounds = np.maximum(furthest - first + ZONES, 0) // ZONES
    return Wave(order, times[1:][np.diff(rounds, prepend=0) > 0])


def _zone_visits(time: Array, zone: NDArray[np.int64]) -> tuple[Array, NDArray[np.int64]]:
    """When each visit of at least BRIEF begins, and to which zone; successive visits are to different zones.

    The last visit counts, however short: the end of the record cut it off.
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
    """Range of a segment's strain over time, averaged over segments."""
    return float(np.ptp(record.strain, axis=0).mean())


def strain_gradient(record: Record) -> float:
    """Mean over time of the largest difference of strain between neighbours, r_2 of [M20, eq. 11]."""
    return float(_gradient(record).mean())


def _gradient(record: Record) -> Array:
    return np.asarray(np.abs(np.diff(record.strain, axis=1)).max(axis=1))


def contracted_segments(record: Record) -> float:
    """Mean number of segments contracted at the same time."""
    return float((record.strain > CONTRACTED).sum(axis=1).mean())


def unused_muscles(record: Record) -> list[int]:
    """Actions that the gait never takes."""
    return sorted(set(range(record.n_segments)) - set(record.action.tolist()))


def visited_observations(record: Record) -> list[int]:
    """Observations that occur in the gait."""
    return sorted(set(most_contracted(record).tolist()))


def pairs_together(record: Record) -> int:
    """Number of pairs of neighbouring nodes that move together, carrying the segment between them."""
    return sum(_correlation(one, other) > TOGETHER for one, other in pairwise(record.velocity.T))


def _correlation(one: Array, other: Array) -> float:
    """Pearson's correlation; NaN where either does not vary."""
    varies = one.std() > 0 and other.std() > 0
    return float(np.corrcoef(one, other)[0, 1]) if varies else float("nan")


def power_by_phase(record: Record, boundaries: Array) -> Array:
    """Power of each node against the phase of the cycle.

    Args:
        record: of the gait.
        boundaries: (C + 1,) times between cycles.

    Returns:
        (C, PHASES, N + 1) mean power in each phase bin of each cycle; NaN in an empty bin.
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
        correlations.append(_correlation(one[known], other[known]))
    defined = [each for each in correlations if not np.isnan(each)]
    return float(np.mean(defined)) if defined else float("nan")


def power_peaks(record: Record) -> Array:
    """(N + 1,) peak power of each node, k L^2 / tau_theta."""
    return np.asarray(record.power.max(axis=0))


def power_durations(record: Record) -> Array:
    """(N + 1,) share of time in which each node works."""
    return np.asarray((record.power > POWERED * record.power.max()).mean(axis=0))


def unevenness(of_nodes: Array) -> float:
    """Coefficient of variation over the interior nodes, 1 to N - 1; NaN where their mean is 0."""
    interior = of_nodes[1:-1]
    mean = interior.mean()
    return float(interior.std() / mean) if mean > 0 else float("nan")


def power_per_distance(record: Record) -> float:
    """Mean power of the whole body over its speed, k L; NaN for a body that does not advance."""
    advance = speed(record)
    return float(record.power.sum(axis=1).mean() / advance) if advance > 0 else float("nan")


def diagonal_distance(policy: NDArray[np.int64]) -> int:
    """Number of observations at which the action is not the observation, nearest-neighbour wiring."""
    return int((policy != np.arange(policy.size)).sum())


def off_diagonal(table: Array) -> float:
    """Mean probability of an action other than nearest-neighbour wiring's."""
    return float(1 - np.diagonal(table).mean())


def policy_text(table: Array) -> str:
    """The action at each observation in turn, one digit each (0-9a-z), * where the policy draws.

    With more than 36 segments the actions are decimal and joined by hyphens.
    """
    digits = len(table) <= 36
    words = [
        "*" if row.max() != 1 else np.base_repr(row.argmax(), 36).lower() if digits else str(row.argmax())
        for row in table
    ]
    return ("" if digits else "-").join(words)
