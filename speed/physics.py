"""The physics: the exact integrator against a linear solve and against steps of dt, and what sizes cost."""

import tracemalloc
from collections.abc import Callable
from math import nan
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

import crawler_bench
from crawler_bench.envs.batch import CrawlerBatch
from crawler_bench.envs.crawler import CrawlerEnv
from crawler_bench.envs.randomness import live_state
from crawler_bench.envs.transition import make_task
from crawler_bench.physics.parameters import CrawlerParameters
from crawler_bench.physics.state import make_memory
from speed.loops import replay, solve_tridiagonal
from speed.measure import Effort, Measurement, Side, compare, seconds_per_unit

EXACT_OVER_SOLVE = 2.0
EXACT_OVER_STEPPED = 4.0
SEGMENTS = (2, 5, 10, 20, 50, 100, 200, 500, 1000)
LONG = 50  # segments from which on their number alone decides the cost
EXPONENT = 1.1
SIZES = (1, 4, 16, 64, 256, 1024, 4096)
BYTES = 16 * 1024  # of one crawler
BATCH = 256
STEPS = CrawlerParameters().steps_per_decision
STEP_UNIT = "steps of dt, or the time they take, solves"
Actions = NDArray[np.int64]


def random_actions(n_decisions: int, n_segments: int = 10) -> Actions:
    """A fixed sequence of random actions."""
    return np.random.default_rng(0).integers(n_segments, size=n_decisions)


def diagonal_actions(n_decisions: int) -> Actions:
    """What the diagonal policy, action = observation, does from rest, recorded."""
    env = gym.make(crawler_bench.ENV_ID, time_limit=1e9, episode_distance=1e9)
    actions = [int(env.reset(seed=0)[0])]
    while len(actions) < n_decisions:
        actions.append(int(env.step(actions[-1])[0]))
    return np.array(actions)


def sequences(effort: Effort) -> dict[str, Actions]:
    """The two sequences of actions that everything is measured on: few events per decision, and many."""
    return {
        "recorded diagonal actions": diagonal_actions(effort.decisions),
        "random actions": random_actions(effort.decisions),
    }


def exact_against_solve(effort: Effort) -> list[Measurement]:
    """One crawler, and a batch, against general tridiagonal solves with as many unknowns."""
    rng = np.random.default_rng(0)
    n = 11
    lower, upper = rng.uniform(0.5, 1.0, (2, n))
    diagonal, sides = rng.uniform(2.5, 3.0, n), rng.standard_normal((1024, n))
    work = np.empty((2, n))
    solver = Side(
        f"general tridiagonal solve, n = {n}",
        lambda m: solve_tridiagonal(lower, diagonal, upper, sides, work, m),
    )
    crawlers = [
        Side(f"crawler, exact, {name}", _replayed("exact", actions), float(STEPS * actions.size))
        for name, actions in sequences(effort).items()
    ]
    batch = Side(f"batch of {BATCH}, exact", _crawling_batch(BATCH), float(BATCH * STEPS))
    return [compare(ours, solver, STEP_UNIT, effort, EXACT_OVER_SOLVE) for ours in (*crawlers, batch)]


def exact_against_stepped(effort: Effort) -> list[Measurement]:
    """Both integrators on the same sequences of actions."""
    return [
        compare(
            Side(f"decision, exact, {name}", _replayed("exact", actions), float(actions.size)),
            Side("decision in steps of dt", _replayed("step", actions), float(actions.size)),
            "decisions", effort, EXACT_OVER_STEPPED,
        )
        for name, actions in sequences(effort).items()
    ]  # fmt: skip


def _replayed(integrator: str, actions: Actions, n_segments: int = 10) -> Callable[[int], Any]:
    """A function of the number of rounds; each takes all actions from rest."""
    parameters = CrawlerParameters(integrator=integrator, n_segments=n_segments)
    memory, task = make_memory(n_segments), make_task(parameters)
    rng = np.random.default_rng(0)
    return lambda n_rounds: replay(memory, task, actions, live_state(rng), n_rounds)


def _crawling_batch(size: int) -> Callable[[int], None]:
    """A function of the number of calls; in each, every crawler decides by the diagonal policy."""
    batch = CrawlerBatch(CrawlerParameters(), size)
    batch.seed(range(size))
    batch.begin()

    def work(n_calls: int) -> None:
        for _ in range(n_calls):
            if batch.decide(batch.observation):
                batch.begin(batch.ended)

    return work


def against_segments(effort: Effort) -> list[Measurement]:
    """Seconds of a decision with random actions over the number of segments, and the power it grows with."""
    sizes = np.array(SEGMENTS[2::2] if effort.quick else SEGMENTS)
    rows = []
    for integrator in ("step", "exact"):
        costs = []
        for n in sizes.tolist():
            actions = random_actions(effort.decisions, n)
            side = Side("", _replayed(integrator, actions, n), float(actions.size))
            costs.append(seconds_per_unit(side, effort))
            rows.append(Measurement("segments", integrator, costs[-1], "seconds", size=n))
        name = f"exponent of the cost against N, {integrator}"
        for which, chosen, goal in ((f"N >= {LONG}", sizes >= LONG, EXPONENT), ("all N", sizes > 0, nan)):
            power = np.polyfit(np.log(sizes[chosen]), np.log(np.array(costs)[chosen]), 1)[0]
            rows.append(Measurement("value", f"{name}, {which}", float(power), "", at_most=goal))
    return rows


def against_batch(effort: Effort) -> list[Measurement]:
    """Seconds of one crawler's decision over the number of crawlers in the batch."""
    sizes = SIZES[::2] if effort.quick else SIZES
    sides = [Side("", _crawling_batch(size), float(size)) for size in sizes]
    costs = [seconds_per_unit(side, effort) for side in sides]
    return [
        Measurement("batch", "exact", cost, "seconds", size=size)
        for size, cost in zip(sizes, costs, strict=True)
    ]


def memory(_: Effort) -> list[Measurement]:
    """Bytes that a crawler with N = 10 keeps for itself."""
    size = 1000
    batch = CrawlerBatch(CrawlerParameters(), size)
    arrays = sum(value.nbytes for value in vars(batch).values() if isinstance(value, np.ndarray))
    CrawlerEnv().reset(seed=0)  # what is loaded once belongs to no crawler
    tracemalloc.start()
    envs = [CrawlerEnv() for _ in range(100)]
    for env in envs:
        env.reset(seed=0)
    single = tracemalloc.get_traced_memory()[0] / len(envs)
    tracemalloc.stop()
    return [
        Measurement("value", "memory of a crawler in a batch", arrays / size, "bytes", at_most=BYTES),
        Measurement("value", "memory of a CrawlerEnv", single, "bytes", at_most=BYTES),
    ]
