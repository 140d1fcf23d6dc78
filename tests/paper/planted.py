"""Results with planted answers: what the claims measure is known."""

import numpy as np
import pandas as pd

from crawler_bench.paper.verdicts import Results

SEEDS = 8
NOISES = (0.0, 0.025, 0.1, 0.2, 0.4)
PLANTED = {
    "regularized": {
        "wave_order": 0.9, "contracted_segments": 1.2, "diagonal_distance": 0, "observations": 10,
        "peak_contraction": 0.33, "waves_per_tau": 0.026, "speed": 0.0056, "speed_moving": 0.0056,
        "speed_learning_end": 0.0055, "unused_muscles": 0, "pairs_together": 0, "strain_gradient": 0.2,
        "strain_range": 0.3, "power_periodicity": 0.95, "power_peak_unevenness": 0.05,
        "power_duration_unevenness": 0.1, "cycle_duration": 38.0,
        "noisy": (0.0056, 0.0056, 0.0056, 0.0056, 0.0056),
    },
    "unregularized": {
        "wave_order": 0.8, "contracted_segments": 5.0, "diagonal_distance": 7, "observations": 10,
        "peak_contraction": 0.49, "waves_per_tau": 0.038, "speed": 0.00616, "speed_moving": 0.00672,
        "speed_learning_end": 0.0066, "unused_muscles": 5, "pairs_together": 4, "strain_gradient": 0.5,
        "strain_range": 0.4, "power_periodicity": 0.9, "power_peak_unevenness": 0.8,
        "power_duration_unevenness": 0.7, "cycle_duration": 26.0,
        "noisy": (0.0062, 0.006, 0.0054, 0.002, 0.001),
    },
    "untrained": {"wave_order": 0.02, "speed": 0.001, "noisy": (0.001,) * 5},
    "alpha_gamma": {"diagonal_distance": 2},
}  # fmt: skip
SIDE = {"regularized": 1.0, "unregularized": -1.0, "untrained": 0.5, "alpha_gamma": 0.0}  # of the spread
COUNTS = {"diagonal_distance", "observations", "unused_muscles", "pairs_together"}  # do not spread


def planted(
    changes: dict[str, dict[str, float]] | None = None,
    names: dict[str, str] | None = None,
    seeds: int = SEEDS,
    spread: float = 0.01,
) -> Results:
    """The centre of every column, spread over seeds so that interquartile means stay where they are.

    Args:
        changes: other values for some columns of some experiments.
        names: other names for some experiments.
        seeds: of each experiment.
        spread: relative, of the outermost runs.
    """
    runs, evaluations = [], []
    for experiment, centres in PLANTED.items():
        name, values = (
            (names or {}).get(experiment, experiment),
            centres | (changes or {}).get(experiment, {}),
        )
        curve = dict(zip(NOISES, values.pop("noisy", ()), strict=False))
        for seed, offset in enumerate(SIDE[experiment] * np.linspace(-1, 1, seeds)):
            factor = 1 + spread * offset
            row = {column: value * (1 if column in COUNTS else factor) for column, value in values.items()}
            runs.append({"experiment": name, "seed": seed} | row)
            evaluations += [
                (name, seed, noise, start, share * speed * factor)
                for noise, speed in curve.items()
                for start, share in enumerate((0.8, 1.2))  # starts differ; their mean counts
            ]
    columns = ["experiment", "seed", "noise", "start", "speed"]
    return Results(pd.DataFrame(runs), pd.DataFrame(evaluations, columns=columns))
