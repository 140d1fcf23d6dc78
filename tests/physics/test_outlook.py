"""Looking ahead: no node that leaves its state before the end may be overlooked."""

import numpy as np
import pytest

from crawler_bench.physics import CrawlerParameters
from crawler_bench.physics.coefficients import Coefficients, coefficients
from crawler_bench.physics.crawler import act
from crawler_bench.physics.exits import height
from crawler_bench.physics.layout import WORK, make_memory
from crawler_bench.physics.outlook import _may_leave, look_ahead, look_at_all, look_at_run
from crawler_bench.physics.response import Response, respond

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


@pytest.mark.parametrize("n_segments", [2, 10, 62, 63, 64, 65, 130])
def test_all_nodes_are_listed_as_every_single_one_is(n_segments: int) -> None:
    p = CrawlerParameters(n_segments=n_segments)
    memory, k = make_memory(n_segments), coefficients(p)
    for action in np.random.default_rng(1).integers(n_segments, size=60):
        act(memory, int(action), p.steps_per_decision, k)
    now, end = respond(0.1, k.times), respond(0.9, k.times)
    outlook = look_ahead(0.1, now, 0.9, end, k)
    count = int(look_at_all(memory, outlook))
    listed = memory[WORK, :count].tolist()
    again = int(look_at_run(memory, 0, n_segments, outlook))
    assert listed == memory[WORK, :again].tolist() == sorted(set(listed))
    assert 0 < count <= n_segments + 1
