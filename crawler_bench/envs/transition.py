"""One decision of the crawler as a compiled function: act, observe, reward, end.

`CrawlerEnv.step`, the vector environment and every compiled loop over decisions go through `decide`, so they
agree to the last bit.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from crawler_bench.envs.randomness import State, random
from crawler_bench.physics import course
from crawler_bench.physics.coefficients import Coefficients, coefficients
from crawler_bench.physics.compilation import inner_kernel, step_kernel
from crawler_bench.physics.crawler import act, measure, net_muscle_force
from crawler_bench.physics.intrinsics import constant, shape_known
from crawler_bench.physics.layout import (
    CENTROID,
    DISPLACEMENT,
    EPISODE_DECISIONS,
    EPOCH,
    FORCE,
    LIFETIME_DECISIONS,
    LIFETIME_DISTANCE,
    ODOMETER,
    PAPER_NODES,
    POWER,
    ROWS,
    STRAIN,
    VELOCITY,
    Memory,
)
from crawler_bench.physics.parameters import CrawlerParameters
from crawler_bench.physics.response import Relaxation, Response

Packed = NDArray[np.float64]  # (n,) a task as kernels take it, see `pack`

RUNNING, DISTANCE, TIME = range(3)
END_NAMES = (None, "distance", "time")

_of_paper_size = shape_known(ROWS, PAPER_NODES)


class Task(NamedTuple):
    """What is asked of which crawler, as the kernels need it."""

    steps_per_decision: int
    regularization: float  # epsilon of [M20, eq. 11]
    noise: float  # largest error s of a sensed strain
    episode_distance: float  # L
    episode_decisions: float  # decisions until the time limit
    k: Coefficients


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
        (n,) the task; `unpack` tells what is in it.

    Raises:
        ValueError: if a number is not possible.
    """
    _require_at_least_zero("regularization", regularization)
    _require_at_least_zero("noise", noise)
    _require_positive("episode_distance", episode_distance)
    _require_positive("time_limit", time_limit)
    return pack(Task(
        steps_per_decision=parameters.steps_per_decision,
        regularization=float(regularization),
        noise=float(noise),
        episode_distance=float(episode_distance),
        # The last decision may begin before the time limit, never at it; rounding must not add one.
        episode_decisions=float(np.ceil(time_limit / parameters.decision_interval * (1 - 1e-12))),
        k=coefficients(parameters),
    ))  # fmt: skip


def _require_at_least_zero(name: str, value: float) -> None:
    if not (math.isfinite(value) and value >= 0):
        raise ValueError(f"{name} = {value!r} is not possible: it must be a finite number of at least 0")


def _require_positive(name: str, value: float) -> None:
    if not value > 0:
        raise ValueError(f"{name} = {value!r} is not possible: it must be a number above 0")


def pack(task: Task) -> Packed:
    """A task as one array, (n,), which costs less to hand from kernel to kernel; `unpack` undoes it."""
    flat: list[float] = []
    for value in (*task[:-1], *task.k):
        flat.extend(value) if isinstance(value, tuple) else flat.append(value)
    return np.array(flat, dtype=np.float64)


@inner_kernel
def unpack(packed: Packed) -> Task:
    """Undo `pack`."""
    c, t = packed, constant
    return Task(
        int(t(c, 0)), t(c, 1), t(c, 2), t(c, 3), t(c, 4),
        Coefficients(
            t(c, 5) != 0.0, t(c, 6), t(c, 7), t(c, 8), t(c, 9), t(c, 10), t(c, 11), t(c, 12) != 0.0,
            t(c, 13), t(c, 14), t(c, 15), t(c, 16), t(c, 17), t(c, 18), t(c, 19) != 0.0, t(c, 20), t(c, 21),
            t(c, 22), t(c, 23), t(c, 24), t(c, 25), t(c, 26), t(c, 27),
            Relaxation(
                t(c, 28), t(c, 29), t(c, 30), t(c, 31), t(c, 32), t(c, 33), t(c, 34) != 0.0, t(c, 35),
                t(c, 36), t(c, 37),
            ),
            Response(t(c, 38), t(c, 39), t(c, 40), t(c, 41), t(c, 42), t(c, 43)),
            t(c, 44), t(c, 45), t(c, 46), t(c, 47),
        ),
    )  # fmt: skip


@step_kernel
def begin(memory: Memory, packed: Packed, rng: State) -> int:
    """Put the crawler back to rest, undeformed, and observe it.

    Args:
        memory: changed in place; the lifetime entries of the odometer stay.
        packed: the task.
        rng: breaks ties, draws the noise.

    Returns:
        The observation.
    """
    memory[: STRAIN + 1] = 0.0
    memory[ODOMETER, EPISODE_DECISIONS] = 0.0
    memory[EPOCH] = 0.0
    return observe(memory, unpack(packed), rng)


@inner_kernel
def decide(memory: Memory, action: int, packed: Packed, rng: State) -> Decision:
    """Hold one neuron ON for a decision interval.

    Args:
        memory: changed in place; `report` completes it.
        action: the neuron, 0 to N - 1.
        packed: the task.
        rng: breaks ties, draws the noise.
    """
    if memory.shape[1] == PAPER_NODES:
        return _decide(_of_paper_size(memory), action, packed, rng)
    return _decide(memory, action, packed, rng)


@inner_kernel
def _decide(memory: Memory, action: int, packed: Packed, rng: State) -> Decision:
    task = unpack(packed)
    u, odometer = memory[DISPLACEMENT], memory[ODOMETER]
    before = memory[EPOCH, CENTROID]
    act(memory, action, task.steps_per_decision, task.k)
    after, gradient = measure(u, memory[STRAIN])
    displacement, memory[EPOCH, CENTROID] = after - before, after
    odometer[EPISODE_DECISIONS] += 1.0
    odometer[LIFETIME_DECISIONS] += 1.0
    odometer[LIFETIME_DISTANCE] += displacement
    end = RUNNING
    if after >= task.episode_distance:
        end = DISTANCE
    elif odometer[EPISODE_DECISIONS] >= task.episode_decisions:
        end = TIME
    observation = observe(memory, task, rng)
    reward = displacement - task.regularization * gradient
    return Decision(observation, reward, displacement, gradient, after, end)


@step_kernel
def decide_and_report(memory: Memory, action: int, packed: Packed, rng: State) -> Decision:
    """`decide` and `report` in one call from Python."""
    made = decide(memory, action, packed, rng)
    report(memory, packed)
    return made


@step_kernel
def report(memory: Memory, packed: Packed) -> None:
    """Write all of the state, and the power of every node: net muscle force times speed [M20, eq. 13].

    The decisions to come do not depend on it, so that those who only decide need not pay for it.
    """
    k = unpack(packed).k
    course.report(memory, k)
    power, velocity = memory[POWER], memory[VELOCITY]
    net_muscle_force(memory[FORCE], power, k)
    for j in range(power.size):
        power[j] = abs(power[j] * velocity[j])


@inner_kernel
def observe(memory: Memory, task: Task, rng: State) -> int:
    """Index of the segment that is sensed as most contracted [M20, eq. 9], ties broken at random.

    Args:
        memory: its strains are read.
        task: the task; each strain is sensed with an error, uniform in [-noise, noise].
        rng: draws the errors (none when noise is 0) and breaks ties.

    Returns:
        The index, 0 to N - 1.
    """
    strain, noise, sign = memory[STRAIN], task.noise, task.k.contraction_sign
    best, index, ties = -math.inf, 0, 0
    if noise == 0.0:
        for i in range(strain.size - 1):  # without branches, of which a processor would guess many wrong
            sensed = strain[i] * sign
            ties += int(sensed == best)
            index = i if sensed > best else index
            best = max(best, sensed)
        if ties == 0:
            return index
        best, index = -math.inf, 0
    for i in range(strain.size - 1):
        sensed = strain[i]
        if noise > 0.0:
            sensed += noise * (2.0 * random(rng) - 1.0)
        sensed *= sign
        if sensed > best:
            best, index, ties = sensed, i, 1
        elif sensed == best:
            ties += 1
            if random(rng) * ties < 1.0:  # the i-th of equal candidates replaces the others with 1 / i
                index = i
    return index
