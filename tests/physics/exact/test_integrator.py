"""The exact integrator: what the stepped one converges to, whatever the parameters."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from crawler_bench.physics import integration
from crawler_bench.physics.as_printed import force_on_nodes, simulate
from crawler_bench.physics.exact import integrator
from crawler_bench.physics.exact.integrator import cross_decision
from crawler_bench.physics.integration import act
from crawler_bench.physics.state import STATE
from tests.bodies import former
from tests.physics.crawling import Crawler, crawl, drawn, plain

Array = NDArray[np.float64]
PAPER = {"spike_phase": "every_pi", "tau_f": 0.4, "neuron_rate": 1.59, "spike_gain": 1.0}
READINGS: list[dict[str, Any]] = [
    {},
    {"head_muscle": "external", **PAPER},
    {"head_muscle": "external"},
    {"head_muscle": "none", "spike_phase": "2pi"},
    {"spike_phase": "every_pi", "spike_gain": 1.0},
    {"friction_forward": 0.05, "friction_backward": 0.08},
    {"friction_forward": 0.05, "friction_backward": 0.05},
    {"tau_f": 1.0},
    {"tau_f": 1.0, "damping": 1.0},
    {"damping": 0.7},
    {"n_segments": 2},
    {"n_segments": 31, "neuron_rate": 4.0, "spike_gain": 0.7},
]


@pytest.mark.parametrize("reading", READINGS, ids=str)
def test_the_steps_converge_to_it_at_first_order(reading: dict[str, Any]) -> None:
    p = former(**reading)
    actions = drawn(p, 80)
    exact = crawl(p, actions)["displacement"]
    stepped = [replace(p, integrator="step", dt=dt) for dt in (0.01, 0.005, 0.0025)]
    errors = np.array([np.abs(crawl(each, actions)["displacement"] - exact).max() for each in stepped])
    assert np.abs(exact[-1]).max() > 0.05
    assert errors[0] < 0.01
    np.testing.assert_allclose(errors[:-1] / errors[1:], 2.0, atol=0.15)


@pytest.mark.parametrize("reading", READINGS, ids=str)
def test_neurons_and_muscles_agree_with_the_steps_to_rounding(reading: dict[str, Any]) -> None:
    """Both integrators have them in closed form."""
    p = former(**reading)
    actions = drawn(p, 80)
    exact, stepped = crawl(p, actions), crawl(replace(p, integrator="step"), actions)
    for name in ("drive", "force"):
        np.testing.assert_allclose(exact[name], stepped[name], atol=1e-11)
    angles = [2.0 * np.arctan(trail["neuron"]) for trail in (exact, stepped)]
    np.testing.assert_allclose(np.cos(angles[0]), np.cos(angles[1]), atol=1e-10)


@pytest.mark.parametrize("reading", READINGS, ids=str)
def test_it_does_not_matter_where_decisions_are_cut(reading: dict[str, Any]) -> None:
    """Twenty decisions of 0.01 with the same neuron ON are one decision of 0.2."""
    p = former(**reading)
    actions = drawn(p, 100)
    whole = crawl(p, actions)
    cut = crawl(replace(p, decision_interval=0.01), np.repeat(actions, 20).tolist())[::20]
    for name in ("displacement", "force"):
        np.testing.assert_allclose(cut[name], whole[name], atol=1e-11)


@pytest.mark.parametrize("phase", ["pi", "2pi", "every_pi"])
@pytest.mark.parametrize("held", [5, 50])
def test_long_decisions_hold_many_spikes(held: int, phase: str) -> None:
    p = former(spike_phase=phase)
    actions = drawn(p, 6)
    long = crawl(replace(p, decision_interval=0.2 * held), actions)
    short = crawl(p, np.repeat(actions, held).tolist())[::held]
    for name in ("displacement", "force"):
        np.testing.assert_allclose(long[name], short[name], atol=1e-11)


@pytest.mark.parametrize("reading", READINGS, ids=str)
def test_halved_tolerances_change_nothing_that_matters(reading: dict[str, Any]) -> None:
    p = former(**reading)
    actions = drawn(p, 500)  # 100 tau
    one, other = (crawl(p, actions, tolerance)["displacement"][-1] for tolerance in (1e-13, 5e-14))
    assert abs(one.mean() - other.mean()) < 1e-9


@settings(max_examples=25, deadline=None, derandomize=True, phases=[Phase.generate])
@given(
    n=st.integers(2, 12),
    damping=st.floats(0.3, 6.0),
    taus=st.tuples(st.floats(0.2, 2.0), st.floats(0.2, 2.0)),
    limits=st.tuples(st.floats(0.05, 0.5), st.floats(0.05, 9.0)),
    neuron=st.tuples(st.floats(0.5, 4.0), st.floats(0.5, 4.0)),
    seed=st.integers(0, 1000),
)
def test_forces_balance_at_the_end_of_every_decision(
    n: int,
    damping: float,
    taus: tuple[float, float],
    limits: tuple[float, float],
    neuron: tuple[float, float],
    seed: int,
) -> None:
    """Friction is at its limit against every sliding node, and holds every stuck one from inside."""
    p = former(
        n_segments=n, damping=damping, tau_m=taus[0], tau_f=taus[1], friction_forward=limits[0],
        friction_backward=limits[1], neuron_rate=neuron[0], spike_gain=neuron[1],
    )  # fmt: skip
    for state in crawl(p, drawn(p, 150, seed))[1:]:
        u, v, slip, f = (state[name] for name in ("displacement", "velocity", "slip", "force"))
        friction = force_on_nodes(u, v, f, damping, p.head_muscle)
        forward, backward = slip > 0, slip < 0
        np.testing.assert_allclose(friction[forward], p.forward_limit, atol=1e-10)
        np.testing.assert_allclose(friction[backward], -p.backward_limit, atol=1e-10)
        assert (friction < p.forward_limit + 1e-10).all()
        assert (friction > -p.backward_limit - 1e-10).all()
        assert (v[forward] > -1e-11).all()
        assert (v[backward] < 1e-11).all()
        assert (v[slip == 0] == 0).all()


@pytest.mark.parametrize(
    "reading", [{"n_segments": 2}, {"n_segments": 10}, {"tau_f": 1.0, "n_segments": 3}], ids=str
)
def test_it_agrees_with_the_printed_equations(reading: dict[str, Any]) -> None:
    """With the printed tanh friction; what differs is that friction's own creep."""
    p = former(**reading, decision_interval=0.8)
    actions = drawn(p, 6, 3)
    expected = simulate(p, actions)
    ours = crawl(p, actions)
    np.testing.assert_allclose(ours["displacement"][-1], expected.displacements[-1], atol=1e-5)
    assert np.abs(expected.displacements[-1]).max() > 0.05


def test_equal_time_constants_are_the_limit_of_near_ones() -> None:
    for base in ({"tau_f": 1.0}, {"tau_f": 1.0, "damping": 1.0}, {"damping": 0.7}, {"damping": 1.0}):
        p = former(**base)
        near = replace(p, tau_m=p.tau_m * (1 + 1e-7), damping=p.damping * (1 - 1e-7))
        actions = drawn(p, 100)
        np.testing.assert_allclose(
            crawl(near, actions)["displacement"], crawl(p, actions)["displacement"], atol=1e-5
        )


@pytest.mark.parametrize("reading", READINGS, ids=str)
def test_the_trajectory_is_that_of_the_state(reading: dict[str, Any]) -> None:
    """A crawler known by its state alone goes on like one that has kept its trajectory."""
    p = former(**reading)
    crawler = Crawler(p)
    for action in drawn(p, 60):
        forgetful = Crawler(p)
        for name in STATE:
            forgetful.nodes[name] = crawler.nodes[name]
        for each in (crawler, forgetful):
            each.act(action)
        for name in ("displacement", "drive", "force"):
            np.testing.assert_allclose(forgetful.nodes[name], crawler.nodes[name], atol=1e-12)


def test_writing_the_state_changes_nothing_to_come() -> None:
    p = former()
    crawler, silent = Crawler(p), Crawler(p)
    for action in drawn(p, 100):
        crawler.act(action)
        act(silent.nodes, silent.clock, action, silent.k, None)
        np.testing.assert_array_equal(crawler.nodes["displacement"], silent.nodes["displacement"])
    for name in ("margin", "w", "muscle", "cotangent_at_epoch", "spike_time", "limit_time"):
        np.testing.assert_array_equal(crawler.nodes[name], silent.nodes[name])


def test_where_friction_balances_it_takes_steps() -> None:
    """Six nodes with equal limits both ways: three against three leave the rigid velocity free."""
    p = former(n_segments=5, friction_forward=0.05, friction_backward=0.05, dt=1e-3)
    actions = drawn(p, 100)
    exact, stepped = crawl(p, actions), crawl(replace(p, integrator="step"), actions)
    assert (np.abs(exact["slip"]) == 1).all(axis=1).any()
    np.testing.assert_allclose(exact["displacement"], stepped["displacement"], atol=2e-3)


def test_events_without_end_are_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    """With no event allowed the crawler is as it was when the decision began; only its trajectory is gone."""
    crawler, twin = Crawler(former()), Crawler(former())
    for each in (crawler, twin):
        for action in drawn(former(), 50):
            each.act(action)
    before = crawler.nodes.copy()
    monkeypatch.setattr(integrator, "MOST_EVENTS", -1)
    cross = plain(cross_decision)
    assert not cross(crawler.nodes, crawler.clock, 3, crawler.k)
    for name in STATE:
        np.testing.assert_allclose(crawler.nodes[name], before[name], atol=1e-13)
    assert crawler.clock.has_trajectory == 0.0
    monkeypatch.setattr(integration, "cross_decision", cross)
    with pytest.raises(ArithmeticError, match="gives up"):
        plain(act)(crawler.nodes, crawler.clock, 3, crawler.k, None)
    monkeypatch.undo()
    for each in (crawler, twin):
        each.act(3)
    np.testing.assert_allclose(crawler.nodes["displacement"], twin.nodes["displacement"], atol=1e-12)
