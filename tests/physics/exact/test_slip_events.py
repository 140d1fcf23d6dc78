"""Slip events: no node that changes its state before the end may be overlooked, and each changes in time."""

import numpy as np
import pytest

from crawler_bench.physics.body import BACKWARD, FORWARD, STUCK
from crawler_bench.physics.coefficients import Coefficients, coefficients
from crawler_bench.physics.exact.crossings import Margin, margin_at
from crawler_bench.physics.exact.slip_events import (
    change_slip,
    find_slip_times,
    look_ahead,
    may_change,
    next_slip_event,
    slip_time,
)
from crawler_bench.physics.exact.trajectory import position, read_clock
from crawler_bench.physics.relaxation import Response, after, respond
from crawler_bench.physics.state import make_memory, nodes_of
from crawler_bench.physics.tolerances import NEVER
from tests.bodies import former
from tests.physics.crawling import Crawler, drawn, plain

BODIES = [{}, {"damping": 0.7, "tau_m": 3.0}, {"tau_f": 1.0}, {"tau_m": 0.3, "damping": 8.0}]


def a_node(terms: tuple[float, float, float], sliding: bool):  # type: ignore[no-untyped-def]
    node = nodes_of(make_memory(2))[0]
    node.slip = FORWARD if sliding else STUCK
    node.margin.constant, node.margin.as_e_f, node.margin.as_r_f = terms
    return node


def changes(terms: tuple[float, float, float], sliding: bool, seen: list[Response], k: Coefficients) -> bool:
    """Whether a node is beyond a limit at one of these times."""
    margins = [margin_at(Margin(*terms, sliding), now) for now in seen]
    return min(margins) < (0.0 if sliding else -k.backward) or (not sliding and max(margins) > k.forward)


@pytest.mark.parametrize("sliding", [False, True])
@pytest.mark.parametrize("body", BODIES)
def test_no_node_that_changes_is_overlooked(body: dict[str, float], sliding: bool) -> None:
    """Margins of any size and course, seen at 100 times up to the end."""
    k = coefficients(former(**body))
    rng = np.random.default_rng(0)
    n_changing, n_kept = 0, 0
    while min(n_changing, n_kept) < 50:
        clock, duration = rng.uniform(0.0, k.longest), rng.choice([0.2, 1.0, 4.0])
        p, q_f, q_r = (float(term) for term in rng.choice([1.0, 3.0, 10.0]) * rng.normal(size=3))
        if changes((p, q_f, q_r), sliding, [respond(clock, k.times)], k):
            continue  # it is not in this state
        seen = [respond(float(time), k.times) for time in np.linspace(clock, clock + duration, 100)]
        is_changing = changes((p, q_f, q_r), sliding, seen, k)
        may = may_change(a_node((p, q_f, q_r), sliding), look_ahead(seen[0], seen[-1], k), k)
        assert may or not is_changing
        n_changing += is_changing
        n_kept += not may


@pytest.mark.parametrize("sliding", [False, True])
@pytest.mark.parametrize("body", BODIES)
def test_no_node_that_changes_from_a_limit_is_overlooked(body: dict[str, float], sliding: bool) -> None:
    """A node that has just changed its state stands at a limit, but for rounding."""
    k = coefficients(former(**body))
    rng = np.random.default_rng(0)
    n_changing, n_kept = 0, 0
    while min(n_changing, n_kept) < 100:
        clock, until = (float(time) for time in np.cumsum(rng.uniform(0.0, [k.longest, 1.0])))
        now, end = respond(clock, k.times), respond(until, k.times)
        q_f, q_r = (float(term) for term in rng.choice([0.1, 1.0, 10.0]) * rng.normal(size=2))
        limit = 0.0 if sliding else rng.choice([-k.backward, k.forward])
        off = rng.choice([-1.0, -0.1, 0.0, 0.1, 1.0]) * k.tolerance
        rest = margin_at(Margin(0.0, q_f, q_r, sliding), now)
        node = a_node((float(limit + off - rest) / (now.e_c if sliding else 1.0), q_f, q_r), sliding)
        is_changing = slip_time(node, now, end, False, k) < NEVER
        may = may_change(node, look_ahead(now, end, k), k)
        assert may or not is_changing
        n_changing += is_changing
        n_kept += not may


@pytest.mark.parametrize("n_segments", [2, 10, 70])
def test_the_first_of_the_slip_times_comes_next(n_segments: int) -> None:
    crawler = Crawler(former(n_segments=n_segments))
    nodes, k = crawler.nodes, crawler.k
    seen = 0
    for action in drawn(former(n_segments=n_segments), 60, seed=1):
        crawler.act(action)
        now = plain(read_clock)(crawler.clock)
        end = after(now, respond(1.0, k.times))
        first = find_slip_times(nodes, 0, n_segments, now, end, False, k)
        assert first == next_slip_event(nodes, end)
        times = nodes["slip_time"]
        if first.node >= 0:
            assert first.time == times.min() == times[first.node]
            seen += 1
        else:
            assert first.time == end.time
            assert (times >= end.time).all()
    assert seen > 5


@pytest.mark.parametrize(("push", "expected"), [(0.4, FORWARD), (-9.1, BACKWARD)])
def test_a_stuck_node_goes_the_way_it_is_pushed(push: float, expected: float) -> None:
    crawler = Crawler(former())
    crawler.act(0)
    crawler.nodes[3].margin.constant = push
    change_slip(crawler.nodes, 3, respond(0.1, crawler.k.times), crawler.k)
    assert crawler.nodes["slip"].tolist() == [expected if i == 3 else STUCK for i in range(11)]


def test_a_sliding_node_stops_where_it_is() -> None:
    crawler = Crawler(former())
    for action in [9] * 8:
        crawler.act(action)
    moving = int(np.flatnonzero(crawler.nodes["slip"])[0])
    now = plain(read_clock)(crawler.clock)
    there = position(crawler.nodes[moving], now)
    change_slip(crawler.nodes, moving, now, crawler.k)
    assert crawler.nodes[moving].slip == STUCK
    assert crawler.nodes[moving].displacement_at_epoch == there == crawler.nodes[moving].displacement > 0.01


def test_with_the_last_stuck_node_the_slowest_that_slides_the_other_way_sticks() -> None:
    """Else nothing would resist rigid motion."""
    crawler = Crawler(former(n_segments=3))
    crawler.act(0)
    nodes, now = crawler.nodes, respond(0.0, crawler.k.times)
    nodes["slip"] = [BACKWARD, STUCK, FORWARD, BACKWARD]
    nodes["w"]["constant"] = [-3.0, 0.0, 1.0, -2.0]
    nodes[1].margin.constant = 0.4
    change_slip(nodes, 1, now, crawler.k)
    assert nodes["slip"].tolist() == [BACKWARD, FORWARD, FORWARD, STUCK]
