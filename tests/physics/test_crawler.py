"""The whole crawler: against eq. 1-8 as printed, and against what physics says whatever the numbers.

Neurons and muscles are stepped exactly, the body by implicit Euler, so the crawler must approach
what is printed at first order in dt, down to the creep of 1e-6 of a resting node in the printed friction.
Beyond that: no place is special, internal forces push nothing as a whole, nothing moves without a spike, and
friction decides which way is forward.
"""

from collections.abc import Sequence
from dataclasses import replace
from math import pi
from typing import Any

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from crawler_bench.physics import CrawlerParameters
from crawler_bench.physics.as_printed import FRICTION_WIDTH, force_on_nodes, simulate
from crawler_bench.physics.coefficients import Coefficients, coefficients
from crawler_bench.physics.crawler import measure, net_muscle_force
from crawler_bench.physics.state import make_memory, nodes_of
from tests.bodies import former
from tests.physics.crawling import Crawler, held_at_random
from tests.physics.crawling import crawl as crawl_by

Array = NDArray[np.float64]
SIZES = [2, 3, 10, 25]
HEAD_MUSCLES = ["reaction", "external", "none"]


def crawl(p: CrawlerParameters, actions: Sequence[int]) -> Any:
    """Nodes at the start and after each action, in steps: (actions + 1, N + 1)."""
    return crawl_by(replace(p, integrator="step"), actions)


def random_parameters(rng: np.random.Generator, n_segments: int) -> CrawlerParameters:
    forward = rng.uniform(0.05, 0.3)
    return former(
        n_segments=n_segments,
        damping=rng.uniform(0.5, 4.0),
        tau_m=rng.uniform(0.3, 1.5),
        tau_f=rng.uniform(0.3, 1.5),
        muscle_force_max=rng.uniform(0.6, 1.0) * min(1.5, 0.95 * (n_segments + 1) * forward),
        friction_forward=forward,
        friction_backward=rng.uniform(0.2, 9.0),
        head_muscle=str(rng.choice(HEAD_MUSCLES)),
        spike_phase=str(rng.choice(["pi", "2pi"])),
        neuron_rate=rng.uniform(1.0, 4.0),
        spike_gain=rng.uniform(0.8, 3.0),
        dt=1.2 / 1000,
        decision_interval=1.2,
    )


@pytest.mark.parametrize("n_segments", SIZES)
@settings(
    derandomize=True, deadline=None, max_examples=3, phases=(Phase.generate,)
)  # shrinking takes minutes
@given(seed=st.integers(0, 2**32 - 1))
def test_agrees_with_the_printed_equations(n_segments: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    p = random_parameters(rng, n_segments)
    actions = [int(a) for a in np.repeat(rng.integers(min(n_segments, 4), size=3), [2, 1, 1])]
    expected = simulate(p, actions)
    coarse, fine = crawl(p, actions), crawl(replace(p, dt=p.dt / 2), actions)
    np.testing.assert_allclose(fine["force"], expected.forces, atol=2e-7)
    np.testing.assert_allclose(np.sin(2.0 * np.arctan(fine["neuron"])), np.sin(expected.thetas), atol=1e-7)
    extrapolated = 2.0 * fine["displacement"] - coarse["displacement"]
    creep = 2.0 * FRICTION_WIDTH * expected.times[-1]
    np.testing.assert_allclose(extrapolated, expected.displacements, atol=creep + 2e-6)


def test_agrees_with_the_printed_equations_over_a_long_stride() -> None:
    """The Table S1 crawler, held long enough to move far, at the dt of the paper and a hundredth of it."""
    p = former(decision_interval=3.0)
    actions = [0, 9, 0]
    expected = simulate(p, actions).displacements
    assert np.max(np.abs(expected)) > 0.35
    np.testing.assert_allclose(crawl(p, actions)["displacement"], expected, atol=1e-3)
    np.testing.assert_allclose(crawl(replace(p, dt=1e-4), actions)["displacement"], expected, atol=1.5e-5)


@pytest.mark.parametrize("n_segments", SIZES)
@pytest.mark.parametrize("friction", [(0.3, 9.0), (0.1, 0.2)])
def test_first_order_in_dt(n_segments: int, friction: tuple[float, float]) -> None:
    """With 0.1 and 0.2 two forward nodes balance one backward: a free rigid motion has to converge too."""
    p = former(n_segments=n_segments, friction_forward=friction[0], friction_backward=friction[1])
    actions = held_at_random(p, 8, 6, seed=n_segments)

    def end(dt: float) -> Array:
        return crawl(replace(p, dt=dt), actions)["displacement"][-1]

    exact = 2.0 * end(2e-5) - end(4e-5)
    assert np.max(np.abs(exact)) > 0.1
    errors = [np.linalg.norm(end(dt) - exact) for dt in (0.01, 0.005, 0.0025, 0.00125)]
    ratios = np.divide(errors[:-1], errors[1:])
    assert np.all((ratios > 1.7) & (ratios < 2.3)), ratios


@pytest.mark.parametrize("n_segments", SIZES)
@pytest.mark.parametrize("head_muscle", HEAD_MUSCLES)
def test_no_place_is_special(n_segments: int, head_muscle: str) -> None:
    p = former(n_segments=n_segments, head_muscle=head_muscle, friction_forward=0.35)
    here, there = Crawler(p), Crawler(p)
    there.nodes["displacement"] += 3.7
    moved = False
    for action in held_at_random(p, 6, 10, seed=5):
        for crawler in (here, there):
            crawler.advance(action, p.steps_per_decision)
        np.testing.assert_allclose(there.nodes["velocity"], here.nodes["velocity"], atol=1e-12)
        np.testing.assert_allclose(there.nodes["displacement"], here.nodes["displacement"] + 3.7, atol=1e-11)
        moved = moved or bool(np.any(here.nodes["velocity"] > 1e-3))
    assert moved


@pytest.mark.parametrize("n_segments", SIZES)
@pytest.mark.parametrize("head_muscle", HEAD_MUSCLES)
def test_only_an_external_head_muscle_pushes_the_whole_body(n_segments: int, head_muscle: str) -> None:
    p = former(n_segments=n_segments, head_muscle=head_muscle, friction_forward=0.35)
    k, tail, f = coefficients(p), n_segments, np.random.default_rng(2).random(n_segments + 1)
    behind = np.append(f[1:], np.nan)
    net = np.array([net_muscle_force(i, tail, f[i], behind[i], f[0], k) for i in range(tail + 1)])
    assert net.sum() == pytest.approx(f[0] if head_muscle == "external" else 0.0, abs=1e-14)
    rest = np.zeros(n_segments + 1)
    np.testing.assert_allclose(net, force_on_nodes(rest, rest, f, p.damping, head_muscle), atol=1e-15)


@pytest.mark.parametrize("n_segments", SIZES)
def test_nothing_moves_before_the_first_spike(n_segments: int) -> None:
    """A neuron left ON from rest spikes after pi / (2 neuron_rate), then its muscle pulls."""
    p = former(n_segments=n_segments, decision_interval=0.01)
    first_spike = pi / (2.0 * p.neuron_rate)
    history = crawl(p, [1] * 300)
    silent = history[: int(first_spike / p.dt) + 1]
    for name in ("displacement", "velocity", "drive", "force"):
        assert np.all(silent[name] == 0.0)
    assert history["force"][len(silent), 1] > 0.0
    assert history["displacement"][-1, 1] > 0.01
    assert np.all(np.delete(history["force"][-1], 1) == 0.0)


@pytest.mark.parametrize("n_segments", SIZES)
@pytest.mark.parametrize("action", [0, 1])
def test_the_tail_neuron_is_on_with_the_head_neuron_only(n_segments: int, action: int) -> None:
    p = former(n_segments=n_segments)
    history = crawl(p, [action] * 10)
    for name in ("neuron", "drive", "force"):
        assert np.array_equal(history[name][:, -1], history[name][:, 0])
    assert (history["force"][-1, -1] > 0.0) == (action == 0)


@pytest.mark.parametrize("head_muscle", HEAD_MUSCLES)
def test_the_head_muscle_stretches_the_first_segment(head_muscle: str) -> None:
    """All other muscles contract: alone, the tail muscle of the same decision brings up the tail."""
    p = former(head_muscle=head_muscle)
    u = crawl(p, [0] * 10)["displacement"][-1]
    assert (u[0] > 0.05) == (head_muscle != "none")
    assert u[-1] > 0.05
    assert np.all(u[1:-1] >= 0.0)


def centroid_after_crawl(p: CrawlerParameters, time: float, policy: Sequence[int]) -> float:
    """Follow a wiring from the most contracted segment to a muscle, starting at the tail."""
    crawler, observation, centroid = Crawler(p), p.n_segments - 1, 0.0
    for _ in range(round(time / p.decision_interval)):
        crawler.advance(policy[observation], p.steps_per_decision)
        centroid, _ = measure(crawler.nodes)
        observation = int(np.argmax(crawler.nodes["strain"][:-1]))
    return centroid


@pytest.mark.parametrize("n_segments", SIZES)
def test_the_nearest_neighbour_wiring_crawls_forward(n_segments: int) -> None:
    assert centroid_after_crawl(former(n_segments=n_segments), 200.0, range(n_segments)) > 0.3


@pytest.mark.parametrize("n_segments", SIZES)
def test_friction_decides_which_way_is_forward(n_segments: int) -> None:
    """Random actions ratchet the body to where its friction is weaker, by 0.5 to 3 in this time."""
    p = former(n_segments=n_segments)
    turned = replace(p, friction_forward=p.friction_backward, friction_backward=p.friction_forward)
    actions = held_at_random(p, 5, 200, seed=0)
    assert np.mean(crawl(p, actions)["displacement"][-1]) > 0.3
    assert np.mean(crawl(turned, actions)["displacement"][-1]) < -0.3


def test_the_literal_friction_law_holds_the_crawler_still() -> None:
    p = former(friction_law="literal")
    assert centroid_after_crawl(p, 50.0, range(p.n_segments)) == 0.0


def test_measures_of_the_body() -> None:
    nodes = nodes_of(make_memory(3))
    nodes["displacement"] = [0.0, 0.3, 0.1, 0.4]
    assert measure(nodes) == pytest.approx((0.2, 0.5))
    np.testing.assert_allclose(nodes["strain"][:-1], [0.3, -0.2, 0.3])


def test_the_observed_strain_follows_the_reading() -> None:
    signs: dict[str, Coefficients] = {
        reading: coefficients(former(observation=reading))
        for reading in ("most_contracted", "most_stretched")
    }
    assert signs["most_contracted"].contraction_sign == 1.0
    assert signs["most_stretched"].contraction_sign == -1.0
