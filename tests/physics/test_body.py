"""The force balance on dry ground, checked by the conditions that define it rather than by another solver.

The balance is the minimum of a convex energy, so velocities are right, and unique up to a rigid motion that
meets no resistance, exactly when every node that slides feels its limit, against its motion, and every other
node feels no more than its limits. Forces here are larger than a crawler's muscles, so that nodes stick,
slip forward and slip backward side by side, and the first guess of the states is often a bad one.
"""

from itertools import product
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from crawler_bench.physics.as_printed import force_on_nodes, laplacian_of_chain
from crawler_bench.physics.body import BACKWARD, FORWARD, STUCK, balance_forces
from crawler_bench.physics.coefficients import as_record, coefficients
from crawler_bench.physics.state import make_memory, nodes_of
from tests.bodies import former
from tests.physics.crawling import Crawler

Array = NDArray[np.float64]
STIFFNESS = 3.51
LIMITS = [(0.3, 9.0), (0.3, 3.0), (0.3, 0.4), (0.3, 0.3), (1.0, 0.5)]
GUESSES = ["stuck", "forward", "backward", "random"]


class Balance(NamedTuple):
    """What the solver answered."""

    v: Array
    slip: Array
    solves: int


def balance(g: Array, limits: tuple[float, float], guess: Array, stiffness: float = STIFFNESS) -> Balance:
    """Balance forces g on an undeformed body, where w is the stiffness times the velocity."""
    nodes = nodes_of(make_memory(g.size - 1))
    nodes["net"]["constant"], nodes["slip"], nodes["w"]["constant"] = g, guess, np.nan
    parameters = former(friction_forward=limits[0], friction_backward=limits[1])
    solves = balance_forces(nodes, as_record(coefficients(parameters)))
    return Balance(nodes["w"]["constant"] / stiffness, nodes["slip"].copy(), solves)


def violation(g: Array, limits: tuple[float, float], answer: Balance, stiffness: float = STIFFNESS) -> float:
    """Largest breach of any condition of the balance, as a force; velocities count times the stiffness."""
    forward, backward = limits
    v, slip = answer.v, answer.slip
    assert np.all(np.isfinite(v))
    assert np.all(np.isin(slip, (FORWARD, STUCK, BACKWARD)))
    friction = g - stiffness * laplacian_of_chain(g.size) @ v
    wrong_force = np.select(
        [slip == FORWARD, slip == BACKWARD],
        [np.abs(friction - forward), np.abs(friction + backward)],
        np.maximum(np.maximum(friction - forward, -backward - friction), 0.0),
    )
    wrong_motion = np.select([slip == STUCK], [np.abs(v)], np.maximum(-v * slip, 0.0))
    return float(np.max(np.maximum(wrong_force, stiffness * wrong_motion)))


def internal_forces(rng: np.random.Generator, n_nodes: int, scale: float) -> Array:
    """Each segment pulls or pushes its two ends, some segments not at all."""
    tension = rng.normal(0.0, scale, n_nodes - 1) * (rng.random(n_nodes - 1) < rng.uniform(0.2, 1.0))
    return np.append(0.0, tension) - np.append(tension, 0.0)


def first_guess(rng: np.random.Generator, n_nodes: int, guess: str) -> Array:
    if guess == "random":
        return rng.choice([FORWARD, STUCK, BACKWARD], n_nodes)
    return np.full(n_nodes, {"stuck": STUCK, "forward": FORWARD, "backward": BACKWARD}[guess])


@settings(derandomize=True, deadline=None, max_examples=400)
@given(
    seed=st.integers(0, 2**32 - 1),
    n_segments=st.integers(2, 60),
    log_scale=st.floats(-1.0, 2.0),
    limits=st.sampled_from(LIMITS),
    guess=st.sampled_from(GUESSES),
    push=st.floats(-0.9, 0.9),
)
def test_every_condition_holds(
    seed: int, n_segments: int, log_scale: float, limits: tuple[float, float], guess: str, push: float
) -> None:
    rng = np.random.default_rng(seed)
    n_nodes, scale = n_segments + 1, 10.0**log_scale
    g = internal_forces(rng, n_nodes, scale)
    if seed % 2:  # a push from outside that the ground can hold
        g[rng.integers(n_nodes)] += push * n_nodes * min(limits)
    answer = balance(g, limits, first_guess(rng, n_nodes, guess))
    assert violation(g, limits, answer) < 1e-11 * max(1.0, scale)


@pytest.mark.parametrize("limits", LIMITS)
def test_random_forces_reach_every_state_and_the_slow_path(limits: tuple[float, float]) -> None:
    """Without this, the test above could pass on crawlers that never move."""
    rng = np.random.default_rng(1)
    states, most = set(), 0
    for _ in range(400):
        n_nodes = int(rng.integers(3, 62))
        g = internal_forces(rng, n_nodes, 30.0)
        answer = balance(g, limits, first_guess(rng, n_nodes, "random"))
        assert violation(g, limits, answer) < 1e-10
        states.update(answer.slip)
        most = max(most, answer.solves)
    assert states == {FORWARD, STUCK, BACKWARD}
    assert 8 < most < 400


@pytest.mark.parametrize("limits", LIMITS)
@pytest.mark.parametrize("n_nodes", [2, 3, 4, 5])
def test_brute_force_over_all_states_agrees(limits: tuple[float, float], n_nodes: int) -> None:
    rng = np.random.default_rng(n_nodes)
    for _ in range(12):
        g = internal_forces(rng, n_nodes, 2.0)
        answer = balance(g, limits, first_guess(rng, n_nodes, "random"))
        found = [trial for trial in all_balances(g, limits) if violation(g, limits, trial) < 1e-9]
        if np.any(answer.slip == STUCK):
            assert min(np.max(np.abs(trial.v - answer.v)) for trial in found) < 1e-9
        if found:
            np.testing.assert_allclose(np.diff(found[0].v), np.diff(answer.v), atol=1e-9)


def all_balances(g: Array, limits: tuple[float, float]) -> list[Balance]:
    """Solve, in the sense of least squares, for each of the 3^n assignments of states."""
    laplacian = STIFFNESS * laplacian_of_chain(g.size)
    trials = []
    for states in product((STUCK, FORWARD, BACKWARD), repeat=g.size):
        slip = np.array(states)
        sliding = slip != STUCK
        v = np.zeros(g.size)
        friction = np.where(slip == FORWARD, limits[0], -limits[1])
        v[sliding] = np.linalg.lstsq(laplacian[np.ix_(sliding, sliding)], (g - friction)[sliding])[0]
        trials.append(Balance(v, slip, 0))
    return trials


@settings(derandomize=True, deadline=None, max_examples=150)
@given(
    seed=st.integers(0, 2**32 - 1),
    n_nodes=st.integers(2, 61),
    limits=st.sampled_from(LIMITS),
    guess=st.sampled_from(GUESSES),
)
def test_nothing_moves_while_every_force_is_inside_its_cone(
    seed: int, n_nodes: int, limits: tuple[float, float], guess: str
) -> None:
    rng = np.random.default_rng(seed)
    g = rng.uniform(-limits[1], limits[0], n_nodes) * (1.0 - 1e-9)
    answer = balance(g, limits, first_guess(rng, n_nodes, guess))
    assert np.all(answer.v == 0.0)
    assert np.all(answer.slip == STUCK)


@pytest.mark.parametrize(("excess", "state"), [(-1e-9, STUCK), (1e-9, FORWARD)])
def test_the_forward_limit_is_sharp(excess: float, state: float) -> None:
    g = np.array([0.3 + excess, -0.3 - excess, 0.0])
    answer = balance(g, (0.3, 9.0), np.zeros(3))
    assert answer.slip.tolist() == [state, STUCK, STUCK]
    assert answer.v[0] == pytest.approx(max(excess, 0.0) / STIFFNESS, abs=1e-15)


@pytest.mark.parametrize(("lifted", "slip"), [
    (0.2, [STUCK, STUCK, STUCK]), (0.4, [FORWARD, STUCK, FORWARD]), (-0.2, [STUCK, FORWARD, STUCK]),
])  # fmt: skip
def test_springs_pull_a_node_back_between_its_neighbours(lifted: float, slip: list[float]) -> None:
    """By hand: the middle node is pulled with -2 times its displacement, its neighbours with once that."""
    nodes = nodes_of(make_memory(2))
    nodes["displacement"] = [0.0, lifted, 0.0]
    balance_forces(nodes, as_record(coefficients(former())))
    assert nodes["slip"].tolist() == slip


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_rigid_motion_is_the_middle_of_those_that_friction_allows(way: float) -> None:
    """Limits 0.3 both ways and stiffness 1: nodes 0 and 1 move apart at 2 - 0.6 = 1.4, so at 0.7 each way."""
    g = np.array([1.0, -1.0]) * way
    answer = balance(2.0 * g - 0.6 * g, (0.3, 0.3), np.array([way, -way]), 1.0)
    np.testing.assert_allclose(answer.v, [0.55 * way, -0.55 * way], atol=1e-12)


@pytest.mark.parametrize("imbalance", [0.0, 1e-15, 1e-6, -1e-6])
def test_forces_out_of_balance_stop_a_node_and_rounding_does_not(imbalance: float) -> None:
    """Both nodes may slide only if their forces cancel, up to rounding."""
    answer = balance(np.array([2.0 + imbalance, -2.0]), (0.3, 0.3), np.array([FORWARD, BACKWARD]), 1.0)
    both = [FORWARD, BACKWARD]
    stopped = [FORWARD, STUCK] if imbalance > 0.0 else [STUCK, BACKWARD]
    assert answer.slip.tolist() == (both if abs(imbalance) < 1e-12 else stopped)


@pytest.mark.parametrize("guess", GUESSES)
def test_a_node_slips_backward_where_its_hold_is_weaker_than_what_it_pulls(guess: str) -> None:
    """By hand, with stiffness 1: v = (-2 + 0.4, 0, 1 - 0.3), and node 1 is held with 1 - 1.6 + 0.7 = 0.1."""
    answer = balance(
        np.array([-2.0, 1.0, 1.0]), (0.3, 0.4), first_guess(np.random.default_rng(0), 3, guess), 1.0
    )
    assert answer.slip.tolist() == [BACKWARD, STUCK, FORWARD]
    np.testing.assert_allclose(answer.v, [-1.6, 0.0, 0.7], atol=1e-14)


def test_a_long_tail_drags_the_head_backward_at_the_table_limits() -> None:
    """31 nodes that slide forward at 0.3 resist with 9.3, more than the 9 that hold the head."""
    g = np.append(-500.0, np.full(32, 500.0 / 32))
    answer = balance(g, (0.3, 9.0), np.zeros(g.size))
    assert violation(g, (0.3, 9.0), answer) < 1e-9
    assert answer.slip[0] == BACKWARD
    assert answer.v[0] < -1.0
    assert np.count_nonzero(answer.slip == FORWARD) == 31


@pytest.mark.parametrize("guess", GUESSES)
@pytest.mark.parametrize(
    ("g", "limits"),
    [
        (np.append(-500.0, np.full(30, 500.0 / 30)), (0.3, 9.0)),  # 30 forward nodes balance 1 backward node
        (np.append(np.full(30, 500.0 / 30), -500.0), (0.3, 9.0)),
        (np.array([2.0, -2.0]), (0.3, 0.3)),
        (np.array([1.0, -3.0, 2.0]), (0.2, 0.4)),
        (np.array([-3.5, 2.5, 1.0]), (0.2, 0.4)),
        (np.array([-1.5, 0.0, 0.0, 1.5]), (0.1, 0.1)),
        (np.array([0.5, 0.0, 0.0, 1.0, -0.5, -1.0]), (0.1, 0.1)),
    ],
)
def test_all_nodes_may_slide_when_the_limits_balance(
    g: Array, limits: tuple[float, float], guess: str
) -> None:
    """The matrix is singular: a rigid motion is free, but not one that turns a node against its friction."""
    answer = balance(g, limits, first_guess(np.random.default_rng(0), g.size, guess), 1.0)
    assert np.max(np.abs(answer.v)) < np.sum(np.abs(g)) * g.size
    assert violation(g, limits, answer, 1.0) < 1e-6


@pytest.mark.parametrize(("friction", "mean", "most"), [((0.3, 9.0), 1.2, 4), ((0.05, 0.08), 1.5, 12)])
def test_few_solves_when_started_from_the_step_before(
    friction: tuple[float, float], mean: float, most: int
) -> None:
    """Replay the balance of each step of a long random crawl and count."""
    p = former(friction_forward=friction[0], friction_backward=friction[1])
    crawler = Crawler(p)
    nodes, stiffness = crawler.nodes, p.damping + p.dt
    rng, solves, moving, rest = np.random.default_rng(3), [], 0, np.zeros(p.n_segments + 1)
    for _ in range(60):
        action = int(rng.integers(p.n_segments))
        for _ in range(100):
            before = nodes.copy()
            crawler.advance(action, 1)
            g = force_on_nodes(before["displacement"], rest, nodes["force"], p.damping, p.head_muscle)
            answer = balance(g, friction, before["slip"], stiffness)
            np.testing.assert_allclose(answer.v, nodes["velocity"], atol=1e-9)
            solves.append(answer.solves)
            moving += bool(np.any(answer.slip != STUCK))
    assert moving > 2000
    assert np.mean(solves) < mean
    assert max(solves) <= most
