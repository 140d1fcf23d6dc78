"""Run readings and score them: each trains both gaits and runs the untrained crawler."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import pandas as pd
from joblib import Parallel, delayed

from crawler_bench.config.schema import Experiment, RunConfig
from crawler_bench.paper.verdicts import Results
from crawler_bench.readings.catalogue import Reading, values_of
from crawler_bench.readings.scoring import Score, score
from crawler_bench.runs.machines.engines import Workers, as_workers
from crawler_bench.runs.results import read_outcomes
from crawler_bench.runs.sweep import Outcome, require_success, run_experiments

EXPERIMENTS = ("regularized", "unregularized", "untrained")
REGULARIZED, UNREGULARIZED = EXPERIMENTS[:2]


@dataclass(frozen=True)
class Scored:
    """A reading, run and scored.

    Attributes:
        reading: the reading.
        values: dotted key: value of its regularized run.
        free: names of its free constants.
        score: its distance from the paper.
        runs: one row per run, as `crawler_bench.runs.results.read_outcomes` gives them, with its speed at
            each amplitude of noise.
        errors: what went wrong, one line per failed run.
    """

    reading: Reading
    values: Mapping[str, object]
    free: tuple[str, ...]
    score: Score
    runs: pd.DataFrame
    errors: tuple[str, ...]


@dataclass(frozen=True)
class Laboratory:
    """Runs readings.

    Attributes:
        bases: the run of the default reading for each of EXPERIMENTS.
        root: folder of run folders.
        jobs: who does it, see `run_experiments`.
        quiet: say nothing.
    """

    bases: Mapping[str, RunConfig]
    root: Path
    jobs: Workers | int = 0
    quiet: bool = False

    def experiments(self, readings: Sequence[Reading], seeds: Sequence[int]) -> list[Experiment]:
        """What is run of readings, EXPERIMENTS of each."""
        return [
            Experiment(name=f"{reading.name} {name}", run=reading.configure(self.bases[name]), seeds=seeds)
            for reading in readings
            for name in EXPERIMENTS
        ]

    def run(self, readings: Sequence[Reading], seeds: Sequence[int]) -> list[Scored]:
        """Run and score readings; finished runs are looked up, and what two readings share is run once."""
        found = run_experiments(
            self.experiments(readings, seeds), self.root, jobs=self.jobs, quiet=self.quiet
        )
        require_success(found)
        each = len(EXPERIMENTS) * len(seeds)
        tasks = [
            delayed(_score)(
                reading,
                values_of(reading.configure(self.bases[REGULARIZED])),
                reading.free_constants(self.bases[REGULARIZED]),
                [_of_experiment(outcome) for outcome in found[i * each : (i + 1) * each]],
                tuple(seeds),
            )
            for i, reading in enumerate(readings)
        ]
        scored: list[Scored] = Parallel(n_jobs=as_workers(self.jobs).processes)(tasks)
        return scored


def _of_experiment(outcome: Outcome) -> Outcome:
    """An outcome of a reading under the name of its experiment alone."""
    name = outcome.cell.experiment.rpartition(" ")[2]
    return replace(outcome, cell=replace(outcome.cell, experiment=name))


def _score(
    reading: Reading,
    values: Mapping[str, object],
    free: tuple[str, ...],
    outcomes: list[Outcome],
    seeds: tuple[int, ...],
) -> Scored:
    runs, evaluations, _ = read_outcomes(outcomes)
    errors = tuple(f"{o.cell.experiment} seed {o.cell.seed}: {o.error}" for o in outcomes if o.error)
    found = score(Results(runs, evaluations), seeds)
    if not runs.empty:
        noisy = evaluations.pivot_table(index=["experiment", "seed"], columns="noise", values="speed")
        noisy.columns = [noisy_speed(float(noise)) for noise in noisy.columns]
        runs = runs.merge(noisy, left_on=["experiment", "seed"], right_index=True, how="left")
    return Scored(reading, values, free, found, runs, errors)


def noisy_speed(noise: float) -> str:
    """Name of the column of the speed at an amplitude of noise."""
    return f"speed_at_noise_{noise:g}"
