"""Gait metrics on made-up records whose answers are known."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crawler_bench.gait import metrics
from crawler_bench.gait.record import Record

INTERVAL = 0.25  # a power of two: sums of it are exact
DWELL = 4  # samples for which a travelling wave stays on one segment


def make_record(displacement, *, velocity=None, power=None, action=None) -> Record:
    u = np.asarray(displacement, dtype=float)
    velocity, power = (np.zeros_like(u) if each is None else np.asarray(each) for each in (velocity, power))
    action = np.zeros(len(u) - 1, dtype=np.int64) if action is None else np.asarray(action)
    return Record(INTERVAL * np.arange(len(u)), u, velocity, np.zeros_like(u), power, action)


def from_strain(strain) -> Record:
    strain = np.asarray(strain, dtype=float)
    return make_record(np.hstack([np.zeros((len(strain), 1)), np.cumsum(strain, axis=1)]))


def from_index(index, n) -> Record:
    """One segment at a time is contracted, by 0.25."""
    return from_strain(0.25 * np.eye(n)[np.asarray(index)])


def travelling(n, cycles, start=0) -> np.ndarray:
    """Index of the contracted segment of a wave that goes from tail to head and begins again."""
    steps = np.arange(n * cycles * DWELL + 1)
    return (n - 1 - start - steps // DWELL) % n


def drifting(centroid, n=3) -> Record:
    return make_record(np.tile(np.asarray(centroid, dtype=float)[:, None], n + 1))


@pytest.mark.parametrize("n", [3, 4, 10, 25])
@pytest.mark.parametrize("order", [1, -1])  # towards the head, towards the tail
def test_a_perfect_wave(n, order):
    index = travelling(n, cycles=5)
    wave = metrics.wave(from_index(index if order == 1 else n - 1 - index, n))
    period = n * DWELL * INTERVAL
    assert wave.order == order
    np.testing.assert_array_equal(wave.boundaries, period * np.arange(1, 6))
    np.testing.assert_array_equal(wave.durations, np.full(4, period))


@pytest.mark.parametrize("start", range(10))
@pytest.mark.parametrize("mirrored", [False, True])
def test_a_wave_that_is_under_way_ends_its_first_passage_at_the_end_of_the_body(start, mirrored):
    index = travelling(10, cycles=3, start=start)
    wave = metrics.wave(from_index(9 - index if mirrored else index, 10))
    first = (10 - start) * DWELL * INTERVAL  # when it leaves the last segment
    np.testing.assert_array_equal(wave.boundaries, first + 10 * DWELL * INTERVAL * np.arange(3))


def test_two_segments_and_to_and_fro_have_no_direction():
    there = np.repeat(np.arange(10), DWELL)
    to_and_fro = from_index(np.tile(np.hstack([there, there[::-1]]), 8), 10)
    for record in (from_index(travelling(2, cycles=9), 2), to_and_fro):
        wave = metrics.wave(record)
        assert abs(wave.order) < 0.1
        assert wave.boundaries.size == wave.durations.size == 0


@pytest.mark.parametrize("n", [2, 3, 10, 25])
def test_standing_still_is_no_wave(n):
    record = from_strain(np.zeros((50, n)))
    wave = metrics.wave(record)
    assert wave.order == 0
    assert wave.durations.size == 0
    assert metrics.speed(record) == 0
    assert metrics.stalls(record)
    assert metrics.pairs_together(record) == 0
    assert np.isnan(metrics.power_per_distance(record))
    assert np.isnan(metrics.unevenness(metrics.power_peaks(record)))
    assert np.isnan(metrics.unevenness(metrics.power_durations(record)))
    phased = metrics.power_by_phase(record, wave.boundaries)
    assert phased.shape == (0, metrics.PHASES, n + 1)
    assert np.isnan(metrics.power_periodicity(phased))


@pytest.mark.parametrize("n", [3, 10, 25])
def test_a_random_index_is_no_wave(n):
    index = np.random.default_rng(0).integers(n, size=3000)
    wave = metrics.wave(from_index(index, n))
    assert abs(wave.order) < 0.1
    assert wave.boundaries.size == 0


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("mirrored", [False, True])
def test_excursions_over_half_of_the_body_neither_add_nor_lose_cycles(seed, mirrored):
    """One in every passage, for two samples of any dwell; a boundary moves by a zone at most."""
    cycles, period = 12, 10 * DWELL
    index = travelling(10, cycles)
    chosen = DWELL * (np.random.default_rng(seed).integers(10, size=cycles) + 10 * np.arange(cycles)) + 1
    index[chosen] = index[chosen + 1] = (index[chosen] + 5) % 10
    wave = metrics.wave(from_index(9 - index if mirrored else index, 10))
    assert abs(wave.order) == pytest.approx(0.5, abs=0.1)  # every passage travels 20 segments, not 10
    assert wave.boundaries.size == cycles
    exact = period * INTERVAL * np.arange(1, cycles + 1)
    assert np.abs(wave.boundaries - exact).max() <= 4 * DWELL * INTERVAL


def test_speed_and_stalls():
    time = np.arange(401)
    assert metrics.speed(drifting(0.005 * INTERVAL * time)) == pytest.approx(0.005)
    assert not metrics.stalls(drifting(0.005 * INTERVAL * time))
    assert metrics.stalls(drifting(-0.005 * INTERVAL * time))
    assert metrics.stalls(drifting(np.minimum(time, 300) * 0.01))
    assert not metrics.stalls(drifting(np.maximum(time - 300, 0) * 0.01))


@pytest.mark.parametrize(("factor", "stalled"), [(0.9, True), (1.1, False)])
def test_a_stall_is_told_by_the_last_quarter(factor, stalled):
    late = np.linspace(0, factor * metrics.STALL_ADVANCE, 101)
    assert metrics.stalls(drifting(np.hstack([np.linspace(-9, 0, 300), late]))) is stalled


def test_strain_metrics():
    record = from_strain([[0.0, 0.1, 0.3], [0.2, 0.0, -0.1], [0.05, 0.2, 0.0]])
    assert metrics.peak_contraction(record) == pytest.approx(0.3)
    assert metrics.strain_range(record) == pytest.approx((0.2 + 0.2 + 0.4) / 3)
    assert metrics.strain_gradient(record) == pytest.approx((0.2 + 0.2 + 0.2) / 3)
    assert metrics.contracted_segments(from_strain([[0.11, 0.2, 0.09], [0, 0.3, -0.4]])) == 1.5
    assert metrics.visited_observations(record) == [0, 1, 2]
    np.testing.assert_array_equal(metrics.most_contracted(record), [2, 0, 1])


def test_reward_is_advance_less_the_penalized_gradient():
    """A decision is rewarded for the strain at its end: that of the first sample counts for none."""
    record = from_strain([[0.9, 0.0, 0.0], [0.1, 0.0, 0.0], [0.3, 0.0, 0.0]])
    advance = np.diff(record.centroid).mean()
    assert metrics.reward(record, 0.0) == pytest.approx(advance)
    assert metrics.reward(record, 0.5) == pytest.approx(advance - 0.5 * (0.1 + 0.3) / 2)


@pytest.mark.parametrize("time", [0.0, 0.3, 0.9, 3.0])  # 3 x 0.3 is a little less than 0.9
def test_a_record_is_cut_at_a_sample_that_both_parts_share(time):
    record = make_record(np.arange(11.0)[:, None] * np.ones(3), action=np.arange(10) % 2)
    record = replace(record, time=0.3 * np.arange(11))
    before, after = record.before(time), record.after(time)
    assert before.time[-1] == after.time[0] == pytest.approx(time)
    assert before.action.size == before.time.size - 1
    np.testing.assert_array_equal(np.concatenate([before.action, after.action]), record.action)


def test_unused_muscles():
    record = make_record(np.zeros((5, 6)), action=[4, 1, 4, 0])
    assert metrics.unused_muscles(record) == [2, 3]


def test_pairs_of_nodes_that_move_together():
    phase = np.linspace(0, 20 * np.pi, 1000, endpoint=False)[:, None]
    lag = np.array([0, 0, 2, 2, 4, 4.0])  # neighbours of a pair agree; cos 2 < 0 between the pairs
    assert metrics.pairs_together(make_record(np.zeros((1000, 6)), velocity=np.sin(phase + lag))) == 3
    wave = np.sin(phase + np.arange(6) * 1.2)  # cos 1.2 = 0.36 between all neighbours
    assert metrics.pairs_together(make_record(np.zeros((1000, 6)), velocity=wave)) == 0
    half_still = np.sin(phase) * (np.arange(6) > 2)
    assert metrics.pairs_together(make_record(np.zeros((1000, 6)), velocity=half_still)) == 2


def phased_power(profiles) -> tuple[Record, np.ndarray]:
    """Power that follows one profile a cycle, with two samples a bin; and the boundaries."""
    power = np.repeat(np.concatenate(profiles), 2, axis=0)
    samples = 2 * metrics.PHASES
    boundaries = INTERVAL * (samples * np.arange(len(profiles) + 1) - 0.5)  # samples lie inside their bins
    power[::2] *= 0.5
    power[1::2] *= 1.5
    return make_record(np.zeros_like(power), power=power), boundaries


def test_power_by_phase_is_the_profile():
    profiles = np.random.default_rng(0).random((3, metrics.PHASES, 5))
    record, boundaries = phased_power(profiles)
    np.testing.assert_allclose(metrics.power_by_phase(record, boundaries), profiles)
    np.testing.assert_allclose(metrics.power_by_phase(record, boundaries[1:3]), profiles[1:2])


def test_phases_of_a_short_cycle_without_a_sample_are_unknown():
    record = make_record(np.zeros((11, 3)), power=np.ones((11, 3)))
    phased = metrics.power_by_phase(record, np.array([0, 10 * INTERVAL]))
    assert np.isfinite(phased).all(axis=2).sum() == 10
    assert np.nanmax(phased) == np.nanmin(phased) == 1


def test_periodicity_of_power():
    one = np.random.default_rng(0).random((metrics.PHASES, 5))
    flat = np.ones_like(one)
    assert metrics.power_periodicity(np.array([one, one, 3 * one + 1])) == pytest.approx(1)
    assert metrics.power_periodicity(np.array([one, 1 - one])) == pytest.approx(-1)
    assert metrics.power_periodicity(np.array([one, one, 1 - one])) == pytest.approx(0)
    holes = one.copy()
    holes[::3] = np.nan
    assert metrics.power_periodicity(np.array([one, holes])) == pytest.approx(1)
    for unknown in ([one], [flat, flat], [one, flat]):
        assert np.isnan(metrics.power_periodicity(np.array(unknown)))


def test_power_of_nodes():
    power = np.array([[4.0, 1, 0], [0, 2, 0.03], [0, 0, 0.05], [0, 0, 0]])
    record = make_record(np.arange(4)[:, None] * np.full(3, INTERVAL), power=power)
    np.testing.assert_array_equal(metrics.power_peaks(record), [4, 2, 0.05])
    np.testing.assert_array_equal(metrics.power_durations(record), [0.25, 0.5, 0.25])  # above 0.04
    assert metrics.power_per_distance(record) == pytest.approx(power.sum() / 4)


def test_unevenness_is_of_interior_nodes():
    assert metrics.unevenness(np.array([9.0, 2, 2, 2, 7])) == 0
    assert metrics.unevenness(np.array([9.0, 1, 3, 7])) == 0.5
    assert metrics.unevenness(np.array([9.0, 5, 7])) == 0
    assert np.isnan(metrics.unevenness(np.array([9.0, 0, 0, 7])))


def test_distance_to_the_diagonal():
    assert metrics.diagonal_distance(np.arange(10)) == 0
    assert metrics.diagonal_distance(np.array([0, 2, 1, 3])) == 2


def test_policies_as_text():
    assert metrics.policy_text(np.eye(10)) == "0123456789"
    assert metrics.policy_text(np.eye(12)[::-1]) == "ba9876543210"
    assert metrics.policy_text(np.eye(36))[-1] == "z"
    assert metrics.policy_text(np.eye(40)) == "-".join(map(str, range(40)))
    mixed = np.eye(3)
    mixed[1] = [0.5, 0.5, 0]
    assert metrics.policy_text(mixed) == "0*2"


INDICES = st.sampled_from([3, 6, 9, 10]).flatmap(
    lambda n: st.tuples(st.just(n), st.lists(st.integers(0, n - 1), min_size=2, max_size=200))
)


@settings(derandomize=True, deadline=None)
@given(INDICES, st.integers(-5, 5))
def test_metrics_do_not_see_where_the_body_is(body, shift):
    here = from_index(body[1], body[0])
    there = make_record(here.displacement + shift)  # exact: all displacements are quarters
    assert metrics.speed(there) == pytest.approx(metrics.speed(here))
    for name in ("peak_contraction", "strain_range", "strain_gradient", "contracted_segments"):
        assert getattr(metrics, name)(there) == getattr(metrics, name)(here)
    np.testing.assert_array_equal(metrics.wave(here).boundaries, metrics.wave(there).boundaries)


@settings(derandomize=True, deadline=None)
@given(INDICES)
def test_a_wave_of_any_index_is_consistent(body):
    n, index = body
    wave = metrics.wave(from_index(index, n))
    assert -1 <= wave.order <= 1
    assert (wave.durations > 0).all()
    if wave.boundaries.size:
        assert abs(wave.order) >= metrics.ORDERLY
        assert wave.durations.sum() == wave.boundaries[-1] - wave.boundaries[0]
    if n % 3 == 0:  # zones of equal size: a body seen from its other end crawls the other way
        mirrored = metrics.wave(from_index(n - 1 - np.array(index), n))
        assert mirrored.order == -wave.order
        np.testing.assert_array_equal(mirrored.boundaries, wave.boundaries)
