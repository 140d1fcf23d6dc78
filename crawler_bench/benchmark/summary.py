"""A benchmark in one tidy frame: every metric of every agent over its independent runs, with its interval."""

from collections.abc import Callable
from dataclasses import astuple, dataclass
from enum import Enum
from typing import Any

import numpy as np
import pandas as pd

from crawler_bench.benchmark.curves import learning_decisions, noise_area, noise_curves
from crawler_bench.benchmark.keys import GROUP, LEARNER, RUN
from crawler_bench.gait.metrics import ORDERLY
from crawler_bench.statistics import estimates
from crawler_bench.statistics.estimates import Estimate

DIGITS = 12  # of a regret: where all runs of the best agree it is 0, not 1e-19
Identify = Callable[[str, str, float, str], str]


class Statistic(Enum):
    """How the values of all runs become one number."""

    IQM = "interquartile mean"
    MEAN = "mean"  # of quantities that few runs have: an interquartile mean would trim them away
    SHARE = "share of runs"

    def of(self, values: pd.Series) -> Estimate:
        """The statistic with its 95 % interval: BCa, or Wilson's of a share."""
        if self is Statistic.SHARE:
            return estimates.share(values.to_numpy(bool))
        return estimates.estimate(
            values.to_numpy(float), np.mean if self is Statistic.MEAN else estimates.interquartile_mean
        )


@dataclass(frozen=True)
class Metric:
    """One number per run, and its statistic over runs.

    Attributes:
        name: in summary.csv.
        label: in tables.
        unit: empty for a bare number.
        statistic: over runs.
        of: the metric of every row of what `measure_runs` returns; NaN is unknown and not counted.
    """

    name: str
    label: str
    unit: str
    statistic: Statistic
    of: Callable[[pd.DataFrame], pd.Series]

    @property
    def heading(self) -> str:
        """Label and unit."""
        return f"{self.label} ({self.unit})" if self.unit else self.label


def _column(
    name: str, label: str, unit: str = "", column: str = "", statistic: Statistic = Statistic.IQM
) -> Metric:
    return Metric(name, label, unit, statistic, lambda runs: runs[column or name].astype(float))


# A run that stalls from every start has no gait: NaN in what describes one, but no wave in a share.
METRICS = (
    _column("speed", "speed", "L/tau"),
    _column("speed_moving", "speed of starts that move", "L/tau"),
    _column("speed_learning", "speed while learning, last tenth", "L/tau", "speed_learning_end"),
    _column("reward", "reward per decision", "L"),
    _column("regret", "regret to the best agent's reward", "L"),
    _column("regret_table", "regret to the best table", "L"),
    _column("regret_stochastic", "regret to the best stochastic table", "L"),
    _column("regret_state", "regret to the best policy on the whole state", "L"),
    _column("score", "score: random 0, best table 1"),
    _column("stall_share", "starts that stall", statistic=Statistic.MEAN),
    _column("cycle_duration", "cycle duration", "tau"),
    _column("cycles", "cycles per run, all starts"),
    _column("wave_order", "wave order, positive from tail to head"),
    Metric("wave_share", "runs with a wave from tail to head", "", Statistic.SHARE,
           lambda runs: runs["wave_order"] > ORDERLY),
    _column("peak_contraction", "peak contraction", "rest lengths"),
    _column("strain_gradient", "strain gradient"),
    _column("unused_muscles", "unused muscles"),
    _column("power_per_distance", "power per distance", "k L"),
    _column("off_diagonal", "distance from the diagonal"),
    Metric("diagonal_share", "runs exactly on the diagonal", "", Statistic.SHARE,
           lambda runs: runs["off_diagonal"] == 0),
    _column("noise_area", "speed averaged over noise", "L/tau"),
    _column("decisions_to_final", "decisions to 90 % of the final speed"),
    _column("decisions", "decisions learned from"),
    _column("gradient_updates", "gradient updates"),
)  # fmt: skip


def noise_metric(amplitude: float) -> Metric:
    """Speed at one amplitude of noise."""
    return _column(f"speed_noise_{amplitude:g}", f"speed at s = {amplitude:g}", "L/tau")


def metric(name: str) -> Metric:
    """A metric by its name."""
    if name.startswith("speed_noise_"):
        return noise_metric(float(name.removeprefix("speed_noise_")))
    return next(each for each in METRICS if each.name == name)


def measure_runs(
    runs: pd.DataFrame,
    evaluations: pd.DataFrame,
    curves: pd.DataFrame | None = None,
    ceilings: pd.DataFrame | None = None,
) -> pd.DataFrame:
    """Add to the runs what follows from their noise curves, their learning curves and the other agents.

    Args:
        runs: one row per run and mode.
        evaluations: one row per run, mode, noise and start.
        curves: one row per learning run and window; without them `decisions_to_final` is NaN.
        ceilings: of `ceilings.find_ceilings`; without them what is measured against them is NaN.

    Returns:
        The runs with the columns noise_area and speed_noise_*, both L / tau_theta; decisions_to_final; and
        regret, L: the highest interquartile mean reward of any agent and mode at the same regularization,
        minus the run's. The interval of a regret leaves out the uncertainty of that best. Then regret_table,
        regret_stochastic and regret_state, L, against the ceilings without noise; and score, the run's reward
        where that of random action is 0 and that of the best deterministic table is 1.
    """
    noisy = noise_curves(evaluations)
    area = noise_area(noisy).rename("noise_area")
    named = noisy.set_axis(
        [noise_metric(amplitude).name for amplitude in noisy.columns.to_numpy(float)], axis=1
    )
    measured = runs.merge(pd.concat([area, named], axis=1).reset_index(), on=RUN, how="left")
    learned = learning_decisions(pd.DataFrame() if curves is None else curves)
    if len(learned):
        measured = measured.merge(learned, on=LEARNER, how="left")
    else:
        measured["decisions_to_final"] = float("nan")
    rewards = runs.dropna(subset="reward").groupby(GROUP)["reward"].apply(
        lambda values: estimates.interquartile_mean(values.to_numpy(float))
    )  # fmt: skip
    best = rewards.groupby("regularization").max()
    regret = measured["regularization"].map(best) - measured["reward"]
    return measured.assign(regret=regret.round(DIGITS), **_against_ceilings(measured, ceilings))


def _against_ceilings(measured: pd.DataFrame, ceilings: pd.DataFrame | None) -> dict[str, pd.Series]:
    """Regrets and score of every run; NaN where a ceiling is not known."""
    quiet = pd.DataFrame() if ceilings is None or ceilings.empty else ceilings[ceilings["noise"] == 0]

    def reward_of(kind: str) -> pd.Series:
        if quiet.empty:
            return pd.Series(float("nan"), index=measured.index)
        known = quiet[quiet["kind"] == kind].set_index("regularization")["reward"]
        return measured["regularization"].map(known).astype(float)

    table, random = reward_of("table"), reward_of("random")
    regrets = {
        f"regret_{name}": (reward_of(kind) - measured["reward"]).round(DIGITS)
        for name, kind in (("table", "table"), ("stochastic", "stochastic table"), ("state", "state"))
    }
    return regrets | {"score": (measured["reward"] - random) / (table - random)}


def summarize_benchmark(
    runs: pd.DataFrame,
    evaluations: pd.DataFrame,
    curves: pd.DataFrame,
    identify: Identify,
    ceilings: pd.DataFrame | None = None,
) -> pd.DataFrame:
    """Every metric of every agent, mode and regularization over its runs.

    Args:
        runs: one row per run and mode.
        evaluations: one row per run, mode, noise and start.
        curves: one row per learning run and window.
        identify: (agent, mode, regularization, metric) -> hash of the cell.
        ceilings: of `ceilings.find_ceilings`.

    Returns:
        One row per table cell: agent, mode, regularization, metric, value, low, high, n, hash. Where all runs
        agree low = high = value; where none is known all are NaN and n is 0. Agents in the order of `runs`.
    """
    metrics = (*METRICS, *map(noise_metric, sorted(evaluations["noise"].unique())))
    groups: Any = measure_runs(runs, evaluations, curves, ceilings).groupby(GROUP, sort=False)
    rows = [
        (agent, mode, level, each.name, *astuple(each.statistic.of(each.of(of_group))),
         identify(agent, mode, level, each.name))
        for (agent, mode, level), of_group in groups
        for each in metrics
    ]  # fmt: skip
    return pd.DataFrame(rows, columns=[*GROUP, "metric", "value", "low", "high", "n", "hash"])
