"""Tune an agent: Optuna proposes settings, runs on seeds that no comparison uses tell what they are worth.

A trial is worth the mean reward of a decision, frozen and without noise, in the mode of the search, over its
seeds. The seeds come one at a time: a trial whose reward so far is below the median of the complete trials
after as many seeds is pruned. Proposals come from a seeded sampler and finished runs are looked up: the same
search gives the same trials, however often it is interrupted.
"""

import warnings
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
STARTUP_TRIALS = 8  # drawn at random before the sampler learns; these are never pruned
COMPLETE, PRUNED, FAILED = "complete", "pruned", "failed"


def tune(
    tuning: Tuning, runs_root: Path, *, jobs: Workers | int, quiet: bool, say: Callable[[str], None]
) -> tuple[RunConfig, pd.DataFrame, pd.DataFrame]:
    """Search.

    Args:
        tuning: what to search, and how many trials.
        runs_root: folder of run folders.
        jobs: who does it, see `run_experiments`.
        quiet: show no progress.
        say: is told every trial.

    Returns:
        The run with the best settings; one row per trial, pruned and failed ones included: trial, one column
        per setting, state, seeds (how many were run), reward (mean over these), reward_SEED of each seed,
        error; and the importance of each setting (`importance`).

    Raises:
        RuntimeError: if every trial failed.
    """
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    sampler = optuna.samplers.TPESampler(seed=SAMPLER_SEED, n_startup_trials=STARTUP_TRIALS)
    pruner = optuna.pruners.MedianPruner(n_startup_trials=STARTUP_TRIALS)
    study = optuna.create_study(direction="maximize", sampler=sampler, pruner=pruner)
    study.enqueue_trial({key: each.start for key, each in tuning.space.items()})
    rows = []
    for number in range(tuning.trials):
        trial = study.ask()
        chosen = {key: _draw(trial, key, each) for key, each in tuning.space.items()}
        measured = _try(trial, tuning, chosen, runs_root, jobs=jobs, quiet=quiet)
        _tell(study, trial, measured)
        rows.append({"trial": number, **chosen, **measured})
        worth = measured["error"] or f"{measured['reward']:.6g} over {measured['seeds']} seeds"
        say(f"[trial {number + 1}/{tuning.trials}] {measured['state']}, {worth}: {chosen}")
    trials = pd.DataFrame(rows)
    if (trials["state"] == FAILED).all():
        raise RuntimeError(f"all {len(trials)} trials failed; the first: {trials['error'].iloc[0]}")
    return override(tuning.run, study.best_params, tuning.name), trials, importance(study)


def importance(study: optuna.Study) -> pd.DataFrame:
    """How much each setting decides whether a trial is among the better ones.

    PED-ANOVA [Watanabe, Bansal & Hutter 2023]: the spread of a setting among the better tenth of the trials
    against its spread among all, in shares that sum to 1.

    Returns:
        One row per setting: setting, importance; the most important first. Empty with fewer than two complete
        trials.
    """
    complete = [each for each in study.trials if each.state is optuna.trial.TrialState.COMPLETE]
    if len(complete) < 2:
        return pd.DataFrame(columns=["setting", "importance"])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
        evaluator = optuna.importance.PedAnovaImportanceEvaluator()
        found = optuna.importance.get_param_importances(study, evaluator=evaluator)
    return pd.DataFrame({"setting": list(found), "importance": list(found.values())})


def _draw(trial: optuna.Trial, key: str, what: Range) -> Any:
    if what.values:
        return trial.suggest_categorical(key, what.values)
    return trial.suggest_float(key, what.low, what.high, log=what.log)


def _tell(study: optuna.Study, trial: optuna.Trial, measured: dict[str, Any]) -> None:
    if measured["state"] == COMPLETE:
        study.tell(trial, measured["reward"])
    else:
        states = {PRUNED: optuna.trial.TrialState.PRUNED, FAILED: optuna.trial.TrialState.FAIL}
        study.tell(trial, state=states[measured["state"]])


def _try(
    trial: optuna.Trial,
    tuning: Tuning,
    chosen: dict[str, Any],
    runs_root: Path,
    *,
    jobs: Workers | int,
    quiet: bool,
) -> dict[str, Any]:
    """What became of one proposal, seed by seed."""
    run = override(tuning.run, chosen, tuning.name)
    rewards: dict[int, float] = {}
    state, error = COMPLETE, ""
    for step, seed in enumerate(tuning.seeds):
        found = _reward(tuning.model_copy(update={"run": run, "seeds": (seed,)}), runs_root, jobs, quiet)
        if isinstance(found, str):
            state, error = FAILED, found
            break
        rewards[seed] = found
        trial.report(sum(rewards.values()) / len(rewards), step)
        if step + 1 < len(tuning.seeds) and trial.should_prune():
            state = PRUNED
            break
    known = [rewards.get(seed, float("nan")) for seed in tuning.seeds]
    mean = sum(rewards.values()) / len(rewards) if rewards else float("nan")
    by_seed = {f"reward_{seed}": value for seed, value in zip(tuning.seeds, known, strict=True)}
    return {"state": state, "seeds": len(rewards), "reward": mean, **by_seed, "error": error}


def _reward(tried: Tuning, runs_root: Path, jobs: Workers | int, quiet: bool) -> float | str:
    """Mean reward of the runs of one seed, or what went wrong."""
    outcomes = run_experiments([tried], runs_root, jobs=jobs, quiet=quiet)
    errors = [outcome.error for outcome in outcomes if outcome.error]
    return errors[0] if errors else float(read_outcomes(outcomes)[0]["reward"].mean())
