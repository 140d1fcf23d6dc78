"""Whether the chosen reading holds where nothing was fitted: other numerics, other intervals, other seeds."""

import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from joblib import Parallel, delayed

from crawler_bench.config.schema import RunConfig
from crawler_bench.readings.catalogue import Reading
from crawler_bench.readings.fields import Value
from crawler_bench.readings.laboratory import REGULARIZED
from crawler_bench.readings.search.rounds import row
from crawler_bench.readings.search.trial import try_reading
from crawler_bench.runs.phases import Phase, unseen

TIME_LIMIT = 4000.0  # tau: the environment's own, which the paper does not have
FURTHER = 10  # seeds drawn at random
FEW = 5  # seeds where steps are taken, which is slow
FINE = {"parameters.integrator": "step", "parameters.dt": 0.002}


def holding(
    reading: Reading,
    bases: Mapping[str, RunConfig],
    seeds: Sequence[int],
    jobs: int = 0,
    phase: Phase = unseen,
) -> pd.DataFrame:
    """Try a reading under other numerics and on further seeds.

    Args:
        reading: the reading.
        bases: the run of the default reading for each experiment.
        seeds: of the training runs, except those drawn here.
        jobs: parallel processes; 0 is one per core.
        phase: shows how far it is.

    Returns:
        One row per case: case, seeds, and what `row` says of it.
    """
    half = _half_interval(reading.configure(bases[REGULARIZED]))
    drawn = tuple(int(seed) for seed in np.random.default_rng().integers(10_000, 2**31, FURTHER))
    cases: list[tuple[str, dict[str, Value], dict[str, Value], Sequence[int]]] = [
        ("further seeds, drawn at random", {}, {}, drawn),
        ("a time limit of 4,000 tau", {"environment.time_limit": TIME_LIMIT}, {}, seeds),
        ("trained and measured in steps of dt = 0.01", {"parameters.integrator": "step"}, {}, seeds[:FEW]),
        ("trained policies in steps of dt = 0.002", {}, FINE, seeds[:FEW]),
        ("trained policies at half the decision interval", {}, half, seeds),
        ("trained and measured at half the decision interval", half, {}, seeds),
    ]
    tasks = (
        delayed(_case)(
            name, Reading(reading.name, "search", {**reading.changes, **change}), bases, of, measured
        )
        for name, change, measured, of in cases
    )
    workers: Any = Parallel(n_jobs=jobs or os.cpu_count() or 1, return_as="generator")
    rows: list[dict[str, Any]] = []
    with phase("other numerics, further seeds", len(cases), "cases") as advance:
        for found in workers(tasks):
            rows.append(found)
            advance(len(rows))
    return pd.DataFrame(rows)


def _half_interval(config: RunConfig) -> dict[str, Value]:
    p = config.parameters  # half of dt, too, so that the interval stays a whole multiple of it
    return {"parameters.decision_interval": p.decision_interval / 2, "parameters.dt": p.dt / 2}


def _case(
    name: str,
    reading: Reading,
    bases: Mapping[str, RunConfig],
    seeds: Sequence[int],
    measured: Mapping[str, Value],
) -> dict[str, Any]:
    found = row(try_reading(reading, bases, seeds, patient=True, measured_with=measured), bases)
    return {"case": name, "seeds": " ".join(map(str, seeds)), **found}
