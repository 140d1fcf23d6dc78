"""The crawlers that are measured, and what drives them."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crawler_bench.envs.batch import CrawlerBatch
from crawler_bench.envs.randomness import live_state
from crawler_bench.envs.transition import make_task
from crawler_bench.physics.parameters import CrawlerParameters
from crawler_bench.physics.state import make_memory
from speed.loops import crawl, record_diagonal

NO_ACTIONS = np.empty(0, dtype=np.int64)
N_DECISIONS = 5000  # in a recorded sequence: 1000 tau of crawling


def body(integrator: str, n_segments: int = 10) -> CrawlerParameters:
    """The default crawler with an integrator."""
    return CrawlerParameters(integrator=integrator, n_segments=n_segments)


def random_actions(n_segments: int = 10, n_decisions: int = N_DECISIONS) -> NDArray[np.int64]:
    """A fixed sequence of random actions."""
    return np.random.default_rng(0).integers(n_segments, size=n_decisions)


def diagonal_actions(n_decisions: int = N_DECISIONS) -> NDArray[np.int64]:
    """What the diagonal policy does, recorded."""
    parameters = body("exact")
    rng = np.random.default_rng(0)
    memory = make_memory(parameters.n_segments)
    return record_diagonal(memory, make_task(parameters), live_state(rng), n_decisions)


def compiled_crawl(parameters: CrawlerParameters, actions: NDArray[np.int64]) -> Callable[[int], Any]:
    """A function of the number of decisions that lets one crawler take them in one compiled loop."""
    memory, task = make_memory(parameters.n_segments), make_task(parameters)
    rng = np.random.default_rng(0)
    return lambda n: crawl(memory, task, actions, live_state(rng), n)


def crawling_batch(parameters: CrawlerParameters, size: int) -> Callable[[int], Any]:
    """A function of the number of calls that lets a batch take a diagonal decision in each."""
    batch = CrawlerBatch(parameters, size)
    batch.seed(range(size))
    batch.begin()

    def work(n_calls: int) -> None:
        for _ in range(n_calls):
            if batch.decide(batch.observation):
                batch.begin_ended()

    return work
