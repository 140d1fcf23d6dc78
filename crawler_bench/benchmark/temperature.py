"""Speed of learned policies made more or less random.

A policy p becomes p^(1/T), normalised: temperature T = 0 is its deterministic version, 1 the policy as
learned, infinity random action. A policy that draws its actions can crawl although its favourite actions
alone stand still; `traps` says why.
"""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from crawler_bench.benchmark.keys import LEARNER, STOCHASTIC
from crawler_bench.benchmark.learned_policies import crawls, policies
from crawler_bench.config.schema import EvaluationConfig
from crawler_bench.gait import metrics
from crawler_bench.gait.record import Array
from crawler_bench.physics.parameters import CrawlerParameters

TEMPERATURES = (0.0, *(2.0**power for power in range(-5, 6)), np.inf)


def soften(table: Array, temperature: float) -> Array:
    """A policy made more deterministic (T < 1) or more random (T > 1): p^(1/T), normalised.

    Args:
        table: (N, N) probability of each action at each observation.
        temperature: T, 0 to infinity inclusive. T = 0 splits evenly between equally likely actions; at
            infinity all actions are equally likely, even those that the policy never takes.

    Returns:
        (N, N) probabilities; every row sums to 1.

    Raises:
        ValueError: if the temperature is negative or not a number.
    """
    if not temperature >= 0:
        raise ValueError(f"temperature = {temperature!r} is not possible: it must be at least 0")
    if temperature == 1:
        return table.copy()
    if np.isinf(temperature):
        return np.full_like(table, 1 / table.shape[1])
    relative = table / table.max(axis=1, keepdims=True)  # T near 0 must not underflow
    powers = (relative == 1).astype(np.float64) if temperature == 0 else relative ** (1 / temperature)
    return np.asarray(powers / powers.sum(axis=1, keepdims=True))


def speed_against_temperature(
    tables: pd.DataFrame,
    parameters: CrawlerParameters,
    config: EvaluationConfig,
    temperatures: Sequence[float] = TEMPERATURES,
) -> pd.DataFrame:
    """Speed of every stochastic policy against temperature.

    Args:
        tables: of `benchmark.Benchmark`; policies that are deterministic by nature have no temperature and
            are left out.
        parameters: the crawler.
        config: starts, warm-up and duration of the crawls, which are without noise. With all starts of the
            evaluation the speed at T = 1 is the evaluation's.
        temperatures: T.

    Returns:
        One row per run and temperature: agent, regularization, seed, temperature, speed (L / tau_theta, mean
        over starts), stall_share.
    """
    rows = []
    for run, table in policies(tables, STOCHASTIC):
        for temperature in temperatures:
            softened = soften(table, temperature)
            records = list(crawls(softened, run, parameters, config))
            speed = float(np.mean([metrics.speed(record) for record in records]))
            stalled = float(np.mean([metrics.stalls(record) for record in records]))
            rows.append((*run, temperature, speed, stalled))
    return pd.DataFrame(rows, columns=[*LEARNER, "temperature", "speed", "stall_share"])
