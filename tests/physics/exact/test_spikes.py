"""Spikes between events: the clock of a neuron against its angle, and what a spike does to its muscle."""

from math import atan, cos, log, pi, sin, tan

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from crawler_bench.physics.as_printed import follow_theta
from crawler_bench.physics.coefficients import as_record, coefficients
from crawler_bench.physics.exact.spikes import due_muscle, excite, next_excitation, turn_off, turn_on
from crawler_bench.physics.exact.trajectory import force_at
from crawler_bench.physics.neuron import cotangent
from crawler_bench.physics.relaxation import respond
from crawler_bench.physics.state import make_memory, nodes_of
from crawler_bench.physics.tolerances import NEVER
from tests.bodies import former
from tests.physics.crawling import Crawler


@settings(derandomize=True, deadline=None, max_examples=100)
@given(
    theta=st.floats(-pi + 1e-3, pi - 1e-3),
    interval=st.sampled_from([0.01, 0.2, 0.7, 1.0, 3.0]),
    phase=st.sampled_from(["pi", "2pi", "every_pi"]),
)
def test_an_on_neuron_turns_and_spikes_as_its_angle_does(theta: float, interval: float, phase: str) -> None:
    assume(abs(theta) > 1e-6)
    p = former(decision_interval=interval, spike_phase=phase)
    node = nodes_of(make_memory(2))[0]
    node.cotangent_at_epoch, node.spike_time = cotangent(tan(theta / 2.0)), NEVER
    q = turn_on(node, 0.0, as_record(coefficients(p)))
    end, spikes = follow_theta(theta, True, interval, p.neuron_rate, phase)
    angle = 2.0 * atan(1.0 / q) if q != 0.0 else pi
    assert (cos(angle), sin(angle)) == pytest.approx((cos(end), sin(end)), abs=1e-7)
    if spikes and spikes[-1] < interval - 1e-6:
        assert node.spike_time == pytest.approx(spikes[0], abs=1e-6)
    elif not spikes:
        assert node.spike_time > interval - 1e-6


@pytest.mark.parametrize(("phase", "spikes"), [("pi", True), ("2pi", False), ("every_pi", True)])
def test_a_neuron_switched_off_spikes_late_at_pi_only(phase: str, spikes: bool) -> None:
    k = as_record(coefficients(former(spike_phase=phase)))
    node = nodes_of(make_memory(2))[0]
    turn_off(node, 0.5, 1.0, k)
    assert node.cotangent_at_epoch == 0.5 + 2.0
    assert node.spike_time == (1.25 if spikes else NEVER)
    turn_off(node, -0.5, 1.0, k)  # past pi
    assert node.spike_time == NEVER


@pytest.mark.parametrize("muscle", [0, 1, 33, 69])
@pytest.mark.parametrize("name", ["spike_time", "limit_time"])
def test_the_first_muscle_that_is_due_is_found(name: str, muscle: int) -> None:
    nodes = nodes_of(make_memory(70))
    nodes["spike_time"] = nodes["limit_time"] = NEVER
    nodes[name][[muscle, 70]] = 0.5
    assert next_excitation(nodes) == 0.5
    assert due_muscle(nodes, 0.5) == muscle


@pytest.mark.parametrize("is_on", [True, False])
def test_a_spike_adds_its_gain_and_leaves_the_force_as_it_is(is_on: bool) -> None:
    crawler = Crawler(former())
    crawler.act(5)
    nodes, k = crawler.nodes, crawler.k
    now = respond(0.3, k.times)
    nodes[4].drive_at_epoch, nodes[4].muscle.constant, nodes[4].spike_time = 0.5, 0.2, 0.3
    force, drive = force_at(nodes[4].muscle, now), 0.5 * now.e_m + k.spike_gain
    excite(nodes, 4, now, is_on, k)
    assert nodes[4].drive_at_epoch * now.e_m == pytest.approx(drive, rel=1e-14)
    assert force_at(nodes[4].muscle, now) == pytest.approx(force, abs=1e-14)
    assert nodes[4].limit_time == pytest.approx(0.3 + k.tau_m * log(drive), rel=1e-14)
    assert nodes[4].spike_time == (0.3 + pi / k.neuron_rate if is_on else NEVER)
    np.testing.assert_allclose(
        nodes["net"]["constant"][[3, 4]], [-1.0, 1.0]
    )  # F_max, the drive being limited
