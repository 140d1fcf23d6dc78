"""Search the continuous constants jointly for the lowest score, by Optuna's seeded TPE sampler.

Trials are proposed in batches, whose runs share all processes, and reported in order; so the search depends
neither on the number of processes nor on their speed.
"""

from collections.abc import Sequence

import optuna

from crawler_bench.readings.catalogue import Reading
from crawler_bench.readings.laboratory import Laboratory, Scored

BATCH = 4
_SEED = 20201122
# Lower end, upper end and step; without a step the scale is logarithmic.
RANGES: dict[str, tuple[float, float, float | None]] = {
    "parameters.tau_f": (0.2, 1.5, None),
    "parameters.neuron_rate": (1.0, 4.0, None),
    "parameters.spike_gain": (0.8, 4.0, None),
    "parameters.decision_interval": (0.05, 0.5, 0.05),
    "settings.initial_q": (0.05, 1.0, None),
    "environment.episode_distance": (0.5, 5.0, None),
    "environment.time_limit": (250.0, 4000.0, None),
}
DIGITS = 3  # significant digits of a constant


def search(
    laboratory: Laboratory, start: Sequence[Reading], seeds: Sequence[int], trials: int
) -> list[Scored]:
    """Run the trials, those of `start` first.

    Args:
        laboratory: runs them.
        start: readings to begin from, which change searched constants only.
        seeds: of every trial.
        trials: their number.
    """
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    sampler = optuna.samplers.TPESampler(seed=_SEED, n_startup_trials=3 * BATCH, constant_liar=True)
    study = optuna.create_study(sampler=sampler)
    for reading in start:
        study.enqueue_trial(dict(reading.changes))
    found: list[Scored] = []
    while len(found) < trials:
        asked = [study.ask() for _ in range(min(BATCH, trials - len(found)))]
        readings = [
            Reading(f"search-{len(found) + i:02d}", "search", _suggest(trial))
            for i, trial in enumerate(asked)
        ]
        scored = laboratory.run(readings, seeds)
        for trial, each in zip(asked, scored, strict=True):
            study.tell(trial, each.score.value)
        found += scored
    return found


def _suggest(trial: optuna.Trial) -> dict[str, float]:
    changes = {}
    for key, (low, high, step) in RANGES.items():
        value = trial.suggest_float(key, low, high, step=step, log=step is None)
        changes[key] = float(f"{value:.{DIGITS}g}")
    return changes
