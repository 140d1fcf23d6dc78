"""Which single field frees a learner that ends off the diagonal.

One field of a reading is changed at a time, and the share of runs counted that find the nearest-neighbour
wiring. The fields are those that change how long and from where a learner explores (optimism, the length of
an episode by distance and by time, the decision interval, noise while it learns, how long it goes on), and
the head muscle, because it is at the head that learners are trapped.
"""

import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from joblib import Parallel, delayed

from crawler_bench.config.schema import RunConfig, override
from crawler_bench.physics.parameters import CHOICES
from crawler_bench.readings.catalogue import Reading
from crawler_bench.readings.fields import Value
from crawler_bench.readings.laboratory import REGULARIZED
from crawler_bench.runs.phases import Phase, unseen
from crawler_bench.runs.training import learn
from crawler_bench.statistics import estimates

FACTORS = (1 / 4, 4)
SCALED = (
    "settings.initial_q",
    "environment.episode_distance",
    "environment.time_limit",
    "parameters.decision_interval",
    "decisions",
)
NOISE = (0.025, 0.05, 0.1)  # s, while learning


def freeing(
    reading: Reading,
    bases: Mapping[str, RunConfig],
    seeds: Sequence[int],
    jobs: int = 0,
    phase: Phase = unseen,
) -> pd.DataFrame:
    """Share of runs on the diagonal with one field changed.

    Args:
        reading: the reading that is changed.
        bases: the run of the default reading for each experiment.
        seeds: of the training runs.
        jobs: parallel processes; 0 is one per core.
        phase: shows how far it is.

    Returns:
        One row per value of each field: field, value, on_diagonal, low, high, n; the reading itself first,
        with an empty field.
    """
    config = reading.configure(bases[REGULARIZED])
    cases = [("", "", config), *_changed(config)]
    tasks = (delayed(_finds)(each, seed) for _, _, each in cases for seed in seeds)
    workers: Any = Parallel(n_jobs=jobs or os.cpu_count() or 1, return_as="generator")
    found = np.zeros((len(cases), len(seeds)), dtype=bool)
    with phase("one field changed", found.size, "runs") as advance:
        for place, finds in enumerate(workers(tasks)):
            found.flat[place] = finds
            advance(place + 1)
    rows = []
    for (field, value, _), row in zip(cases, found, strict=True):
        share = estimates.share(pd.Series(row))
        rows.append((field, value, share.value, share.low, share.high, share.n))
    return pd.DataFrame(rows, columns=["field", "value", "on_diagonal", "low", "high", "n"])


def _changed(config: RunConfig) -> list[tuple[str, Value, RunConfig]]:
    """Every case: name of the field, its value, the run."""
    cases: list[tuple[str, Value, RunConfig]] = []
    for word in CHOICES["head_muscle"]:
        if word != config.parameters.head_muscle:
            cases.append(("head_muscle", word, override(config, {"parameters.head_muscle": word}, "freeing")))
    for key in SCALED:
        for factor in FACTORS:
            value = factor * _value(config, key)
            if key == "parameters.decision_interval":
                value = round(value / config.parameters.dt) * config.parameters.dt
            value = float(f"{value:.3g}")
            change: dict[str, Value] = {key: int(value) if key == "decisions" else value}
            cases.append((key.rpartition(".")[2], value, override(config, change, "freeing")))
    for noise in NOISE:
        cases.append(("noise", noise, override(config, {"environment.noise": noise}, "freeing")))
    return cases


def _value(config: RunConfig, key: str) -> float:
    section, _, name = key.rpartition(".")
    within = getattr(config, section) if section else config
    return float(within[name] if isinstance(within, dict) else getattr(within, name))


def _finds(config: RunConfig, seed: int) -> bool:
    """Whether a run ends on the diagonal."""
    agent, _ = learn(config, seed, interval=config.decisions)
    policy = np.array(getattr(agent, "q_table")).argmax(axis=1)  # noqa: B009 (only the tabular learner has one)
    return bool((policy == np.arange(policy.size)).all())
