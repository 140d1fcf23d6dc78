"""The printed equations against numbers worked out by hand from the paper, never against our other models.

Four nodes, 0 (head) to 3 (tail), suffice: the nodes 1 and 2 are inside. Numbers that are not obvious have
their arithmetic beside them.
"""

from math import exp, log, pi

import numpy as np
import pytest
from numpy.typing import NDArray

from crawler_bench.physics.as_printed import (
    FRICTION_WIDTH,
    drive,
    follow_theta,
    force_inside,
    force_on_head,
    force_on_nodes,
    force_on_tail,
    friction,
    laplacian_of_chain,
    muscle_rate,
    neuron_input,
    next_spike_angle,
    simulate,
    theta_rate,
    velocities,
)
from tests.bodies import former

Array = NDArray[np.float64]
DAMPING = 3.5  # Table S1
REST = np.zeros(4)
HEAD_MUSCLES = ["reaction", "external", "none"]


def unit(node: int) -> Array:
    return np.eye(4)[node]


@pytest.mark.parametrize(
    ("node", "force"),
    [(0, [-1, 1, 0, 0]), (1, [1, -2, 1, 0]), (2, [0, 1, -2, 1]), (3, [0, 0, 1, -1])],
)
def test_springs_and_dampers_pull_a_node_back_and_its_neighbours_along(node: int, force: list[float]) -> None:
    """Eq. 1-3: one node moves forward by 1, or at a velocity of 1 against a damping of 3.5."""
    spring = force_on_nodes(unit(node), REST, REST, DAMPING, "reaction")
    np.testing.assert_array_equal(spring, force)
    np.testing.assert_array_equal(spring, -laplacian_of_chain(4)[node])
    damper = force_on_nodes(REST, unit(node), REST, DAMPING, "reaction")
    np.testing.assert_array_equal(damper, 3.5 * np.array(force))


@pytest.mark.parametrize(
    ("head_muscle", "muscle", "force"),
    [
        ("reaction", 0, [1, -1, 0, 0]),
        ("external", 0, [1, 0, 0, 0]),
        ("none", 0, [0, 0, 0, 0]),
        *[(head_muscle, 1, [-1, 1, 0, 0]) for head_muscle in HEAD_MUSCLES],
        *[(head_muscle, 2, [0, -1, 1, 0]) for head_muscle in HEAD_MUSCLES],
        *[(head_muscle, 3, [0, 0, -1, 1]) for head_muscle in HEAD_MUSCLES],
    ],
)
def test_a_muscle_pulls_the_ends_of_its_segment_together(
    head_muscle: str, muscle: int, force: list[float]
) -> None:
    """Eq. 1-3: segment i lies behind node i - 1, so node i is pulled forward; muscle 0 pushes the head."""
    np.testing.assert_array_equal(force_on_nodes(REST, REST, unit(muscle), DAMPING, head_muscle), force)


def test_each_force_balance_with_all_its_terms() -> None:
    u, v, f = (
        np.array([0.1, 0.4, 0.2, -0.3]),
        np.array([0.02, 0.0, 0.06, 0.01]),
        np.array([0.5, 0.2, 0.7, 0.3]),
    )
    # Eq. 1, node 1: (0.2 - 0.8 + 0.1) + 3.5 (0.06 - 0 + 0.02) + 0.2 - 0.7,
    # node 2: (-0.3 - 0.4 + 0.4) + 3.5 (0.01 - 0.12 + 0) + 0.7 - 0.3.
    np.testing.assert_allclose(force_inside(u, v, f, DAMPING, "external"), [-0.72, -0.285], atol=1e-15)
    np.testing.assert_allclose(force_inside(u, v, f, DAMPING, "reaction"), [-1.22, -0.285], atol=1e-15)
    # Eq. 2: (0.4 - 0.1) + 3.5 (0 - 0.02) + 0.5 - 0.2; eq. 3: (0.2 + 0.3) + 3.5 (0.06 - 0.01) + 0.3.
    assert force_on_head(u, v, f, DAMPING, "external") == pytest.approx(0.53)
    assert force_on_head(u, v, f, DAMPING, "none") == pytest.approx(0.03)
    assert force_on_tail(u, v, f, DAMPING) == pytest.approx(0.975)


@pytest.mark.parametrize(("head_muscle", "total"), [("reaction", 0.0), ("external", 0.8), ("none", 0.0)])
def test_internal_forces_sum_to_zero_unless_the_head_muscle_is_external(
    head_muscle: str, total: float
) -> None:
    rng = np.random.default_rng(0)
    u, v, f = rng.normal(size=(3, 8))
    f[0] = 0.8
    assert force_on_nodes(u, v, f, DAMPING, head_muscle).sum() == pytest.approx(total, abs=1e-14)


def test_a_muscle_relaxes_towards_its_drive_and_no_further_than_its_limit() -> None:
    """Eq. 4: from 0.2 towards 0.9 x 0.8 = 0.72 the rate is 0.52 / 0.7."""
    assert muscle_rate(0.2, 0.8, tau_f=0.7, F_max=0.9) == pytest.approx(0.52 / 0.7)
    assert muscle_rate(0.72, 0.8, tau_f=0.7, F_max=0.9) == pytest.approx(0.0, abs=1e-15)
    for F in (1.0, 1.1, 7.0):
        assert muscle_rate(0.9, F, tau_f=0.7, F_max=0.9) == 0.0
        assert muscle_rate(0.2, F, tau_f=0.7, F_max=0.9) == pytest.approx(1.0)


def test_the_drive_sums_the_decays_of_past_spikes() -> None:
    """Eq. 5, with exp(-1) = 0.367879 and exp(-2) = 0.135335."""
    assert drive(2.0, [0.0, 1.0], tau_m=1.0, gain=1.0) == pytest.approx(0.503215, abs=1e-6)
    assert drive(3.0, [1.0], tau_m=2.0, gain=1.5) == pytest.approx(0.551819, abs=1e-6)
    assert drive(1.0, [1.0, 1.0], tau_m=1.0, gain=1.0) == 2.0
    assert drive(0.99, [1.0], tau_m=1.0, gain=1.0) == 0.0


def test_the_printed_drive_of_a_neuron_left_on_hardly_reaches_the_limiter() -> None:
    """One spike every pi: just after it the sum is 1 / (1 - exp(-pi)) = 1.0452, just before it 0.0452."""
    spikes = [n * pi for n in range(40)]
    assert drive(spikes[-1], spikes, tau_m=1.0, gain=1.0) == pytest.approx(1.045166, abs=1e-6)
    assert drive(40 * pi - 1e-9, spikes, tau_m=1.0, gain=1.0) == pytest.approx(0.045166, abs=1e-6)


@pytest.mark.parametrize(
    ("theta", "I_i", "expected"),
    [
        (0.0, 0.0, 0.0),  # rest
        (pi / 3, 0.0, 0.5),
        (pi / 2, 0.0, 1.0),
        (pi, 0.0, 2.0),
        *[(theta, 1.0, 2.0) for theta in (0.0, pi / 3, pi / 2, pi, -1.0)],  # the cosines cancel
        (pi / 3, 0.5, 1.25),  # 0.5 + 1.5 x 0.5
        (pi / 3, 3.0, 2.0),  # the input counts as 1 at most
    ],
)
def test_the_rate_of_theta(theta: float, I_i: float, expected: float) -> None:
    """Eq. 6."""
    assert theta_rate(theta, I_i, rate=1.0) == pytest.approx(expected)
    assert theta_rate(theta, I_i, rate=2.5) == pytest.approx(2.5 * expected)


@pytest.mark.parametrize(
    ("theta", "at_pi", "at_2_pi"),
    [(0.0, pi, 2 * pi), (-1.0, pi, 0.0), (3.2, 3 * pi, 2 * pi), (6.3, 3 * pi, 4 * pi), (pi, 3 * pi, 2 * pi)],
)
def test_a_neuron_spikes_where_the_reading_says(theta: float, at_pi: float, at_2_pi: float) -> None:
    """Eq. 7, mod(theta - pi, 2 pi) = 0, and its text; a spike that is happening has happened."""
    assert next_spike_angle(theta, "pi") == pytest.approx(at_pi)
    assert next_spike_angle(theta, "2pi") == pytest.approx(at_2_pi, abs=1e-12)


@pytest.mark.parametrize(("phase", "spikes"), [("pi", [pi / 2, 3 * pi / 2]), ("2pi", [pi, 2 * pi])])
def test_a_neuron_left_on_turns_at_a_constant_rate(phase: str, spikes: list[float]) -> None:
    theta, found = follow_theta(0.0, 1.0, 6.5, 1.0, phase)
    assert theta == pytest.approx(13.0)
    assert found == pytest.approx(spikes, abs=1e-7)
    assert follow_theta(0.0, 1.0, 3.25, 2.0, phase)[1] == pytest.approx([t / 2 for t in spikes], abs=1e-7)


def test_a_neuron_switched_off_halfway_to_its_spike_still_spikes_at_pi() -> None:
    """Eq. 6 without input is d/dt cot(theta / 2) = -1, and cot(pi / 4) is 1: pi at 1, 3 pi / 2 at 2."""
    theta, spikes = follow_theta(pi / 2, 0.0, 2.0, 1.0, "pi")
    assert theta == pytest.approx(1.5 * pi)
    assert spikes == pytest.approx([1.0], abs=1e-7)
    assert follow_theta(pi / 2, 0.0, 100.0, 1.0, "2pi")[1] == []


def test_friction_vanishes_at_rest_and_reaches_the_limits_of_table_s1() -> None:
    """Eq. 8 with f_max = 0.3 and eta_f = 30."""
    v = np.array([-1.0, -1e-4, 0.0, 1e-4, 1.0])
    np.testing.assert_allclose(friction(v, 0.3, 9.0), [-9.0, -9.0, 0.0, 0.3, 0.3], atol=1e-14)


def test_friction_is_smooth_over_its_width() -> None:
    """With E = exp(2 v / width), eq. 8 is 9 (E - 1) / (30 E + 1); du^0 is -ln(30) / 2 widths."""
    assert FRICTION_WIDTH == 1e-6
    in_widths = np.array([-0.5 * log(30.0), -1.0, 1.0])
    np.testing.assert_allclose(friction(in_widths * 1e-6, 0.3, 9.0), [-4.35, -1.537923, 0.258234], atol=1e-6)
    np.testing.assert_allclose(
        friction(in_widths * 0.1, 0.3, 9.0, width=0.1), friction(in_widths * 1e-6, 0.3, 9.0)
    )


def test_the_literal_friction_law_makes_9_the_forward_limit() -> None:
    p = former(friction_law="literal")
    limits = friction(np.array([-1.0, 0.0, 1.0]), p.forward_limit, p.backward_limit)
    np.testing.assert_allclose(limits, [-270.0, 0.0, 9.0], atol=1e-12)


def test_each_node_may_have_limits_of_its_own() -> None:
    forward, backward = np.array([0.3, 0.4, 0.5, 0.6]), np.array([9.0, 8.0, 7.0, 6.0])
    np.testing.assert_allclose(friction(np.ones(4), forward, backward), forward)
    np.testing.assert_allclose(friction(REST, forward, backward), REST, atol=1e-14)
    np.testing.assert_allclose(friction(-np.ones(4), forward, backward), -backward)


def test_the_tail_neuron_is_on_with_the_head_neuron() -> None:
    """Eq. 10 and its text."""
    inputs = [[neuron_input(i, action, 3) for i in range(4)] for action in range(3)]
    assert inputs == [[1, 0, 0, 1], [0, 1, 0, 0], [0, 0, 1, 0]]


@pytest.mark.parametrize(("limit", "velocity"), [(0.3, 0.2), (0.65, 0.1)])
def test_the_tail_slides_against_its_own_friction(limit: float, velocity: float) -> None:
    """The tail muscle pulls with 1: 1 - 3.5 v = friction; node 2 is held by 0.3 or 0.65, far below 9."""
    v = velocities(REST, unit(3), DAMPING, "reaction", np.array([0.3, 0.3, 0.3, limit]), 9.0)
    np.testing.assert_allclose(v, [0.0, 0.0, 0.0, velocity], atol=3e-6)


def test_a_node_slips_backward_under_a_strong_muscle() -> None:
    """Muscle 2 pulls with 20; node 1 slips backward with a, node 2 forward with b, node 3 is held by 100.

    Eq. 1: 3.5 (2 a + b) = 20 - 9 and 3.5 (2 b + a) = 20 - 0.3, so a = 2.3 / 10.5 and b = 28.4 / 10.5.
    """
    v = velocities(REST, 20.0 * unit(2), DAMPING, "reaction", np.array([0.3, 0.3, 0.3, 100.0]), 9.0)
    np.testing.assert_allclose(v, [0.0, -2.3 / 10.5, 28.4 / 10.5, 0.0], atol=3e-6)


def test_a_stretched_spring_pulls_the_tail() -> None:
    """The tail lies 1 behind: 1 - 3.5 v = 0.3; the same spring cannot pull node 2 back against 9."""
    v = velocities(-unit(3), REST, DAMPING, "reaction", 0.3, 9.0)
    np.testing.assert_allclose(v, [0.0, 0.0, 0.0, 0.2], atol=3e-6)


def test_the_first_stride() -> None:
    """Neuron 1 of two segments spikes at pi / 4; with gain 2 its drive is above 1 for another ln 2.

    Until then f = 1 - exp(-t / 0.7), with t from the spike. Nodes 0 and 2 are held. Node 1 starts when f is
    0.3 and follows 2 (3.5 du/dt + u) = f - 0.3, which is 0.7 (1 - exp(-s / 0.7)) with s from the start.
    """
    p = former(n_segments=2, decision_interval=0.69)
    crawl = simulate(p, [1, 1])
    assert crawl.spikes == [[], [pytest.approx(pi / 4, abs=1e-7)], []]
    np.testing.assert_allclose(crawl.thetas[-1], [0.0, 4.0 * 1.38, 0.0], atol=1e-9)
    t = 1.38 - pi / 4
    assert t < log(2.0)
    np.testing.assert_allclose(crawl.forces[-1], [0.0, 1.0 - exp(-t / 0.7), 0.0], atol=1e-7)
    s = t - 0.7 * log(1.0 / 0.7)
    response = 1.0 - exp(-s / 3.5) + (exp(-s / 0.7) - exp(-s / 3.5)) / 4.0
    np.testing.assert_allclose(crawl.displacements[-1], [0.0, 0.35 * response, 0.0], atol=1.5e-6)
    assert 0.35 * response > 0.005
