"""The exact integrator: what the stepped one converges to, whatever the parameters."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from crawler_bench.physics.course import report
from crawler_bench.physics.excitation import due, next_excitation
from crawler_bench.physics.exits import exit_time
from crawler_bench.physics.response import START, after, relaxation, respond, respond_near
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from crawler_bench.physics import CrawlerParameters, exact
from crawler_bench.physics.as_printed import force_on_nodes, simulate
from crawler_bench.physics.coefficients import EVENT_TOLERANCE, coefficients
from crawler_bench.physics.crawler import act
from crawler_bench.physics.state import (
    DISPLACEMENT,
    DRIVE,
    FORCE,
    LIMIT_AT,
    NEURON,
    NEVER,
    SLIP,
    SPIKE_AT,
    STATE_ROWS,
    VELOCITY,
    WORK,
    make_memory,
)

Array = NDArray[np.float64]
READINGS: list[dict[str, Any]] = [
    {},
    {"head_muscle": "external"},
    {"head_muscle": "none", "spike_phase": "2pi"},
    {"friction_forward": 0.05, "friction_backward": 0.08},
    {"friction_forward": 0.05, "friction_backward": 0.05},
    {"tau_f": 1.0},
    {"tau_f": 1.0, "damping": 1.0},
    {"damping": 0.7},
    {"n_segments": 2},
    {"n_segments": 31, "neuron_rate": 4.0, "spike_gain": 0.7},
]


def crawl(p: CrawlerParameters, actions: Sequence[int], tolerance: float = EVENT_TOLERANCE) -> Array:
    """State at the start and after each action: (actions + 1, 6, N + 1)."""
    memory, k = make_memory(p.n_segments), coefficients(p, tolerance)
    trail = [memory[:STATE_ROWS].copy()]
    for action in actions:
        act(memory, int(action), p.steps_per_decision, k)
        report(memory, k)
        trail.append(memory[:STATE_ROWS].copy())
    return np.array(trail)


def drawn(p: CrawlerParameters, n: int, seed: int = 0) -> list[int]:
    return [int(a) for a in np.random.default_rng(seed).integers(p.n_segments, size=n)]


@pytest.mark.parametrize("reading", READINGS, ids=str)
def test_the_steps_converge_to_it_at_first_order(reading: dict[str, Any]) -> None:
    p = CrawlerParameters(**reading)
    actions = drawn(p, 80)
    exact = crawl(p, actions)[:, DISPLACEMENT]
    stepped = [replace(p, integrator="step", dt=dt) for dt in (0.01, 0.005, 0.0025)]
    errors = np.array([np.abs(crawl(each, actions)[:, DISPLACEMENT] - exact).max() for each in stepped])
    assert np.abs(exact[-1]).max() > 0.05
    assert errors[0] < 0.01
    np.testing.assert_allclose(errors[:-1] / errors[1:], 2.0, atol=0.15)


@pytest.mark.parametrize("reading", READINGS, ids=str)
def test_neurons_and_muscles_agree_with_the_steps_to_rounding(reading: dict[str, Any]) -> None:
    """Both integrators have them in closed form."""
    p = CrawlerParameters(**reading)
    actions = drawn(p, 80)
    exact, stepped = crawl(p, actions), crawl(replace(p, integrator="step"), actions)
    for row in (DRIVE, FORCE):
        np.testing.assert_allclose(exact[:, row], stepped[:, row], atol=1e-11)
    angles = [2.0 * np.arctan(trail[:, NEURON]) for trail in (exact, stepped)]
    np.testing.assert_allclose(np.cos(angles[0]), np.cos(angles[1]), atol=1e-10)


@pytest.mark.parametrize("reading", READINGS, ids=str)
def test_it_does_not_matter_where_decisions_are_cut(reading: dict[str, Any]) -> None:
    """Twenty decisions of 0.01 with the same neuron ON are one decision of 0.2."""
    p = CrawlerParameters(**reading)
    actions = drawn(p, 100)
    whole = crawl(p, actions)
    cut = crawl(replace(p, decision_interval=0.01), np.repeat(actions, 20).tolist())[::20]
    np.testing.assert_allclose(cut[:, [DISPLACEMENT, FORCE]], whole[:, [DISPLACEMENT, FORCE]], atol=1e-11)


@pytest.mark.parametrize("held", [5, 50])
def test_long_decisions_hold_many_spikes(held: int) -> None:
    p = CrawlerParameters()
    actions = drawn(p, 6)
    long = crawl(replace(p, decision_interval=0.2 * held), actions)
    short = crawl(p, np.repeat(actions, held).tolist())[::held]
    np.testing.assert_allclose(long[:, DISPLACEMENT], short[:, DISPLACEMENT], atol=1e-11)
    np.testing.assert_allclose(long[:, FORCE], short[:, FORCE], atol=1e-11)


@pytest.mark.parametrize("reading", READINGS, ids=str)
def test_halved_tolerances_change_nothing_that_matters(reading: dict[str, Any]) -> None:
    p = CrawlerParameters(**reading)
    actions = drawn(p, 500)  # 100 tau
    one, other = (crawl(p, actions, tolerance)[-1, DISPLACEMENT] for tolerance in (1e-13, 5e-14))
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
    p = CrawlerParameters(
        n_segments=n, damping=damping, tau_m=taus[0], tau_f=taus[1], friction_forward=limits[0],
        friction_backward=limits[1], neuron_rate=neuron[0], spike_gain=neuron[1],
    )  # fmt: skip
    for state in crawl(p, drawn(p, 150, seed))[1:]:
        u, v, slip, f = state[DISPLACEMENT], state[VELOCITY], state[SLIP], state[FORCE]
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
    p = CrawlerParameters(**reading, decision_interval=0.8)
    actions = drawn(p, 6, 3)
    expected = simulate(p, actions)
    ours = crawl(p, actions)
    np.testing.assert_allclose(ours[-1, DISPLACEMENT], expected.displacements[-1], atol=1e-5)
    assert np.abs(expected.displacements[-1]).max() > 0.05


def test_equal_time_constants_are_the_limit_of_near_ones() -> None:
    for base in ({"tau_f": 1.0}, {"tau_f": 1.0, "damping": 1.0}, {"damping": 0.7}, {"damping": 1.0}):
        p = CrawlerParameters(**base)
        near = replace(p, tau_m=p.tau_m * (1 + 1e-7), damping=p.damping * (1 - 1e-7))
        actions = drawn(p, 100)
        np.testing.assert_allclose(
            crawl(near, actions)[:, DISPLACEMENT], crawl(p, actions)[:, DISPLACEMENT], atol=1e-5
        )


@settings(max_examples=60, deadline=None, derandomize=True, phases=[Phase.generate])
@given(
    time=st.floats(0.0, 30.0),
    taus=st.tuples(*[st.sampled_from([0.05, 0.7, 0.7003, 0.701, 1.0, 1.0 + 1e-9, 1.01, 3.5])] * 3),
)
def test_responses_solve_their_equations(time: float, taus: tuple[float, float, float]) -> None:
    """Against the exponential of the cascade's matrix."""
    from scipy.linalg import expm

    tau_m, tau_f, c = taus
    cascade = np.array([[-1 / tau_m, 0, 0], [1 / tau_f, -1 / tau_f, 0], [0, 1 / c, -1 / c]])
    solution = expm(cascade * time)
    now = respond(time, relaxation(tau_m, tau_f, c))
    expected = solution[[0, 1, 1, 2, 2, 2], [0, 1, 0, 2, 1, 0]]
    np.testing.assert_allclose(now, expected, atol=2e-13)


@settings(max_examples=60, deadline=None, derandomize=True, phases=[Phase.generate])
@given(
    times=st.tuples(st.floats(0.0, 5.0), st.floats(-1e-3, 1e-3)),
    taus=st.tuples(*[st.sampled_from([0.6, 0.7, 0.701, 1.0, 1.0 + 1e-9, 3.5])] * 3),
)
def test_responses_are_carried_on_from_one_time_to_another(
    times: tuple[float, float], taus: tuple[float, float, float]
) -> None:
    """From any time to a later one, and without exponentials to one nearby, before or after."""
    (time, step), constants = times, relaxation(*taus)
    known = respond(time, constants)
    np.testing.assert_allclose(
        after(known, respond(0.3, constants)), respond(time + 0.3, constants), atol=2e-13
    )
    near = respond_near(known, time, time + step, constants)
    np.testing.assert_allclose(near, respond(time + step, constants), atol=2e-13)


@pytest.mark.parametrize("reading", READINGS, ids=str)
def test_the_course_is_that_of_the_state(reading: dict[str, Any]) -> None:
    """A crawler known by its state alone continues like one that has kept its trajectory."""
    p = CrawlerParameters(**reading)
    memory, k = make_memory(p.n_segments), coefficients(p)
    for action in drawn(p, 60):
        forgetful = make_memory(p.n_segments)
        forgetful[:STATE_ROWS] = memory[:STATE_ROWS]
        for each in (memory, forgetful):
            act(each, action, p.steps_per_decision, k)
            report(each, k)
        for row in (DISPLACEMENT, DRIVE, FORCE):
            np.testing.assert_allclose(forgetful[row], memory[row], atol=1e-12)


def test_reporting_changes_nothing_to_come() -> None:
    p = CrawlerParameters()
    memory, twin, k = make_memory(p.n_segments), make_memory(p.n_segments), coefficients(p)
    for action in drawn(p, 100):
        act(memory, action, p.steps_per_decision, k)
        act(twin, action, p.steps_per_decision, k)
        report(twin, k)
        np.testing.assert_array_equal(memory[DISPLACEMENT], twin[DISPLACEMENT])
    report(memory, k)
    np.testing.assert_array_equal(memory[:WORK], twin[:WORK])


def test_a_node_may_leave_a_border_on_which_it_rests() -> None:
    """At the border, going nowhere yet: no value and no slope to guess from."""
    k = coefficients(CrawlerParameters())
    time = exit_time.py_func(  # type: ignore[attr-defined]
        -1.0, 1.0, 1.0, False, 0.0, START, k.decision, k.end, False, k.times, k.tolerance
    )
    assert 0.0 <= time < 0.01


def test_where_friction_balances_it_takes_steps() -> None:
    """Six nodes with equal limits both ways: three against three leave the rigid velocity free."""
    p = CrawlerParameters(n_segments=5, friction_forward=0.05, friction_backward=0.05, dt=1e-3)
    actions = drawn(p, 100)
    exact, stepped = crawl(p, actions), crawl(replace(p, integrator="step"), actions)
    assert (np.abs(exact[:, SLIP]) == 1).all(axis=1).any()
    np.testing.assert_allclose(exact[:, DISPLACEMENT], stepped[:, DISPLACEMENT], atol=2e-3)


@pytest.mark.parametrize("muscle", [0, 1, 63, 64, 69])
@pytest.mark.parametrize("row", [SPIKE_AT, LIMIT_AT])
def test_the_first_muscle_that_is_due_is_found(row: int, muscle: int) -> None:
    memory = make_memory(70)
    memory[[SPIKE_AT, LIMIT_AT]] = NEVER
    memory[row, [muscle, 70]] = 0.5
    assert next_excitation(memory) == 0.5
    assert due(memory, 0.5) == muscle


def test_events_without_end_are_given_up_for_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    """With no event allowed, a decision is stepped instead, from the state that it began with."""
    p = CrawlerParameters()
    memory, k = make_memory(p.n_segments), coefficients(p)
    for action in drawn(p, 50):
        act(memory, action, p.steps_per_decision, k)
    report(memory, k)
    twin, before = memory.copy(), memory[:STATE_ROWS].copy()
    monkeypatch.setattr(exact, "MOST_EVENTS", -1)
    assert not exact.cross_decision.py_func(memory, 3, k)  # type: ignore[attr-defined]
    np.testing.assert_allclose(memory[:STATE_ROWS], before, atol=1e-13)
    monkeypatch.undo()
    assert exact.cross_decision(twin, 3, k)
