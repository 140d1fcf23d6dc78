"""Search the continuous constants jointly for the lowest score, by Optuna's TPE: same seed, same search.

Trials are asked for in batches, whose runs share all processes, and told in order; so the search neither
depends on the number of processes nor on which of them is faster.
"""

from collections.abc import Sequence

import optuna

from crawler_bench.readings.catalogue import Reading
from crawler_bench.readings.laboratory import Laboratory, Scored

BATCH = 4
_SEED = 20201122
# Lower and upper end, and the step of what has one; the rest is searched on a logarithmic scale.
RANGES: dict[str, tuple[float, float, float | None]] = {
    "parameters.tau_f": (0.2, 1.5, None),
    "parameters.neuron_rate": (1.0, 4.0, None),
    "parameters.spike_gain": (0.8, 4.0, None),
    "parameters.decision_interval": (0.05, 0.5, 0.05),
    "settings.initial_q": (0.05, 1.0, None),
    "environment.episode_distance": (0.5, 5.0, None),
    "environment.time_limit": (250.0, 4000.0, None),
}
DIGITS = 3  # significant ones of a constant that is tried


def search(
    laboratory: Laboratory, start: Sequence[Reading], seeds: Sequence[int], trials: int
) -> list[Scored]:
    """Run so many trials, those of `start` first.

    Args:
        laboratory: what to run them with.
        start: readings, changed in searched constants alone, to begin from.
        seeds: of every trial.
        trials: how many.
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
