"""Where a policy stops for good, and how a stochastic one escapes.

A neuron that stays ON brings the body to rest, and dry friction holds what earlier neurons have contracted.
If the most contracted segment then is the one whose observation turned that neuron ON, nothing ever changes
again: this observation and this action are a trap. In the default body 45 of the 100 pairs are traps from
most starts, at least two at every observation. The wave, action = observation, contains none: neuron o moves
the contraction from segment o on to o - 1.

So a deterministic policy must be right at every observation to crawl at all. Of tables drawn at random, nine
crawls in ten end for good at one observation, and nine in ten of these ends are in the map of `traps`; the
others are pairs that only another history of the body leads to, or alternate between two observations. A
random table has 4.5 traps; results/benchmark counts those of the agents (stuck.csv), where their crawls end
(absorptions.csv) and how their stochastic versions leave (escapes.csv): another draw leads out of a trap, and
on a body that crawls fast at random that is a gait.
"""

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from crawler_bench.benchmark.keys import DETERMINISTIC, LEARNER, STOCHASTIC
from crawler_bench.benchmark.learned_policies import crawls, policies, run_key
from crawler_bench.config.schema import EvaluationConfig
from crawler_bench.gait import metrics
from crawler_bench.gait.record import Array
from crawler_bench.physics.parameters import CrawlerParameters

SETTLED = 0.75  # an observation that no longer changes after this share of a crawl counts as permanent
TRAP = 0.5  # least share of starts that makes a pair a trap


def traps(parameters: CrawlerParameters, config: EvaluationConfig) -> Array:
    """Which pairs of an observation and an action stop the body.

    A pair (o, a) is tried by a policy that turns neuron o + 1 ON (modulo N), which contracts segment o, and
    holds neuron a from the moment at which that is observed.

    Returns:
        (N, N) for each observation (row) and action (column) the share of starts after which the body ends at
        this observation for good.
    """
    n = parameters.n_segments
    shares = np.zeros((n, n))
    for observation, action in np.ndindex(n, n):
        chosen = np.full(n, (observation + 1) % n)
        chosen[observation] = action
        for record in crawls(np.eye(n)[chosen], ("", 0.0, 0), parameters, config):
            seen = metrics.most_contracted(record)
            shares[observation, action] += _is_settled(seen) and seen[-1] == observation
    return shares / config.starts


def stuck_observations(tables: pd.DataFrame, shares: Array) -> pd.DataFrame:
    """How many traps each deterministic policy has.

    Args:
        tables: of `benchmark.Benchmark`; only policies under the deterministic mode.
        shares: of `traps`; a pair counts as one from TRAP on.

    Returns:
        One row per run: agent, regularization, seed, stuck: the number of observations at which the policy's
        action, held, keeps the body at that very observation.
    """
    rows = []
    for run, table in policies(tables, DETERMINISTIC):
        chosen = table.argmax(axis=1)
        rows.append((*run, int((shares[np.arange(chosen.size), chosen] >= TRAP).sum())))
    return pd.DataFrame(rows, columns=[*LEARNER, "stuck"])


def absorptions(
    tables: pd.DataFrame, parameters: CrawlerParameters, config: EvaluationConfig
) -> pd.DataFrame:
    """Where each deterministic policy ends, from every start.

    Returns:
        One row per run and start: agent, regularization, seed, start, absorbed (whether the observation does
        not change in the last quarter of the crawl), stalled (whether the crawler has stopped), observation
        and action (the last ones), time (tau_theta until that observation began; NaN unless absorbed).
    """
    rows = []
    for run, table in policies(tables, DETERMINISTIC):
        chosen = table.argmax(axis=1)
        for start, record in enumerate(crawls(table, run, parameters, config)):
            seen = metrics.most_contracted(record)
            absorbed, last = _is_settled(seen), int(seen[-1])
            time = float(record.time[_arrival(seen)]) if absorbed else float("nan")
            rows.append((*run, start, absorbed, metrics.stalls(record), last, int(chosen[last]), time))
    columns = [*LEARNER, "start", "absorbed", "stalled", "observation", "action", "time"]
    return pd.DataFrame(rows, columns=columns)


def escapes(
    absorbed: pd.DataFrame, tables: pd.DataFrame, parameters: CrawlerParameters, config: EvaluationConfig
) -> pd.DataFrame:
    """What a run's stochastic policy does where its deterministic version is absorbed.

    Args:
        absorbed: of `absorptions`.
        tables: of `benchmark.Benchmark`; runs without a stochastic policy are left out.
        parameters: the crawler.
        config: how the stochastic policy crawls.

    Returns:
        One row per run and trap: agent, regularization, seed, observation, action, starts (share of starts
        that end in this trap), time (mean time until then, tau_theta), other_action (probability that a
        decision of the stochastic policy takes another action there), leaving_rate (how often it leaves this
        observation, per tau_theta spent there; NaN if it never comes there), occupancy (share of time that it
        spends there).
    """
    stochastic = dict(policies(tables, STOCHASTIC))
    rows = []
    for key, ends in absorbed.groupby(LEARNER):
        run = run_key(key)
        if run not in stochastic or not ends["absorbed"].any():
            continue
        seen = [
            metrics.most_contracted(record) for record in crawls(stochastic[run], run, parameters, config)
        ]
        for _, trapped in ends[ends["absorbed"]].groupby("observation"):
            observation, action = int(trapped["observation"].iloc[0]), int(trapped["action"].iloc[0])
            before = np.concatenate([each[:-1] for each in seen]) == observation
            after = np.concatenate([each[1:] for each in seen]) == observation
            spent = before.sum() * parameters.decision_interval
            left = (before & ~after).sum()
            rows.append((
                *run, observation, action, len(trapped) / len(ends), trapped["time"].mean(),
                1 - stochastic[run][observation, action],
                left / spent if spent else float("nan"), before.mean(),
            ))  # fmt: skip
    columns = ["observation", "action", "starts", "time", "other_action", "leaving_rate", "occupancy"]
    return pd.DataFrame(rows, columns=[*LEARNER, *columns])


def _arrival(observation: NDArray[np.int64]) -> int:
    """Sample at which the last observation began."""
    changes = np.flatnonzero(np.diff(observation))
    return int(changes[-1]) + 1 if changes.size else 0


def _is_settled(observation: NDArray[np.int64]) -> bool:
    return _arrival(observation) <= SETTLED * observation.size
