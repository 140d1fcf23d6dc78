"""Run readings and score them: each trains both gaits and runs the untrained crawler."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import pandas as pd
from joblib import Parallel, delayed

from crawler_bench.config.schema import RunConfig
from crawler_bench.paper.verdicts import Results
from crawler_bench.readings.catalogue import Reading, values_of
from crawler_bench.readings.scoring import Score, score
from crawler_bench.runs.sweep import Cell, Outcome, read_outcomes, run_cells

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
        runs: one row per run, as `crawler_bench.runs.sweep.read_outcomes` gives them, with its speed at each
            amplitude of noise.
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
        bases: the run of the default reading for each of EXPERIMENTS; their agents are "module:Class"
            strings.
        root: folder of run folders.
        jobs: number of processes; 0 means one a core.
        quiet: say nothing.
    """

    bases: Mapping[str, RunConfig]
    root: Path
    jobs: int = 0
    quiet: bool = False

    def cells(self, reading: Reading, seeds: Sequence[int]) -> list[Cell]:
        """The runs that a reading needs."""
        return [
            Cell(experiment, reading.configure(self.bases[experiment]), seed)
            for experiment in EXPERIMENTS
            for seed in seeds
        ]

    def run(self, readings: Sequence[Reading], seeds: Sequence[int]) -> list[Scored]:
        """Run and score readings; finished runs are looked up, and what two readings share is run once."""
        needed = {reading.name: self.cells(reading, seeds) for reading in readings}
        unique: dict[str, Cell] = {}
        for name, cells in needed.items():
            for cell in cells:
                unique.setdefault(_key(cell), replace(cell, experiment=f"{name} {cell.experiment}"))
        found = run_cells(list(unique.values()), self.root, jobs=self.jobs, quiet=self.quiet)
        outcomes = dict(zip(unique, found, strict=True))
        tasks = [
            delayed(_score)(
                reading,
                values_of(reading.configure(self.bases[REGULARIZED])),
                reading.free_constants(self.bases[REGULARIZED]),
                [replace(outcomes[_key(cell)], cell=cell) for cell in needed[reading.name]],
                tuple(seeds),
            )
            for reading in readings
        ]
        scored: list[Scored] = Parallel(n_jobs=self.jobs or os.cpu_count() or 1)(tasks)
        return scored


def _key(cell: Cell) -> str:
    return f"{cell.seed} {cell.config.model_dump_json()}"


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
