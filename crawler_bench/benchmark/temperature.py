"""Why a policy that draws its actions may crawl while its favourite actions alone stand still.

Every learned policy is made surer or less sure than it was learned, p^(1/T) normalised: temperature T = 0 is
its deterministic version, 1 the policy itself, infinity random action; and is let crawl at each T. What stops
it at T = 0 is then looked up in the body.

A neuron that stays ON brings the body to rest, and dry friction holds what earlier neurons have contracted.
If the segment that is most contracted then is the one whose observation turned that neuron ON, nothing will
ever change again: observation and action are a trap. In the default body 45 of the 100 pairs are traps from
most starts, at least two at every observation. The wave, action = observation, holds none: neuron o moves the
contraction from segment o on to o - 1.

So a table with one action for each observation has to be learned right to crawl at all. Of tables drawn at
random, nine crawls in ten end for good at one observation, and nine in ten of these ends are in the map of
`traps`; the others are pairs that only another history of the body leads to, or go back and forth between two
observations. A random table has 4.5 traps; how many those of the agents have, and where their crawls end,
stands in results/benchmark (stuck.csv, absorptions.csv, escapes.csv). A policy that draws its actions needs
none of this: another draw leads it out of a trap, and on a body that crawls fast at random that is a gait.
"""

from collections.abc import Iterator, Sequence

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from crawler_bench.benchmark.keys import LEARNER, MODES, action_columns
from crawler_bench.config.schema import EvaluationConfig
from crawler_bench.gait import metrics
from crawler_bench.gait.record import Record
from crawler_bench.gait.rollout import rollout
from crawler_bench.physics.parameters import CrawlerParameters

Array = NDArray[np.float64]

TEMPERATURES = (0.0, *(2.0**power for power in range(-5, 6)), np.inf)
SETTLED = 0.75  # share of a crawl after which an observation that no longer changes is said to be for good
TRAP = 0.5  # share of starts from which on a pair is called a trap
_DETERMINISTIC, _STOCHASTIC = MODES


def soften(table: Array, temperature: float) -> Array:
    """A policy made surer (T < 1) or less sure (T > 1): p^(1/T), normalised.

    Args:
        table: (N, N) probability of each action at each observation.
        temperature: T, 0 to infinity, both included. T = 0 shares between actions that are equally likely;
            at infinity all actions are, even those that the policy never takes.

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
    relative = table / table.max(
        axis=1, keepdims=True
    )  # of the likeliest action: T near 0 must not underflow
    powers = (relative == 1).astype(np.float64) if temperature == 0 else relative ** (1 / temperature)
    return np.asarray(powers / powers.sum(axis=1, keepdims=True))


def speed_against_temperature(
    tables: pd.DataFrame,
    parameters: CrawlerParameters,
    config: EvaluationConfig,
    temperatures: Sequence[float] = TEMPERATURES,
) -> pd.DataFrame:
    """Speed of every learned policy that draws its actions, made surer and less sure.

    Args:
        tables: of `benchmark.Benchmark`; policies that are deterministic by nature have
            no temperature and are left out.
        parameters: the crawler.
        config: starts, warm-up and duration of the crawls, which are without noise. With all
            starts of the evaluation the speed at T = 1 is the evaluation's.
        temperatures: T.

    Returns:
        A row a run and temperature: agent, regularization, seed, temperature, speed (L / tau_theta, mean over
        starts), stall_share.
    """
    rows = []
    for run, table in policies(tables, _STOCHASTIC):
        for temperature in temperatures:
            softened = soften(table, temperature)
            records = list(_crawls(softened, run, parameters, config))
            speed = float(np.mean([metrics.speed(record) for record in records]))
            stalled = float(np.mean([metrics.stalls(record) for record in records]))
            rows.append((*run, temperature, speed, stalled))
    return pd.DataFrame(rows, columns=[*LEARNER, "temperature", "speed", "stall_share"])


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
        for record in _crawls(np.eye(n)[chosen], ("", 0.0, 0), parameters, config):
            seen = metrics.most_contracted(record)
            shares[observation, action] += _is_settled(seen) and seen[-1] == observation
    return shares / config.starts


def stuck_observations(tables: pd.DataFrame, shares: Array) -> pd.DataFrame:
    """How many traps each deterministic policy has.

    Args:
        tables: of `benchmark.Benchmark`; only policies under the deterministic mode.
        shares: of `traps`; a pair counts as one from TRAP on.

    Returns:
        A row a run: agent, regularization, seed, stuck: the number of observations at which the policy's
        action, held, keeps the body at that very observation.
    """
    rows = []
    for run, table in policies(tables, _DETERMINISTIC):
        chosen = table.argmax(axis=1)
        rows.append((*run, int((shares[np.arange(chosen.size), chosen] >= TRAP).sum())))
    return pd.DataFrame(rows, columns=[*LEARNER, "stuck"])


def absorptions(
    tables: pd.DataFrame, parameters: CrawlerParameters, config: EvaluationConfig
) -> pd.DataFrame:
    """Where each deterministic policy ends, from every start.

    Returns:
        A row a run and start: agent, regularization, seed, start, absorbed (whether the observation does not
        change in the last quarter of the crawl), stalled (whether the crawler has stopped), observation and
        action (the last ones), time (tau_theta until that observation began; NaN unless absorbed).
    """
    rows = []
    for run, table in policies(tables, _DETERMINISTIC):
        chosen = table.argmax(axis=1)
        for start, record in enumerate(_crawls(table, run, parameters, config)):
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
        A row a run and trap: agent, regularization, seed, observation, action, starts (share of starts that
        end in this trap), time (mean time until then, tau_theta), other_action (probability that a decision
        of the stochastic policy takes another action there), leaving_rate (how often it leaves this
        observation, per tau_theta spent there; NaN if it never comes there), occupancy (share of time that it
        spends there).
    """
    stochastic = dict(policies(tables, _STOCHASTIC))
    rows = []
    for key, ends in absorbed.groupby(LEARNER):
        run = _run(key)
        if run not in stochastic or not ends["absorbed"].any():
            continue
        seen = [
            metrics.most_contracted(record) for record in _crawls(stochastic[run], run, parameters, config)
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


def policies(tables: pd.DataFrame, mode: str) -> Iterator[tuple[tuple[str, float, int], Array]]:
    """The (N, N) policy of every run in a mode, by agent, regularization and seed."""
    probabilities = action_columns(tables)
    for key, rows in tables[tables["mode"] == mode].groupby(LEARNER):
        yield _run(key), rows.sort_values("observation")[probabilities].to_numpy(np.float64)


def _run(key: object) -> tuple[str, float, int]:
    assert isinstance(key, tuple)
    agent, regularization, seed = key
    return str(agent), float(regularization), int(seed)


def _crawls(
    table: Array, run: tuple[str, float, int], parameters: CrawlerParameters, config: EvaluationConfig
) -> Iterator[Record]:
    """One crawl from every start, without noise: the starts and draws of the evaluation."""
    for start in range(config.starts):
        yield rollout(
            parameters, table, warm_up=config.warm_up, duration=config.duration, noise=0.0,
            start=(config.seed, start), policy_seed=run[2],
        )  # fmt: skip


def _arrival(observation: NDArray[np.int64]) -> int:
    """Sample at which the last observation began."""
    changes = np.flatnonzero(np.diff(observation))
    return int(changes[-1]) + 1 if changes.size else 0


def _is_settled(observation: NDArray[np.int64]) -> bool:
    return _arrival(observation) <= SETTLED * observation.size
