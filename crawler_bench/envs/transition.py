"""One decision of the crawler as a compiled function: act, observe, reward, end.

Both `CrawlerEnv.step` and every compiled loop over decisions go through it, so they agree to the last bit.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from crawler_bench.physics.compilation import kernel
from crawler_bench.physics.crawler import (
    DISPLACEMENT,
    Coefficients,
    advance,
    centroid,
    coefficients,
    rest_state,
    strain_gradient,
    strains,
    workspace,
)
from crawler_bench.physics.parameters import CrawlerParameters

RUNNING, DISTANCE, TIME = range(3)
END_NAMES = (None, "distance", "time")

# Entries of the odometer.
EPISODE_DECISIONS, LIFETIME_DECISIONS, LIFETIME_DISTANCE = range(3)


class Task(NamedTuple):
    """What is asked of the crawler, as the kernels need it."""

    steps_per_decision: int
    regularization: float  # epsilon of [M20, eq. 11]
    noise: float  # largest error s of a sensed strain
    episode_distance: float  # L
    episode_decisions: float  # decisions until the time limit


class Memory(NamedTuple):
    """All that changes while a crawler lives."""

    state: NDArray[np.float64]  # (6, N + 1), see physics/crawler.py
    strain: NDArray[np.float64]  # (N,) contraction positive
    odometer: NDArray[np.float64]  # (3,) decisions in this episode; decisions and distance in all episodes
    work: NDArray[np.float64]  # (4, N + 1) scratch


def make_task(
    parameters: CrawlerParameters,
    regularization: float = 0.0,
    noise: float = 0.0,
    episode_distance: float = math.inf,
    time_limit: float = math.inf,
) -> Task:
    """Prepare a task for the kernels; without limits, the episode never ends."""
    return Task(
        steps_per_decision=parameters.steps_per_decision,
        regularization=float(regularization),
        noise=float(noise),
        episode_distance=float(episode_distance),
        # The last decision may begin before the time limit, never at it; rounding must not add one.
        episode_decisions=float(np.ceil(time_limit / parameters.decision_interval * (1 - 1e-12))),
    )


def make_memory(n_segments: int) -> Memory:
    """The memory of a crawler that has not begun to live."""
    return Memory(rest_state(n_segments), np.zeros(n_segments), np.zeros(3), workspace(n_segments))


def make_coefficients(parameters: CrawlerParameters) -> Coefficients:
    """Prepare the physics for the kernels."""
    return coefficients(parameters)


@kernel
def begin(memory: Memory, task: Task, k: Coefficients, rng: np.random.Generator) -> int:
    """Put the crawler back to rest, undeformed, and observe it.

    Args:
        memory: changed in place; the lifetime entries of the odometer stay.
        task: the task.
        k: coefficients of the physics.
        rng: breaks ties, draws the noise.

    Returns:
        The observation.
    """
    memory.state[:] = 0.0
    memory.strain[:] = 0.0
    memory.odometer[EPISODE_DECISIONS] = 0.0
    return observe(memory.strain, k.contraction_sign, task.noise, rng)


@kernel
def transition(
    memory: Memory, action: int, task: Task, k: Coefficients, rng: np.random.Generator
) -> tuple[int, float, float, float, int]:
    """Hold one neuron ON for a decision interval.

    Args:
        memory: changed in place.
        action: the neuron, 0 to N - 1.
        task: the task.
        k: coefficients of the physics.
        rng: breaks ties, draws the noise.

    Returns:
        Observation [M20, eq. 9]; reward [M20, eq. 11]; its two terms, the centroid's displacement (L) and
        the strain gradient r_2; and whether the episode is RUNNING or has ended by DISTANCE or TIME.
    """
    u = memory.state[DISPLACEMENT]
    before = centroid(u)
    advance(memory.state, memory.work, action, task.steps_per_decision, k)
    after = centroid(u)
    displacement = after - before
    gradient = strain_gradient(u)
    reward = displacement - task.regularization * gradient
    strains(u, memory.strain)
    observation = observe(memory.strain, k.contraction_sign, task.noise, rng)
    memory.odometer[EPISODE_DECISIONS] += 1.0
    memory.odometer[LIFETIME_DECISIONS] += 1.0
    memory.odometer[LIFETIME_DISTANCE] += displacement
    end = RUNNING
    if after >= task.episode_distance:
        end = DISTANCE
    elif memory.odometer[EPISODE_DECISIONS] >= task.episode_decisions:
        end = TIME
    return observation, reward, displacement, gradient, end


@kernel
def observe(strain: NDArray[np.float64], sign: float, noise: float, rng: np.random.Generator) -> int:
    """Index of the segment that is sensed as most contracted [M20, eq. 9], ties broken at random.

    Args:
        strain: (N,) contraction positive.
        sign: 1 to look for the most contracted segment, -1 for the most stretched.
        noise: each strain is sensed with an error, uniform in [-noise, noise].
        rng: draws the errors (none when noise is 0) and breaks ties.

    Returns:
        The index, 0 to N - 1.
    """
    best, index, ties = -math.inf, 0, 0
    for i in range(strain.size):
        sensed = strain[i]
        if noise > 0.0:
            sensed += noise * (2.0 * rng.random() - 1.0)
        sensed *= sign
        if sensed > best:
            best, index, ties = sensed, i, 1
        elif sensed == best:
            ties += 1
            if rng.random() * ties < 1.0:  # the i-th of equal candidates replaces the others with 1 / i
                index = i
    return index
