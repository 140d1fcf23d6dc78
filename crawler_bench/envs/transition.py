"""One decision of the crawler as a compiled function: act, observe, reward, end.

`CrawlerEnv.step`, the vector environment and every compiled loop over decisions go through `decide`, so they
agree to the last bit.
"""

import math
from typing import NamedTuple

import numpy as np

from crawler_bench.envs.arguments import require_at_least_zero, require_positive
from crawler_bench.envs.randomness import State, random
from crawler_bench.physics.coefficients import (
    Coefficients,
    as_floats,
    coefficients,
    may_balance,
    stepping,
)
from crawler_bench.physics.compiled import inline_kernel, inner_kernel
from crawler_bench.physics.crawler import measure, set_power
from crawler_bench.physics.exact.trajectory import write_state
from crawler_bench.physics.integration import act
from crawler_bench.physics.parameters import CrawlerParameters
from crawler_bench.physics.state import LIFETIME, Array, Memory, Nodes, dtype_of, parts

# A task as kernels take it: its numbers as one row of floats, and those of the stepped integrator, or None.
# What is None is not compiled: kernels without steps are other kernels than those with them.
Packed = tuple[Array, Array | None]

# How an episode stands after a decision: `info["end"]`.
RUNNING, DISTANCE, TIME = range(3)


class Task(NamedTuple):
    """A crawler and its task, as the kernels take them."""

    penalty: float  # what r_2 of [M20, eq. 11] costs in each decision: epsilon, or 0
    penalty_rate: float  # what it costs in each decision interval: 0, or epsilon times the interval
    noise: float  # largest error s of a sensed strain
    episode_distance: float  # L
    episode_intervals: float  # decision intervals until the time limit
    longest_hold: int  # decision intervals for which an action is held at the most
    k: Coefficients


TASK = dtype_of(Task)


class Decision(NamedTuple):
    """What comes of a decision."""

    observation: int  # [M20, eq. 9]
    reward: float  # [M20, eq. 11]
    displacement: float  # of the centroid, L
    gradient: float  # r_2 of eq. 11
    centroid: float  # L
    end: int  # RUNNING, or ended by DISTANCE or TIME


def make_task(
    parameters: CrawlerParameters,
    regularization: float = 0.0,
    noise: float = 0.0,
    episode_distance: float = math.inf,
    time_limit: float = math.inf,
) -> Packed:
    """Prepare a task for the kernels; without limits, the episode never ends.

    Returns:
        The task, the fields of `Task` in a row of floats; and the fields of `Stepping` likewise, if the
        parameters ask for steps or the exact integrator may have to give up, else None.

    Raises:
        ValueError: if a number is not possible.
    """
    require_at_least_zero("regularization", regularization)
    require_at_least_zero("noise", noise)
    require_positive("episode_distance", episode_distance)
    require_positive("time_limit", time_limit)
    per_decision = parameters.penalty == "decision"
    task = Task(
        penalty=float(regularization) if per_decision else 0.0,
        penalty_rate=0.0 if per_decision else float(regularization) * parameters.decision_interval,
        noise=float(noise),
        episode_distance=float(episode_distance),
        episode_intervals=_intervals_until(time_limit, parameters),
        longest_hold=parameters.intervals_per_decision,
        k=coefficients(parameters),
    )
    takes_steps = parameters.integrator == "step" or may_balance(parameters)
    return as_floats(task), as_floats(stepping(parameters)) if takes_steps else None


def most_decisions(parameters: CrawlerParameters, time_limit: float) -> int | None:
    """How many decisions an episode has at the most: as many as intervals fit; None without a time limit.

    Where an action may be held for several intervals (reading `decide_on`), an episode has fewer.
    """
    intervals = _intervals_until(time_limit, parameters)
    return int(intervals) if math.isfinite(intervals) else None


def _intervals_until(time_limit: float, parameters: CrawlerParameters) -> float:
    """Decision intervals until the time limit: the last may begin before it, never at it."""
    # Rounding must not add one.
    return float(np.ceil(time_limit / parameters.decision_interval * (1 - 1e-12)))


@inner_kernel
def begin(memory: Memory, task: Packed, rng: State) -> int:
    """Put the crawler back to rest, undeformed, and observe it.

    Args:
        memory: changed in place; what the odometer counts over a lifetime stays.
        task: the task.
        rng: breaks ties, draws the noise.

    Returns:
        The observation.
    """
    memory[LIFETIME:] = 0.0
    odometers, _, nodes = parts(memory)
    observation = observe(nodes, task[0].view(TASK)[0], rng)
    odometers[0].observation = observation
    return observation


@inner_kernel
def decide(memory: Memory, action: int, task: Packed, rng: State) -> Decision:
    """Hold one neuron ON for a decision interval, or until the observation changes (reading `decide_on`).

    Args:
        memory: changed in place; `report` completes it.
        action: the neuron, 0 to N - 1.
        task: the task.
        rng: breaks ties, draws the noise.
    """
    odometers, clocks, nodes = parts(memory)
    odometer, t = odometers[0], task[0].view(TASK)[0]
    before, held, end = odometer.centroid, 0, RUNNING
    while True:
        act(nodes, clocks[0], action, t.k, task[1])
        held += 1
        centroid, gradient = measure(nodes)
        odometer.episode_intervals += 1.0
        if centroid >= t.episode_distance:
            end = DISTANCE
        elif odometer.episode_intervals >= t.episode_intervals:
            end = TIME
        observation = observe(nodes, t, rng)
        if end != RUNNING or held >= t.longest_hold or observation != odometer.observation:
            break
    displacement, odometer.centroid = centroid - before, centroid
    odometer.observation = observation
    odometer.lifetime_intervals += held
    odometer.lifetime_distance += displacement
    reward = displacement - (t.penalty + t.penalty_rate * held) * gradient
    return Decision(observation, reward, displacement, gradient, centroid, end)


@inner_kernel
def decide_and_report(memory: Memory, action: int, task: Packed, rng: State) -> Decision:
    """`decide` and `report` in one call from Python."""
    made = decide(memory, action, task, rng)
    report(memory, task)
    return made


@inner_kernel
def report(memory: Memory, task: Packed) -> None:
    """Write all of the state, and the power of every node.

    The decisions to come do not depend on it, so that those who only decide need not pay for it.
    """
    _, clocks, nodes = parts(memory)
    k = task[0].view(TASK)[0].k
    write_state(nodes, clocks[0], k)
    set_power(nodes, k)


@inline_kernel
def observe(nodes: Nodes, t: Task, rng: State) -> int:
    """Index of the segment that is sensed as most contracted [M20, eq. 9], ties broken at random.

    Args:
        nodes: their strains are read.
        t: the task; each strain is sensed with an error, uniform in [-noise, noise].
        rng: draws the errors (none when noise is 0) and breaks ties.

    Returns:
        The index, 0 to N - 1.
    """
    best, index, ties = -math.inf, 0, 0
    for i in range(nodes.size - 1):
        sensed = nodes[i].strain
        if t.noise > 0.0:
            sensed += t.noise * (2.0 * random(rng) - 1.0)
        sensed *= t.k.contraction_sign
        if sensed == best:
            ties += 1
            if random(rng) * ties < 1.0:  # the i-th of equal candidates replaces the others with 1 / i
                index = i
        # Without a branch, which a processor would often guess wrong.
        is_best = sensed > best
        best, index, ties = max(sensed, best), i if is_best else index, 1 if is_best else ties
    return index
