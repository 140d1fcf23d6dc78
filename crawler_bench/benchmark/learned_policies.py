"""The policies that a benchmark learned, as tables, and their crawls."""

from collections.abc import Iterator

import numpy as np
import pandas as pd

from crawler_bench.benchmark.keys import LEARNER, action_columns
from crawler_bench.config.schema import EvaluationConfig
from crawler_bench.gait.record import Array, Record
from crawler_bench.gait.rollout import rollout
from crawler_bench.physics.parameters import CrawlerParameters

RunKey = tuple[str, float, int]  # agent, regularization, seed: what LEARNER names


def policies(tables: pd.DataFrame, mode: str) -> Iterator[tuple[RunKey, Array]]:
    """The (N, N) policy of every run in a mode, by agent, regularization and seed."""
    probabilities = action_columns(tables)
    for key, rows in tables[tables["mode"] == mode].groupby(LEARNER):
        yield run_key(key), rows.sort_values("observation")[probabilities].to_numpy(np.float64)


def run_key(key: object) -> RunKey:
    """A group's key in pandas as agent, regularization and seed."""
    assert isinstance(key, tuple)
    agent, regularization, seed = key
    return str(agent), float(regularization), int(seed)


def crawls(
    table: Array, run: RunKey, parameters: CrawlerParameters, config: EvaluationConfig
) -> Iterator[Record]:
    """One crawl from every start, without noise: the starts and draws of the evaluation."""
    for start in range(config.starts):
        yield rollout(
            parameters, table, warm_up=config.warm_up, duration=config.duration, noise=0.0,
            start=(config.seed, start), policy_seed=run[2],
        )  # fmt: skip
