"""What a fresh process takes before it has done something: CPU seconds of the whole process."""

import os
import subprocess
import sys
import tempfile
from math import nan
from pathlib import Path
from statistics import median

from speed.measure import Effort, Measurement

FIRST_STEP = 20.0
MAKE_VEC_AFTER_IT = 5.0
SECOND_STEP = 1.2
STEP = "import gymnasium; env = gymnasium.make('{}'); env.reset(seed=0); env.step(0)"
STEP_TWO = "import gymnasium; env = gymnasium.make_vec('{}', num_envs=2); env.reset(seed=0); env.step([0, 1])"
CRAWLER = "crawler_bench:crawler_bench/Crawler-v0"
CARTPOLE = "CartPole-v1"
UNIT = "CPU seconds"
WARM = (
    ("crawler-bench --help", ("-m", "crawler_bench.cli", "--help"), nan),
    ("crawler-bench list", ("-m", "crawler_bench.cli", "list"), nan),
    ("a second process until it has stepped a crawler", ("-c", STEP.format(CRAWLER)), SECOND_STEP),
    ("the same, Gymnasium's CartPole-v1", ("-c", STEP.format(CARTPOLE)), nan),
)  # fmt: skip


def warm(effort: Effort) -> list[Measurement]:
    """Commands and first steps when everything is compiled."""
    rows = []
    for what, words, goal in WARM:
        taken = median(cpu_seconds(*words) for _ in range(1 if effort.quick else effort.repeats))
        rows.append(Measurement("value", what, taken, UNIT, at_most=goal))
    return rows


def cold(effort: Effort) -> list[Measurement]:
    """The first step that compiles the physics, and what a first vector environment compiles after it.

    Left out of a quick measurement: it takes the better part of a minute.
    """
    if effort.quick:
        return []
    first, more = [], []
    for _ in range(3):
        with tempfile.TemporaryDirectory() as cache:
            first.append(cpu_seconds("-c", STEP.format(CRAWLER), cache=Path(cache)))
            compiling, compiled = (
                cpu_seconds("-c", STEP_TWO.format(CRAWLER), cache=Path(cache)) for _ in range(2)
            )
            more.append(compiling - compiled)
    return [
        Measurement(
            "value", "a first process until it has stepped a crawler", median(first), UNIT, at_most=FIRST_STEP
        ),
        Measurement(
            "value",
            "compiling for a first gym.make_vec after it",
            median(more),
            UNIT,
            at_most=MAKE_VEC_AFTER_IT,
        ),
    ]


def cpu_seconds(*words: str, cache: Path | None = None) -> float:
    """CPU seconds of a Python process.

    Args:
        words: its arguments.
        cache: folder of its compiled code; None for the usual one.
    """
    environment = os.environ | ({"CRAWLER_BENCH_CACHE": str(cache)} if cache else {})
    before = os.times()
    subprocess.run([sys.executable, *words], check=True, stdout=subprocess.DEVNULL, env=environment)
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system
