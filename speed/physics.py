"""The physics: one step against one linear solve, one integrator against the other, batches against one."""

from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

import crawler_bench
from crawler_bench.envs.randomness import live_state
from crawler_bench.envs.transition import make_task
from crawler_bench.physics.state import make_memory
from speed.crawlers import (
    NO_ACTIONS,
    body,
    compiled_crawl,
    crawling_batch,
    diagonal_actions,
    random_actions,
)
from speed.loops import replay, solve_tridiagonal
from speed.measure import Effort, Row, Side, compare

STEPS_PER_SOLVE = 0.5
EXACT_OVER_STEPPED = 4.0
BATCH_OVER_ONE = 4.0
BATCH = 256
STEPS = body("step").steps_per_decision  # in a decision
ONE_STEPPED = "one crawler in steps of dt"
STEP_UNIT = "steps of dt, or the time they take"


def against_solve(effort: Effort) -> list[Row]:
    """Steps of a whole crawler against general tridiagonal solves of its size."""
    return [
        compare(
            Side(f"step of a crawler, {name}", compiled_crawl(body("step"), actions), STEPS),
            _solver(), "steps, solves", effort, STEPS_PER_SOLVE,
        )
        for name, actions in _SEQUENCES
    ]  # fmt: skip


def exact_against_solve(effort: Effort) -> list[Row]:
    """The exact integrator against the same solves; the goal is the product of the two goals around it."""
    crawlers = [
        Side(f"crawler, exact, {name}", compiled_crawl(body("exact"), actions), STEPS)
        for name, actions in _SEQUENCES
    ]
    batch = Side(f"batch of {BATCH}, exact", crawling_batch(body("exact"), BATCH), float(BATCH * STEPS))
    goal = STEPS_PER_SOLVE * EXACT_OVER_STEPPED
    return [compare(ours, _solver(), f"{STEP_UNIT}, solves", effort, goal) for ours in (*crawlers, batch)]


_SEQUENCES = (("diagonal policy", NO_ACTIONS), ("random actions", random_actions()))


def _solver() -> Side:
    rng = np.random.default_rng(0)
    n = 11
    lower, upper = rng.uniform(0.5, 1.0, (2, n))
    diagonal, sides = rng.uniform(2.5, 3.0, n), rng.standard_normal((1024, n))
    return Side(
        f"general tridiagonal solve, n = {n}", lambda m: solve_tridiagonal(lower, diagonal, upper, sides, m)
    )


def exact_against_stepped(effort: Effort) -> list[Row]:
    """Both integrators on the same sequences of actions."""
    n = 500 if effort.quick else None
    sequences = {"recorded diagonal actions": diagonal_actions(), "random actions": random_actions()}
    return [
        compare(
            Side(f"decision, exact, {name}", *_replayed("exact", actions[:n])),
            Side("in steps of dt", *_replayed("step", actions[:n])),
            "decisions", effort, EXACT_OVER_STEPPED,
        )
        for name, actions in sequences.items()
    ]  # fmt: skip


def _replayed(integrator: str, actions: NDArray[np.int64]) -> tuple[Any, float]:
    parameters = body(integrator)
    memory, task = make_memory(parameters.n_segments), make_task(parameters)
    rng = np.random.default_rng(0)
    return lambda n: replay(memory, task, actions, live_state(rng), n), float(actions.size)


def batch_against_one(effort: Effort) -> list[Row]:
    """Simulated time of batches against that of a single stepped crawler."""
    units = float(BATCH * STEPS)
    one = Side(ONE_STEPPED, compiled_crawl(body("step"), NO_ACTIONS), STEPS)
    rows = []
    for integrator in ("exact", "step"):
        batch = Side(f"batch of {BATCH}, {integrator}", crawling_batch(body(integrator), BATCH), units)
        rows.append(compare(batch, one, STEP_UNIT, effort, BATCH_OVER_ONE))
        vector = Side(f"gym.make_vec of {BATCH}, {integrator}", _vector(integrator), units)
        rows.append(compare(vector, one, STEP_UNIT, effort))
    return rows


def _vector(integrator: str) -> Any:
    env = gym.make_vec(crawler_bench.ENV_ID, num_envs=BATCH, parameters=body(integrator))
    seen: list[Any] = [env.reset(seed=0)[0]]

    def work(n_calls: int) -> None:
        for _ in range(n_calls):
            seen[0] = env.step(seen[0])[0]

    return work
