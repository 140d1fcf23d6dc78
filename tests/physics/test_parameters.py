"""The parameters: what the paper's Table S1 says, what the readings turn into, and what is refused.

A value that the model cannot be solved with has to be stopped where it is written down, by one line that
names the field, the value and what is allowed; a crawler that silently stands still would be taken for a
result.
"""

from dataclasses import FrozenInstanceError, fields, replace
from fractions import Fraction
from math import inf, nan, pi
from typing import Any

import numpy as np
import pytest

from crawler_bench.physics import CrawlerParameters
from crawler_bench.physics.parameters import CHOICES

NUMBERS = [f.name for f in fields(CrawlerParameters) if f.name not in CHOICES and f.name != "n_segments"]


def refusal(**values: Any) -> str:
    with pytest.raises(ValueError, match="is not possible: it must be") as caught:
        CrawlerParameters(**values)
    message = str(caught.value)
    assert "\n" not in message
    return message


@pytest.mark.parametrize("value", [nan, inf, -inf, -1.0, 0, 0.0, -0.0, True, False, "1", None, 1j, [1.0]])
@pytest.mark.parametrize("name", NUMBERS)
def test_a_number_has_to_be_finite_and_positive(name: str, value: Any) -> None:
    assert refusal(**{name: value}) == (
        f"{name} = {value!r} is not possible: it must be a finite number above 0"
    )


@pytest.mark.parametrize("value", [1, 0, -3, True, False, 2.5, 10.0, nan, inf, "10", None])
def test_segments_are_counted(value: Any) -> None:
    assert refusal(n_segments=value) == (
        f"n_segments = {value!r} is not possible: it must be a whole number of at least 2"
    )


@pytest.mark.parametrize("value", ["", "Table", "reaction ", None, 1, True, nan])
@pytest.mark.parametrize("name", CHOICES)
def test_a_reading_is_one_of_its_choices(name: str, value: Any) -> None:
    message = refusal(**{name: value})
    assert message.startswith(f"{name} = {value!r} ")
    assert all(repr(choice) in message for choice in CHOICES[name])


@pytest.mark.parametrize(("dt", "rate"), [(0.8, 2.0), (pi / 4.0, 2.0), (0.01, 158.0)])
def test_a_step_holds_one_spike_at_most(dt: float, rate: float) -> None:
    message = refusal(dt=dt, neuron_rate=rate, decision_interval=dt)
    assert (
        message == f"dt = {dt!r} is not possible: it must be below pi / (2 neuron_rate) = {pi / 2 / rate:.6g}"
    )
    CrawlerParameters(dt=0.99 * pi / 2.0 / rate, neuron_rate=rate, decision_interval=0.99 * pi / 2.0 / rate)


@pytest.mark.parametrize("interval", [0.015, 0.005, 0.2001, 1e-12, 1e9])
def test_a_decision_takes_whole_steps(interval: float) -> None:
    message = refusal(decision_interval=interval)
    assert message == (
        f"decision_interval = {interval!r} is not possible: it must be a whole multiple of dt = 0.01"
    )


def test_a_decision_is_never_shorter_than_a_step() -> None:
    assert refusal(dt=0.5).startswith("decision_interval = 0.19 ")


@pytest.mark.parametrize(("dt", "interval", "steps"), [(0.01, 0.2, 20), (0.1, 0.3, 3), (0.01, 0.01, 1)])
def test_steps_per_decision(dt: float, interval: float, steps: int) -> None:
    assert CrawlerParameters(dt=dt, decision_interval=interval).steps_per_decision == steps


@pytest.mark.parametrize(
    "weak",
    [
        {"n_segments": 2},
        {"friction_forward": 1.0 / 11.0},
        {"friction_forward": 0.01},
        {"muscle_force_max": 3.3},
    ],
)
def test_friction_has_to_hold_an_external_head_muscle(weak: dict[str, float]) -> None:
    message = refusal(head_muscle="external", **weak)
    limit = weak.get("muscle_force_max", 1)
    assert message == (
        f"friction_forward = {weak.get('friction_forward', 0.3)!r} is not possible: it must be "
        f"(n_segments + 1) times the forward limit above muscle_force_max = {limit:g}, "
        "or head_muscle 'reaction': without the reaction of eq. 1 only friction holds the body"
    )
    for other in ("reaction", "none"):
        CrawlerParameters(head_muscle=other, **weak)


@pytest.mark.parametrize("n_segments", [3, 10])
def test_every_node_holds_an_external_head_muscle(n_segments: int) -> None:
    """There is one node more than segments, and all hold at once."""
    least = 1.0 / (n_segments + 1)
    CrawlerParameters(n_segments=n_segments, head_muscle="external", friction_forward=1.001 * least)
    refusal(n_segments=n_segments, head_muscle="external", friction_forward=0.999 * least)


def test_the_literal_law_is_strong_enough_for_an_external_head_muscle() -> None:
    assert (
        CrawlerParameters(n_segments=2, head_muscle="external", friction_law="literal").forward_limit == 9.0
    )


def test_defaults_are_table_s1() -> None:
    p = CrawlerParameters()
    assert (p.n_segments, p.damping, p.tau_m, p.muscle_force_max, p.dt) == (10, 3.5, 1.0, 1.0, 0.01)
    assert p.friction_backward == 9.0
    assert p.anisotropy == pytest.approx(30.0, rel=1e-15)


def test_default_readings() -> None:
    p = CrawlerParameters()
    assert (p.head_muscle, p.spike_phase, p.observation, p.friction_law) == (
        "external", "every_pi", "most_contracted", "table",
    )  # fmt: skip
    assert (p.tau_f, p.neuron_rate, p.spike_gain, p.decision_interval) == (0.4, 1.59, 1.0, 0.19)


def test_the_friction_law_decides_what_nine_means() -> None:
    table, literal = CrawlerParameters(), CrawlerParameters(friction_law="literal")
    assert (table.forward_limit, table.backward_limit) == (0.3, 9.0)
    assert (literal.forward_limit, literal.backward_limit) == (9.0, pytest.approx(270.0, rel=1e-15))


def test_numbers_of_any_type_become_plain_ones() -> None:
    p = CrawlerParameters(n_segments=np.int64(4), damping=np.float32(2.0), tau_m=1, tau_f=Fraction(1, 2))
    assert [type(value) for value in (p.n_segments, p.damping, p.tau_m, p.tau_f)] == [
        int,
        float,
        float,
        float,
    ]
    assert p == CrawlerParameters(n_segments=4, damping=2.0, tau_m=1.0, tau_f=0.5)
    assert hash(p) == hash(replace(p))


def test_parameters_are_frozen_and_named() -> None:
    with pytest.raises(FrozenInstanceError):
        CrawlerParameters().dt = 0.1  # type: ignore[misc]
    with pytest.raises(TypeError):
        CrawlerParameters(10)  # type: ignore[misc]
    with pytest.raises(TypeError):
        CrawlerParameters(tau=1.0)  # type: ignore[call-arg]
