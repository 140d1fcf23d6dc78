"""Run a fixed policy and record what the body does.

A memoryless policy on N observations is a table of N x N action probabilities, whoever learned it; so one
compiled loop rolls out every agent.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from crawler_bench.envs.randomness import State, live_state, random
from crawler_bench.envs.transition import Packed, begin, decide, make_task, report
from crawler_bench.gait.record import Array, Record
from crawler_bench.physics.compiled import inline_kernel, inner_kernel
from crawler_bench.physics.parameters import CrawlerParameters
from crawler_bench.physics.state import Memory, make_memory, parts


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
    """Act at random for a while, then follow a policy, and record the latter.

    Args:
        parameters: the crawler.
        table: (N, N) action probabilities at each observation.
        warm_up: time of random action before the record, tau_theta; 0 starts from the undeformed body.
        duration: time of the policy, tau_theta.
        noise: largest error of a sensed strain.
        start: seed of the warm-up and of the noise: policies that share it meet the same start and the same
            errors.
        policy_seed: seed of the draws of a stochastic policy.

    Raises:
        ValueError: if the table has another shape.
    """
    n = parameters.n_segments
    if table.shape != (n, n):
        raise ValueError(f"a table of {n} x {n} probabilities is needed, not of the shape {table.shape}")
    begun = begin_crawl(parameters, warm_up, start)
    policy_rng = np.random.default_rng([policy_seed, *start])
    interval = replace(parameters, decide_on="interval")  # a sample at each
    steps = round(duration / parameters.decision_interval)
    samples, actions = _pages(steps, n)
    task = make_task(interval, noise=noise)
    cumulative = np.cumsum(table, axis=1)
    _crawl(
        begun.memory, begun.observation, cumulative, task, parameters.intervals_per_decision,
        live_state(begun.noise), live_state(policy_rng), samples, actions,
    )  # fmt: skip
    time = parameters.decision_interval * np.arange(steps + 1, dtype=np.float64)
    return Record(time, samples[:, 0], samples[:, 1], samples[:, 2], samples[:, 3], actions)


@dataclass(frozen=True)
class Start:
    """Where a crawl starts.

    Attributes:
        memory: of the crawler, as the warm-up left it.
        observation: index of its most contracted segment.
        noise: the generator of the noise from here on.
    """

    memory: Memory
    observation: int
    noise: np.random.Generator


def begin_crawl(parameters: CrawlerParameters, warm_up: float, start: tuple[int, ...]) -> Start:
    """Act at random for a while; whoever crawls on from the same start meets the same noise."""
    start_rng, noise_rng = map(np.random.default_rng, np.random.SeedSequence(start).spawn(2))
    n, quiet = parameters.n_segments, make_task(replace(parameters, decide_on="interval"))
    memory, rng = make_memory(n), live_state(start_rng)
    uniform = np.cumsum(np.full((n, n), 1.0 / n), axis=1)
    settle = round(warm_up / parameters.decision_interval)
    first = begin(memory, quiet, rng)
    hold = parameters.intervals_per_decision
    observation = _crawl(memory, first, uniform, quiet, hold, rng, rng, *_pages(settle, n))
    return Start(memory, observation, noise_rng)


def _pages(steps: int, n: int) -> tuple[Array, NDArray[np.int64]]:
    return np.empty((steps + 1, 4, n + 1)), np.empty(steps, dtype=np.int64)


@inner_kernel
def _crawl(
    memory: Memory,
    observation: int,
    cumulative: Array,
    task: Packed,
    hold: int,
    noise_rng: State,
    policy_rng: State,
    samples: Array,
    actions: NDArray[np.int64],
) -> int:
    """Follow a table of cumulative action probabilities; fill `samples` and `actions`.

    An action is drawn when the observation changes, and after `hold` intervals.
    """
    _sample(memory, task, samples[0])
    action, acted_on, held = 0, -1, 0
    for t in range(actions.size):
        if observation != acted_on or held >= hold:
            action = draw(cumulative[observation], policy_rng)
            acted_on, held = observation, 0
        observation = decide(memory, action, task, noise_rng).observation
        held += 1
        actions[t] = action
        _sample(memory, task, samples[t + 1])
    return observation


@inline_kernel
def draw(cumulative: Array, rng: State) -> int:
    """Draw an action from (N,) cumulative probabilities; whatever they are, it is one of 0 to N - 1."""
    drawn, action = random(rng) * cumulative[-1], 0
    while action < cumulative.size - 1 and cumulative[action] <= drawn:
        action += 1
    return action


@inner_kernel
def _sample(memory: Memory, task: Packed, page: Array) -> None:
    """Write displacement, velocity, force and power of every node."""
    report(memory, task)
    nodes = parts(memory)[2]
    for i in range(nodes.size):
        node = nodes[i]
        page[0, i], page[1, i], page[2, i], page[3, i] = (
            node.displacement, node.velocity, node.force, node.power,
        )  # fmt: skip
