"""What a crawler costs: against its number of segments, against the size of a batch, in memory, at start."""

import os
import subprocess
import sys
import time
import tracemalloc
from statistics import median
from typing import Any

import numpy as np
import pandas as pd

from crawler_bench.envs.batch import CrawlerBatch
from crawler_bench.envs.crawler import CrawlerEnv
from speed.crawlers import body, compiled_crawl, crawling_batch, random_actions
from speed.measure import MAKES_NO_SENSE, Effort, Side, median_speed

SEGMENTS = (2, 5, 10, 20, 50, 100, 200, 500, 1000)
SIZES = (1, 4, 16, 64, 256, 1024, 4096)
LARGE = 50  # segments from which on the cost is that of the segments
EXPONENT_GOAL = 1.1
MEMORY_GOAL = 16 * 1024
INTEGRATORS = ("step", "exact")


def against_segments(effort: Effort) -> pd.DataFrame:
    """Seconds that a decision takes with random actions, for each integrator and number of segments."""
    rows = [
        {"integrator": name, "segments": n, "seconds": 1.0 / median_speed(_crawler(name, n), effort)}
        for n in SEGMENTS
        for name in INTEGRATORS
    ]
    return pd.DataFrame(rows)


def _crawler(integrator: str, n_segments: int) -> Side:
    return Side("", compiled_crawl(body(integrator, n_segments), random_actions(n_segments)))


def against_batch(effort: Effort) -> pd.DataFrame:
    """Seconds that a decision of one crawler takes in a batch, for each integrator and size."""
    rows = [
        {"integrator": integrator, "size": size,
         "seconds": 1.0 / median_speed(Side("", crawling_batch(body(integrator), size), size), effort)}
        for size in SIZES
        for integrator in INTEGRATORS
    ]  # fmt: skip
    return pd.DataFrame(rows)


def exponents(costs: pd.DataFrame) -> list[dict[str, Any]]:
    """The power of N with which the cost rises, fitted over long bodies (the goal) and over all."""
    rows = []
    for integrator in INTEGRATORS:
        mine = costs[costs["integrator"] == integrator]
        for name, chosen, goal in (
            (f"N >= {LARGE}", mine[mine["segments"] >= LARGE], EXPONENT_GOAL),
            ("all N", mine, MAKES_NO_SENSE),
        ):
            power = float(np.polyfit(np.log(chosen["segments"]), np.log(chosen["seconds"]), 1)[0])
            rows.append(_value(f"exponent of the cost against N, {integrator}, {name}", power, "", goal))
    return rows


def memory() -> list[dict[str, Any]]:
    """Bytes for each crawler, N = 10."""
    size = 1000
    batch = CrawlerBatch(body("exact"), size)
    arrays = sum(value.nbytes for value in vars(batch).values() if isinstance(value, np.ndarray))
    CrawlerEnv().reset(seed=0)  # what is made once is not the crawler's
    tracemalloc.start()
    before = tracemalloc.get_traced_memory()[0]
    envs = [CrawlerEnv() for _ in range(100)]
    for env in envs:
        env.reset(seed=0)
    single = (tracemalloc.get_traced_memory()[0] - before) / len(envs)
    tracemalloc.stop()
    return [
        _value("memory of a crawler in a batch", arrays / size, "bytes", MEMORY_GOAL),
        _value("memory of a CrawlerEnv", single, "bytes", MEMORY_GOAL),
    ]


HELP = "import sys; sys.argv = ['crawler-bench', '--help']; from crawler_bench.cli import main; main()"
STEP = "import gymnasium; env = gymnasium.make('{}'); env.reset(seed=0); env.step(0)"


def start_up(effort: Effort) -> list[dict[str, Any]]:
    """What a fresh process takes; the first of each fills the caches and does not count."""
    repeats = 1 if effort.quick else effort.repeats
    help_, crawler, cartpole = (
        [_run(code) for _ in range(1 + repeats)][1:]
        for code in (HELP, STEP.format("crawler_bench:crawler_bench/Crawler-v0"), STEP.format("CartPole-v1"))
    )
    return [
        _value("crawler-bench --help", median(cpu for _, cpu in help_), "CPU seconds"),
        _value("until a process has stepped a crawler", median(wall for wall, _ in crawler), "seconds"),
        _value("the same, Gymnasium's CartPole-v1", median(wall for wall, _ in cartpole), "seconds"),
    ]


def _run(code: str) -> tuple[float, float]:
    """Seconds, and CPU seconds, of a Python process."""
    before, start = os.times(), time.perf_counter()
    subprocess.run([sys.executable, "-c", code], check=True, stdout=subprocess.DEVNULL)
    wall, after = time.perf_counter() - start, os.times()
    used = after.children_user + after.children_system - before.children_user - before.children_system
    return wall, used


def _value(what: str, value: float, unit: str, goal: float = MAKES_NO_SENSE) -> dict[str, Any]:
    return {"what": what, "value": value, "unit": unit, "goal": goal}
