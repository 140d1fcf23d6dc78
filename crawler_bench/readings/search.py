"""Search the joint space of readings for the paper's story told with few constants of our own, in three stages.

1. *Trials*: Optuna's TPE proposes readings for two objectives, the score and the number of free constants.
   Many processes ask and tell through one journal file, so the search goes on after an interruption and on as
   many cores as there are. Hopeless trials end early, see `trial.py`.
2. *Again*: the best of the trials, by the rule of `scoring.py`, run on seeds that no trial has seen.
3. *Finals*: the best of those, on more seeds that nothing has seen.

What stage 1 found is biased, because it was chosen for being good on its seeds; stages 2 and 3 are not.
"""

import json
import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import optuna
import pandas as pd
from joblib import Parallel, delayed
from optuna.storages import JournalStorage
from optuna.storages.journal import JournalFileBackend

from crawler_bench.config.schema import RunConfig
from crawler_bench.readings.catalogue import Reading
from crawler_bench.readings.scoring import rank
from crawler_bench.readings.space import draw, proposal
from crawler_bench.readings.trial import UNTRAINED, Trial, try_reading
from crawler_bench.readings.laboratory import REGULARIZED, UNREGULARIZED

STUDY = "readings"
STARTUP = 100  # trials drawn at random before the sampler learns from what it saw
ROUND = 50  # trials between two lines of progress
_SEED = 20201122


def run_trials(
    bases: Mapping[str, RunConfig],
    journal: Path,
    *,
    first: Sequence[Reading],
    seeds: Sequence[int],
    trials: int,
    jobs: int,
    say: Callable[[str], None],
) -> pd.DataFrame:
    """Run the first stage, or what is left of it.

    Args:
        bases: the run of the default reading for each experiment.
        journal: file that keeps the trials.
        first: readings to begin with.
        seeds: of every trial.
        trials: how many.
        jobs: parallel processes; 0 is one per core.
        say: told how far the search is.

    Returns:
        One row per trial, see `row`.
    """
    journal.parent.mkdir(parents=True, exist_ok=True)
    if not journal.exists():
        study = _study(journal, 0)
        for reading in first:
            study.enqueue_trial(proposal(reading))
    workers = jobs or os.cpu_count() or 1
    while (done := len(finished(journal))) < trials:
        share = -(-min(ROUND, trials - done) // workers)
        Parallel(n_jobs=workers)(
            delayed(_work)(journal, dict(bases), tuple(seeds), share, done + worker) for worker in range(workers)
        )
        rows = finished(journal)
        best = rows.loc[rows["score"].idxmin()]
        say(f"[trial {len(rows)}/{trials}] lowest score {best['score']:.3f} with {best['free']} free constants")
    return finished(journal).head(trials)


def _study(journal: Path, seed: int) -> optuna.Study:
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    sampler = optuna.samplers.TPESampler(
        seed=_SEED + seed, n_startup_trials=STARTUP, multivariate=True, constant_liar=True
    )
    return optuna.create_study(
        storage=JournalStorage(JournalFileBackend(str(journal))), study_name=STUDY, sampler=sampler,
        directions=("minimize", "minimize"), load_if_exists=True,
    )  # fmt: skip


def _work(
    journal: Path, bases: Mapping[str, RunConfig], seeds: tuple[int, ...], trials: int, seed: int
) -> None:
    """Ask for, run and tell a few trials."""
    study = _study(journal, seed)
    for _ in range(trials):
        asked = study.ask()
        reading = Reading(f"trial-{asked.number:04d}", "search", draw(asked))
        try:
            found = row(try_reading(reading, bases, seeds), bases)
        except ValueError as error:  # a combination that the model refuses
            asked.set_user_attr("refused", str(error))
            study.tell(asked, state=optuna.trial.TrialState.FAIL)
            continue
        asked.set_user_attr("row", json.dumps(found))
        study.tell(asked, (found["score"], found["free"]))


def finished(journal: Path) -> pd.DataFrame:
    """One row per finished trial, in order; see `row`."""
    states = (optuna.trial.TrialState.COMPLETE,)
    done = _study(journal, 0).get_trials(deepcopy=False, states=states)
    return pd.DataFrame([json.loads(each.user_attrs["row"]) for each in done])


def row(trial: Trial, bases: Mapping[str, RunConfig]) -> dict[str, object]:
    """What is kept of a trial.

    Returns:
        reading, score, free, free_constants, within, core_failures, stopped, changes (JSON), n, and of the
        runs: on_diagonal (share of the regularized ones), policies, speed, waves_per_tau, peak_contraction,
        kept (speed under noise relative to that without), unregularized (speed), random (speed), each a mean.
    """
    free = trial.reading.free_constants(bases[REGULARIZED])
    claims = trial.score.claims.set_index("claim")["ours"]
    regularized, unregularized, untrained = (
        trial.runs[trial.runs["experiment"] == name] if len(trial.runs) else pd.DataFrame()
        for name in (REGULARIZED, UNREGULARIZED, UNTRAINED)
    )

    def mean(runs: pd.DataFrame, column: str) -> float | None:
        value = float(runs[column].mean()) if len(runs) else float("nan")
        return value if value == value else None  # JSON has no NaN

    def known(claim: str) -> float | None:
        value = float(claims[claim])
        return value if value == value else None

    return {
        "reading": trial.reading.name,
        "score": trial.score.value,
        "free": len(free),
        "free_constants": " ".join(free),
        "within": trial.score.within and not trial.stopped,
        "core_failures": " ".join(trial.score.core_failures),
        "stopped": trial.stopped,
        "changes": json.dumps(dict(trial.reading.changes)),
        "n": len(regularized),
        "on_diagonal": known("nearest_neighbour") if len(regularized) else None,
        "policies": " ".join(regularized["policy"]) if len(regularized) else "",
        "speed": mean(regularized, "speed"),
        "waves_per_tau": mean(regularized, "waves_per_tau"),
        "peak_contraction": mean(regularized, "peak_contraction"),
        "kept": known("maintains_speed"),
        "unregularized": mean(unregularized, "speed"),
        "random": mean(untrained, "speed"),
    }


def best(trials: pd.DataFrame, number: int) -> list[Reading]:
    """The best of the trials by the rule: within tolerance by free constants and score, then by score."""
    ranked = rank(trials).drop_duplicates("changes").head(number)
    return [
        Reading(str(each["reading"]), "search", json.loads(str(each["changes"])))
        for each in ranked.to_dict("records")
    ]


def run_again(
    readings: Sequence[Reading],
    bases: Mapping[str, RunConfig],
    seeds: Sequence[int],
    *,
    folder: Path,
    jobs: int,
    say: Callable[[str], None],
) -> pd.DataFrame:
    """Run a later stage on fresh seeds, patiently; what is finished is looked up.

    Returns:
        One row per reading, see `row`.
    """
    folder.mkdir(parents=True, exist_ok=True)
    tasks = (delayed(_again)(each, dict(bases), tuple(seeds), folder) for each in readings)
    workers = Parallel(n_jobs=jobs or os.cpu_count() or 1, return_as="generator_unordered")
    rows = []
    for found in workers(tasks):
        rows.append(found)
        say(f"[{len(rows)}/{len(readings)}, {len(seeds)} seeds each] {found['reading']}: {found['score']:.3f}")
    order = {each.name: i for i, each in enumerate(readings)}
    return pd.DataFrame(sorted(rows, key=lambda each: order[str(each["reading"])]))


def _again(
    reading: Reading, bases: Mapping[str, RunConfig], seeds: tuple[int, ...], folder: Path
) -> dict[str, object]:
    path = folder / f"{reading.name}-{seeds[0]}-{len(seeds)}.json"
    if path.is_file():
        known: dict[str, object] = json.loads(path.read_text())
        return known
    found = row(try_reading(reading, bases, seeds, patient=True), bases)
    draft = path.with_suffix(f".{os.getpid()}")
    draft.write_text(json.dumps(found))
    draft.replace(path)
    return found
