"""Looking ahead: no node that leaves its state before the end may be overlooked."""

import numpy as np
import pytest
from crawler_bench.physics.exits import exit_time, height
from crawler_bench.physics.outlook import _may_leave, look_ahead, look_at_all, look_at_run
from crawler_bench.physics.response import Response, respond

from crawler_bench.physics import CrawlerParameters
from crawler_bench.physics.coefficients import Coefficients, coefficients
from crawler_bench.physics.crawler import act
from crawler_bench.physics.state import HOLD, HOLD_R, NEVER, WORK, make_memory

BODIES = [{}, {"damping": 0.7, "tau_m": 3.0}, {"tau_f": 1.0}, {"tau_m": 0.3, "damping": 8.0}]


def leaves(parts: tuple[float, float, float], sliding: bool, seen: list[Response], k: Coefficients) -> bool:
    """Whether a node is beyond a limit at one of these times."""
    heights = [height(*parts, sliding, now) for now in seen]
    return min(heights) < (0.0 if sliding else -k.backward) or (not sliding and max(heights) > k.forward)


@pytest.mark.parametrize("sliding", [False, True])
@pytest.mark.parametrize("body", BODIES)
def test_no_node_that_leaves_is_overlooked(body: dict[str, float], sliding: bool) -> None:
    """Forces of any size and course, seen at 100 times up to the end."""
    k = coefficients(CrawlerParameters(**body))
    rng = np.random.default_rng(0)
    n_leaving, n_kept = 0, 0
    while min(n_leaving, n_kept) < 50:
        clock, duration = rng.uniform(0.0, k.longest), rng.choice([0.2, 1.0, 4.0])
        p, q_f, q_r = (float(part) for part in rng.choice([1.0, 3.0, 10.0]) * rng.normal(size=3))
        if leaves((p, q_f, q_r), sliding, [respond(clock, k.times)], k):
            continue  # it is not in this state
        times = np.linspace(clock, clock + duration, 100)
        seen = [respond(time, k.times) for time in times]
        outlook = look_ahead(times[0], seen[0], times[-1], seen[-1], k)
        is_leaving = leaves((p, q_f, q_r), sliding, seen, k)
        may_leave = _may_leave(p, q_f, q_r, sliding, outlook)
        assert may_leave or not is_leaving
        n_leaving += is_leaving
        n_kept += not may_leave


@pytest.mark.parametrize("sliding", [False, True])
@pytest.mark.parametrize("body", BODIES)
def test_no_node_that_leaves_from_a_limit_is_overlooked(body: dict[str, float], sliding: bool) -> None:
    """A node that has just changed its state stands at a limit, but for rounding."""
    k = coefficients(CrawlerParameters(**body))
    rng = np.random.default_rng(0)
    n_leaving, n_kept = 0, 0
    while min(n_leaving, n_kept) < 100:
        clock, until = np.cumsum(rng.uniform(0.0, [k.longest, 1.0]))
        now, end = respond(clock, k.times), respond(until, k.times)
        q_f, q_r = (float(part) for part in rng.choice([0.1, 1.0, 10.0]) * rng.normal(size=2))
        limit = 0.0 if sliding else rng.choice([-k.backward, k.forward])
        off = rng.choice([-1.0, -0.1, 0.0, 0.1, 1.0]) * k.tolerance
        p = (limit + off - height(0.0, q_f, q_r, sliding, now)) / (now.e_c if sliding else 1.0)
        above = [(p, q_f, q_r)] if sliding else [(k.backward + p, q_f, q_r), (k.forward - p, -q_f, -q_r)]
        leaves_at = min(
            exit_time(*each, sliding, clock, now, until, end, False, k.times, k.tolerance) for each in above
        )
        may_leave = _may_leave(p, q_f, q_r, sliding, look_ahead(clock, now, until, end, k))
        assert may_leave or leaves_at == NEVER
        n_leaving += leaves_at < NEVER
        n_kept += not may_leave


@pytest.mark.parametrize("n_segments", [2, 10, 62, 63, 64, 65, 130])
def test_all_nodes_are_listed_as_every_single_one_is(n_segments: int) -> None:
    p = CrawlerParameters(n_segments=n_segments)
    memory, k = make_memory(n_segments), coefficients(p)
    for action in np.random.default_rng(1).integers(n_segments, size=60):
        act(memory, int(action), p.steps_per_decision, k)
    now, end = respond(0.1, k.times), respond(0.9, k.times)
    outlook = look_ahead(0.1, now, 0.9, end, k)
    count = int(look_at_all(memory, outlook))
    listed, held = memory[WORK, :count].tolist(), memory[HOLD : HOLD_R + 1].copy()
    again = int(look_at_run(memory, 0, n_segments, outlook))
    assert listed == memory[WORK, :again].tolist() == sorted(set(listed))
    assert 0 < count <= n_segments + 1
    np.testing.assert_array_equal(memory[HOLD : HOLD_R + 1], held)
