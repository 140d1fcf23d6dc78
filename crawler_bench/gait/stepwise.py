"""Roll out what is no table: a policy with a memory, or one at another keyhole than the index.

The policy is asked at every decision, as Stable-Baselines3's `evaluate_policy` asks it, with its state handed
on. Starts, noise and samples are those of `rollout`: a table that is asked step by step gives the record of
the compiled loop to the last bit.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from crawler_bench.envs.batch import CrawlerBatch, seed_words
from crawler_bench.envs.keyholes import INDEX, KeyholeBatch, look
from crawler_bench.gait.record import Array, Record
from crawler_bench.gait.rollout import begin_crawl
from crawler_bench.physics.parameters import CrawlerParameters

SAMPLED = ("displacement", "velocity", "force", "power")  # of a node, as in a `Record`


class Policy(Protocol):
    """How a policy is asked."""

    def __call__(
        self, observation: NDArray[Any], state: Any, episode_start: NDArray[np.bool_]
    ) -> tuple[NDArray[np.int64], Any]:
        """Actions for K observations, and the state for the next ones.

        Args:
            observation: (K, ...).
            state: what the last call returned; None at first.
            episode_start: (K,) which crawls have just begun.
        """


def crawl(
    parameters: CrawlerParameters,
    policy: Policy,
    keyhole: str,
    *,
    warm_up: float,
    duration: float,
    noise: Sequence[float],
    starts: Sequence[tuple[int, ...]],
) -> list[Record]:
    """Act at random for a while, then ask a policy, and record the latter, as `rollout` does.

    Args:
        parameters: the crawler.
        policy: asked for all crawls at once where every interval is a decision; crawl by crawl where an
            action may be held (reading `decide_on`).
        keyhole: what it observes.
        warm_up: tau_theta.
        duration: tau_theta.
        noise: (K,) largest error of a sensed strain, one for each crawl.
        starts: (K,) seeds of the warm-up and the noise.

    Returns:
        One record per crawl.
    """
    if parameters.intervals_per_decision > 1 and len(starts) > 1:
        return [
            record
            for level, start in zip(noise, starts, strict=True)
            for record in crawl(
                parameters, policy, keyhole, warm_up=warm_up, duration=duration, noise=[level], starts=[start]
            )
        ]
    batch = _begin(parameters, keyhole, warm_up, noise, starts)
    steps, hold = round(duration / parameters.decision_interval), parameters.intervals_per_decision
    samples = np.empty((len(starts), steps + 1, len(SAMPLED), parameters.n_segments + 1))
    actions = np.empty((len(starts), steps), dtype=np.int64)
    state, chosen, acted_on, held = None, np.zeros(len(starts), dtype=np.int64), None, 0
    begins = np.ones(len(starts), dtype=np.bool_)
    _sample(batch, samples[:, 0])
    for t in range(steps):
        # With hold > 1 there is one crawl: it is asked when its index changes, and after `hold` intervals.
        if hold == 1 or held >= hold or acted_on != batch.observation[0]:
            seen = batch.view if isinstance(batch, KeyholeBatch) else batch.observation.copy()
            chosen, state = policy(seen, state, begins)
            begins, acted_on, held = np.zeros_like(begins), batch.observation[0], 0
        actions[:, t] = chosen
        batch.decide(actions[:, t])
        held += 1
        _sample(batch, samples[:, t + 1])
    time = parameters.decision_interval * np.arange(steps + 1, dtype=np.float64)
    return [
        Record(time, pages[:, 0], pages[:, 1], pages[:, 2], pages[:, 3], acted)
        for pages, acted in zip(samples, actions, strict=True)
    ]


def _begin(
    parameters: CrawlerParameters,
    keyhole: str,
    warm_up: float,
    noise: Sequence[float],
    starts: Sequence[tuple[int, ...]],
) -> CrawlerBatch:
    """Crawlers where their warm-ups leave them, as they look there without noise."""
    interval = replace(parameters, decide_on="interval")  # a sample at each
    batch = CrawlerBatch(interval, len(starts), 0.0, list(noise), np.inf, np.inf)
    if keyhole != INDEX:
        batch = KeyholeBatch.through(keyhole, batch)
    for i, key in enumerate(starts):
        begun = begin_crawl(parameters, warm_up, key)
        batch.memory[i], batch.observation[i] = begun.memory, begun.observation
        batch.generators[i] = seed_words(begun.noise.bit_generator)
    batch.begun = True
    batch.report()
    if isinstance(batch, KeyholeBatch):
        errors = np.zeros((len(starts), parameters.n_segments))
        batch.view = look(keyhole, batch.observation, batch.nodes, errors)
    return batch


def _sample(batch: CrawlerBatch, pages: Array) -> None:
    """Write displacement, velocity, force and power of every node of every crawler."""
    batch.report()
    nodes = batch.nodes
    for row, name in enumerate(SAMPLED):
        pages[:, row] = nodes[name]
