"""Let a fixed policy crawl, and record what the body does.

A policy without memory, on N observations, is a table of N x N action probabilities whoever learned it; so
every agent is rolled out by one compiled loop.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from crawler_bench.bench.record import Record
from crawler_bench.envs.transition import (
    Memory,
    Task,
    begin,
    make_memory,
    make_task,
    transition,
)
from crawler_bench.physics.coefficients import Coefficients, coefficients
from crawler_bench.physics.compilation import kernel
from crawler_bench.physics.crawler import net_muscle_force
from crawler_bench.physics.layout import DISPLACEMENT, FORCE, VELOCITY
from crawler_bench.physics.parameters import CrawlerParameters

Array = NDArray[np.float64]


def action_table(agent: Any, n_segments: int) -> Array:
    """The whole policy of an agent: (N, N) probabilities of each action at each observation.

    Args:
        agent: anything with `predict`; a stochastic one tells its `action_probabilities` as well.
        n_segments: N.
    """
    stochastic = getattr(agent, "action_probabilities", None)
    if stochastic is not None:
        return np.array(stochastic, dtype=np.float64)
    actions, _ = agent.predict(np.arange(n_segments), deterministic=True)
    return np.eye(n_segments)[np.asarray(actions, dtype=np.int64)]


def rollout(
    parameters: CrawlerParameters,
    table: Array,
    *,
    warm_up: float,
    duration: float,
    noise: float,
    start: tuple[int, ...],
    policy_seed: int = 0,
) -> Record:
    """Crawl with random action for a while, then with a policy, and record the latter.

    Args:
        parameters: the crawler.
        table: (N, N) action probabilities at each observation.
        warm_up: time of random action before the record, tau_theta; 0 starts from the undeformed body.
        duration: time of the policy, tau_theta.
        noise: largest error of a sensed strain.
        start: seed of the warm-up and of the noise; the same for every policy that is compared, so that all
            meet the same starts and the same errors.
        policy_seed: seed of the draws of a stochastic policy.
    """
    seeds = np.random.SeedSequence(start)
    start_rng, noise_rng = (np.random.default_rng(seed) for seed in seeds.spawn(2))
    policy_rng = np.random.default_rng([policy_seed, *start])
    n = parameters.n_segments
    memory, k = make_memory(n), coefficients(parameters)
    begin(memory, make_task(parameters), k, start_rng)
    uniform = np.cumsum(np.full((n, n), 1.0 / n), axis=1)
    settle = round(warm_up / parameters.decision_interval)
    observation = _crawl(
        memory, 0, uniform, make_task(parameters), k, start_rng, start_rng, *_pages(settle, n)
    )
    steps = round(duration / parameters.decision_interval)
    samples, actions = _pages(steps, n)
    task = make_task(parameters, noise=noise)
    _crawl(memory, observation, np.cumsum(table, axis=1), task, k, noise_rng, policy_rng, samples, actions)
    time = parameters.decision_interval * np.arange(steps + 1, dtype=np.float64)
    return Record(time, samples[:, 0], samples[:, 1], samples[:, 2], samples[:, 3], actions)


def _pages(steps: int, n: int) -> tuple[Array, NDArray[np.int64]]:
    return np.empty((steps + 1, 4, n + 1)), np.empty(steps, dtype=np.int64)


@kernel
def _crawl(
    memory: Memory,
    observation: int,
    cumulative: Array,
    task: Task,
    k: Coefficients,
    noise_rng: np.random.Generator,
    policy_rng: np.random.Generator,
    samples: Array,
    actions: NDArray[np.int64],
) -> int:
    """Follow a table of cumulative action probabilities; fill `samples` and `actions`."""
    _sample(memory, samples[0], k)
    for t in range(actions.size):
        row = cumulative[observation]
        drawn, action = policy_rng.random() * row[-1], 0
        while row[action] <= drawn:
            action += 1
        observation, _, _, _, _ = transition(memory, action, task, k, noise_rng)
        actions[t] = action
        _sample(memory, samples[t + 1], k)
    return observation


@kernel
def _sample(memory: Memory, page: Array, k: Coefficients) -> None:
    """Write displacement, velocity, force and power of every node."""
    page[0] = memory.state[DISPLACEMENT]
    page[1] = memory.state[VELOCITY]
    page[2] = memory.state[FORCE]
    net_muscle_force(page[2], page[3], k)
    for j in range(page.shape[1]):
        page[3, j] = abs(page[3, j] * page[1, j])
