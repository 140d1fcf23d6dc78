"""The time at which a margin falls below 0, against a dense sampling of the margin."""

import numpy as np
import pytest

from crawler_bench.physics.coefficients import coefficients
from crawler_bench.physics.exact.crossings import Margin, crossing_time, margin_at
from crawler_bench.physics.relaxation import START, respond
from crawler_bench.physics.tolerances import NEVER
from tests.bodies import former

BODIES = [{}, {"damping": 0.7}, {"tau_f": 1.0}, {"tau_m": 0.3, "damping": 8.0}]


@pytest.mark.parametrize("sliding", [False, True])
@pytest.mark.parametrize("body", BODIES)
def test_it_is_where_the_margin_first_falls_below_zero(body: dict[str, float], sliding: bool) -> None:
    k = coefficients(former(**body))
    rng, found, kept = np.random.default_rng(0), 0, 0
    while min(found, kept) < 60:
        m = Margin(*(float(term) for term in rng.normal(size=3)), sliding)
        end = respond(float(rng.choice([0.2, 1.0, 3.0])), k.times)
        if margin_at(m, START) < 1e-3:
            continue  # the node is not in this state
        time = crossing_time(m, START, end, False, k)
        before = np.linspace(0.0, min(time, end.time), 400)[:-1]
        margins = [margin_at(m, respond(float(t), k.times)) for t in before]
        assert min(margins) > -1e-12
        if time < NEVER:
            assert abs(margin_at(m, respond(time, k.times))) < 1e-12
            assert margin_at(m, respond(time + 1e-6, k.times)) < 0.0
            found += 1
        else:
            assert margin_at(m, end) > -1e-12
            kept += 1


@pytest.mark.parametrize("sliding", [False, True])
def test_a_node_at_its_border_leaves_at_once_unless_it_is_overlooked(sliding: bool) -> None:
    k = coefficients(former())
    m = Margin(-1.0, 1.0, -0.5, sliding)
    assert crossing_time(m, START, k.end, False, k) == 0.0
    assert crossing_time(m, START, k.end, True, k) == NEVER


def test_a_node_may_leave_a_border_on_which_it_rests() -> None:
    """At the border, going nowhere yet: no value and no slope to guess from."""
    k = coefficients(former())
    time = crossing_time(Margin(-1.0, 1.0, 1.0, False), START, k.end, False, k)
    assert 0.0 <= time < 0.01


def test_a_node_that_dips_below_its_border_and_returns_is_seen() -> None:
    """The margin is above 0 at both ends, and turns below it: -0.02 where e_f - r_f is 1 - 0.98."""
    k = coefficients(former(tau_f=0.9))
    end = respond(4.0, k.times)
    rises = Margin(0.36, 0.0, -1.0, False)  # r_f rises to about 0.39, then decays
    assert margin_at(rises, START) > 0.0
    assert margin_at(rises, end) > 0.0
    assert 0.1 < crossing_time(rises, START, end, False, k) < 1.0
