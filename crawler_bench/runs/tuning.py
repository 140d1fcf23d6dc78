"""Tune an agent: Optuna proposes settings, runs on seeds that no comparison uses tell what they are worth.

A trial is worth the mean reward of a decision, frozen and without noise, over all of its runs. Proposals
come one at a time from a seeded sampler, the runs of a trial run in parallel, and finished runs are looked
up: the same search gives the same trials, however often it is interrupted.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import optuna
import pandas as pd

from crawler_bench.config.schema import Range, RunConfig, Tuning, override
from crawler_bench.runs.machines.engines import Workers
from crawler_bench.runs.results import read_outcomes
from crawler_bench.runs.sweep import run_experiments

SAMPLER_SEED = 2020
STARTUP_TRIALS = 4  # drawn at random before the sampler learns from what it saw


def tune(
    tuning: Tuning, runs_root: Path, *, jobs: Workers | int, quiet: bool, say: Callable[[str], None]
) -> tuple[RunConfig, pd.DataFrame]:
    """Search.

    Args:
        tuning: what to search, and how many trials.
        runs_root: folder of run folders.
        jobs: who does it, see `run_experiments`.
        quiet: show no progress.
        say: is told every trial.

    Returns:
        The run with the best settings, and one row per trial: trial, one column per setting, reward, rewards
        and speeds at each regularization, error.

    Raises:
        RuntimeError: if every trial failed.
    """
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    sampler = optuna.samplers.TPESampler(seed=SAMPLER_SEED, n_startup_trials=STARTUP_TRIALS)
    study = optuna.create_study(direction="maximize", sampler=sampler)
    study.enqueue_trial({key: each.start for key, each in tuning.space.items()})
    rows = []
    for number in range(tuning.trials):
        trial = study.ask()
        chosen = {key: _draw(trial, key, each) for key, each in tuning.space.items()}
        measured = _try(tuning, chosen, runs_root, jobs=jobs, quiet=quiet)
        if "reward" in measured:
            study.tell(trial, measured["reward"])
        else:
            study.tell(trial, state=optuna.trial.TrialState.FAIL)
        rows.append({"trial": number, **chosen, **measured})
        say(f"[trial {number + 1}/{tuning.trials}] {measured.get('reward', measured['error'])}: {chosen}")
    trials = pd.DataFrame(rows)
    if trials["error"].astype(bool).all():
        raise RuntimeError(f"all {len(trials)} trials failed; the first: {trials['error'].iloc[0]}")
    return override(tuning.run, study.best_params, tuning.name), trials


def _draw(trial: optuna.Trial, key: str, what: Range) -> Any:
    if what.values:
        return trial.suggest_categorical(key, what.values)
    return trial.suggest_float(key, what.low, what.high, log=what.log)


def _try(
    tuning: Tuning, chosen: dict[str, Any], runs_root: Path, *, jobs: Workers | int, quiet: bool
) -> dict[str, Any]:
    """Reward and speed of one proposal, or what went wrong."""
    tried = tuning.model_copy(update={"run": override(tuning.run, chosen, tuning.name)})
    outcomes = run_experiments([tried], runs_root, jobs=jobs, quiet=quiet)
    errors = [outcome.error for outcome in outcomes if outcome.error]
    if errors:
        return {"error": errors[0]}
    runs = read_outcomes(outcomes)[0]
    measured: dict[str, Any] = {"reward": float(runs["reward"].mean())}
    for regularization, group in runs.groupby("regularization"):
        measured[f"reward at {regularization:g}"] = float(group["reward"].mean())
        measured[f"speed at {regularization:g}"] = float(group["speed"].mean())
    return measured | {"error": ""}
