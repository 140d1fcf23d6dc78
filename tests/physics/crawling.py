"""Crawlers for the tests of physics, driven kernel by kernel."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from crawler_bench.physics import CrawlerParameters
from crawler_bench.physics.coefficients import as_floats, as_record, coefficients, may_balance, stepping
from crawler_bench.physics.exact.trajectory import write_state
from crawler_bench.physics.integration import act
from crawler_bench.physics.state import make_memory, parts
from crawler_bench.physics.stepped import advance
from crawler_bench.physics.tolerances import EVENT


def plain(kernel: Any) -> Any:
    """The Python of a kernel, with the compiler on or off."""
    return getattr(kernel, "py_func", kernel)


class Crawler:
    """One crawler at rest, with its parts by name."""

    def __init__(self, p: CrawlerParameters, tolerance: float = EVENT) -> None:
        self.memory = make_memory(p.n_segments)
        _, clocks, self.nodes = plain(parts)(self.memory)
        self.clock = clocks[0]
        self.k: Any = as_record(coefficients(p, tolerance))
        self.s: Any = as_record(stepping(p))
        steps = p.integrator == "step" or may_balance(p)
        self._steps = as_floats(stepping(p)) if steps else None

    def act(self, action: int) -> None:
        """Take one decision and complete the state."""
        act(self.nodes, self.clock, int(action), self.k, self._steps)
        write_state(self.nodes, self.clock, self.k)

    def advance(self, action: int, n_steps: int) -> None:
        """Take steps of dt."""
        advance(self.nodes, int(action), n_steps, self.k, self.s)


def crawl(p: CrawlerParameters, actions: Sequence[int], tolerance: float = EVENT) -> Any:
    """Nodes at the start and after each action, by the integrator of the parameters: (actions + 1, N + 1)."""
    crawler = Crawler(p, tolerance)
    trail = [crawler.nodes.copy()]
    for action in actions:
        crawler.act(action)
        trail.append(crawler.nodes.copy())
    return np.array(trail)


def held_at_random(p: CrawlerParameters, hold: int, actions: int, seed: int) -> list[int]:
    """Actions held long enough for their neurons to spike."""
    rng = np.random.default_rng(seed)
    return [int(a) for a in np.repeat(rng.integers(p.n_segments, size=actions), hold)]


def drawn(p: CrawlerParameters, n: int, seed: int = 0) -> list[int]:
    """Actions drawn at random for each decision."""
    return [int(a) for a in np.random.default_rng(seed).integers(p.n_segments, size=n)]
