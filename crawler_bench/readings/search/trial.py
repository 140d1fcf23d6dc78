"""One trial of the search: a reading, trained and measured in memory, and given up early if it is hopeless.

What is measured is what `crawler-bench reproduce` measures, by the same functions; only nothing is written.
A trial ends early when the nearest-neighbour wave, put into this body by hand, is further than the verdict
"partly reproduced" allows from the paper's speed, wave frequency or peak contraction; when random action is
faster than that wave; or when too few of the first runs find the wiring. It is then scored by what is known,
measured quickly; what was not run counts as missing.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from crawler_bench.config.schema import RunConfig, override
from crawler_bench.paper.verdicts import Results
from crawler_bench.readings.catalogue import Reading
from crawler_bench.readings.fields import Value
from crawler_bench.readings.laboratory import EXPERIMENTS, REGULARIZED, UNREGULARIZED
from crawler_bench.readings.scoring import Score, score
from crawler_bench.runs.evaluation import Evaluation, measure
from crawler_bench.runs.policies.table import action_table
from crawler_bench.runs.results import Measured, label, tabulate
from crawler_bench.runs.training import learn

PAPER = {"speed": 0.0056, "waves_per_tau": 0.026, "peak_contraction": 0.33}
HOPELESS = 0.25  # relative distance of the hand-written wave from one of these
FEWEST = (2, 1 / 2), (4, 1 / 2), (6, 1 / 2), (8, 0.6)  # (runs, least share of them that has found the wiring)
PAIRED = 5  # seeds that the other gaits are run with; whether the wiring is found needs more of them
UNTRAINED = EXPERIMENTS[2]


@dataclass(frozen=True)
class Trial:
    """What a trial found.

    Attributes:
        reading: the reading.
        score: how it fares.
        runs: one row per run.
        stopped: why it was given up; empty if it was not.
        wave_off: how far the wave by hand is from the paper's speed, frequency and contraction, and random
            action from being slower: mean relative difference, each at most 1.
    """

    reading: Reading
    score: Score
    runs: pd.DataFrame
    stopped: str = ""
    wave_off: float = 0.0


@dataclass
class _Bench:
    """The runs of one reading, and evaluations of tables that several of them end with."""

    reading: Reading
    bases: Mapping[str, RunConfig]
    measured_with: Mapping[str, Value] = field(default_factory=dict)
    learned: list[tuple[str, RunConfig, int, np.ndarray, pd.DataFrame]] = field(default_factory=list)
    known: dict[tuple[str, bytes, int], Evaluation] = field(default_factory=dict)
    wave_off: dict[str, float] = field(default_factory=dict)

    def learn(self, experiment: str, seed: int) -> np.ndarray:
        """Train one run, and return its table."""
        config = self.reading.configure(self.bases[experiment])
        agent, recorder = learn(config, seed, interval=max(config.decisions // 20, 1))
        table = action_table(agent, config.parameters.n_segments, config.evaluation.mode)
        self.learned.append((experiment, config, seed, table, recorder.curve()))
        return table

    def measured(self, quick: bool) -> list[Measured]:
        """Measure every run; quickly where nothing but the wiring is asked for."""
        found = []
        for experiment, config, seed, table, curve in self.learned:
            if quick:
                config = _quick(config)
            elif experiment == UNTRAINED:  # nothing asks how noise acts on it
                config = override(config, {"evaluation.noise": [0.0]}, "trial")
            config = override(config, dict(self.measured_with), "trial")
            evaluation = self.evaluate(experiment, config, seed, table)
            name = f"{experiment}-seed{seed:02d}"
            found.append(Measured(label(experiment, config, seed), name, evaluation, curve))
        return found

    def evaluate(self, experiment: str, config: RunConfig, seed: int, table: np.ndarray) -> Evaluation:
        """Measure a table once; the seed of one that draws nothing changes nothing."""
        key = (experiment, table.tobytes(), seed if (table.max(axis=1) < 1).any() else 0)
        if key not in self.known:
            self.known[key] = measure(config, seed, table, config.evaluation)
        return self.known[key]


def _quick(config: RunConfig) -> RunConfig:
    """The run, measured from two starts without noise."""
    return override(config, {"evaluation.starts": 2, "evaluation.noise": [0.0]}, "trial")


def try_reading(
    reading: Reading,
    bases: Mapping[str, RunConfig],
    seeds: Sequence[int],
    *,
    fewest: Sequence[tuple[int, float]] = FEWEST,
    paired: int = PAIRED,
    patient: bool = False,
    measured_with: Mapping[str, Value] | None = None,
) -> Trial:
    """Train and score one reading.

    Args:
        reading: the reading.
        bases: the run of the default reading for each experiment.
        seeds: of the training runs.
        fewest: (number of first runs, least share of them that has to find the wiring).
        paired: how many of the seeds the other gaits are run with.
        patient: never give up, and run the other gaits with every seed.
        measured_with: what is changed after the training, by dotted key.
    """
    bench = _Bench(reading, bases, dict(measured_with or {}))
    stopped, others = "", seeds if patient else seeds[:paired]
    for reason in _stages(bench, seeds, others, fewest):
        if reason and not patient:
            stopped = reason
            break
    runs, evaluations, _ = tabulate(bench.measured(quick=bool(stopped)))
    found = score(
        Results(runs, evaluations), seeds, resamples=0, fewer={UNREGULARIZED: others, UNTRAINED: others}
    )
    return Trial(reading, found, runs, stopped, float(np.mean([*bench.wave_off.values()])))


def _stages(
    bench: _Bench, seeds: Sequence[int], paired: Sequence[int], fewest: Sequence[tuple[int, float]]
) -> Iterator[str]:
    """Run all that there is to run; yield, in between, why the rest would be in vain."""
    bench.wave_off = _wave_by_hand(bench)
    far = [name for name in PAPER if bench.wave_off[name] > HOPELESS]
    yield f"the wave's {far[0]} is far from the paper's" if far else ""
    yield "random action is faster than the wave" if bench.wave_off["random action"] > 0 else ""
    found = []
    for seed in seeds:
        policy = bench.learn(REGULARIZED, seed).argmax(axis=1)
        found.append(bool((policy == np.arange(policy.size)).all()))
        few = any(len(found) >= n and np.mean(found) < share for n, share in fewest)
        yield "few runs find the wiring" if few else ""
    for seed in paired:
        bench.learn(UNREGULARIZED, seed)
        bench.learn(UNTRAINED, seed)


def _wave_by_hand(bench: _Bench) -> dict[str, float]:
    """How far the nearest-neighbour wave, put in by hand, is from each of the paper's numbers, relatively.

    And by how much random action is faster than that wave.
    """
    config = bench.reading.configure(bench.bases[REGULARIZED])
    quick = _quick(config).evaluation
    n = config.parameters.n_segments
    evaluation = measure(config, 0, np.eye(n), quick)
    random = measure(config, 0, np.full((n, n), 1 / n), quick)
    starts = evaluation.starts
    ours = {
        "speed": starts["speed"].mean(),
        "waves_per_tau": 1 / evaluation.cycles["duration"].mean(),
        "peak_contraction": starts["peak_contraction"].mean(),
    }
    off = {name: abs(ours[name] / paper - 1) for name, paper in PAPER.items()}
    off["random action"] = max(0.0, random.starts["speed"].mean() / max(ours["speed"], 1e-6) - 1)
    return {name: min(each, 1.0) if each == each else 1.0 for name, each in off.items()}
