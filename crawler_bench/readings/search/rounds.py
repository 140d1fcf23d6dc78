"""Search the joint space of readings for one that tells the paper's story with few constants of our own.

1. *Trials*: Optuna's TPE proposes readings, for two objectives: the distance to the paper, which is the score
   plus the mean distance of the core claims and of a wave put in by hand, so that hopeless trials show a way
   out, too; and the number of free constants. Most trials are drawn at random instead, so that the
   map of what can be had is not only of where the sampler went; most of them are hopeless and end early, see
   `trial.py`.
2. *Again*: the nearest trials for each number of free constants, one number after the other, on seeds that
   no trial has seen. Not the trials within tolerance first: a few seeds flatter many readings, and those with
   the fewest constants would take every place.
3. *Finals*: the best of those, on more seeds that nothing has seen. Shares of runs are known well there, so a
   core claim has to be reproduced by its verdict, not only to be within one tolerance, and so have the three
   numbers that the paper gives for its gait; and random action may be at most SCALE times as fast as the
   regularized gait, or a benchmark would have no scale.

The default is the first of the finalists that pass, by free constants and then by score. Where none passes,
the nearest do: those with the fewest failures. What stage 1 found is biased, because it was chosen for being
good on its seeds; stages 2 and 3 are not.
"""

import json
import os
import time
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import optuna
import pandas as pd
from joblib import Parallel, delayed
from optuna.storages import JournalStorage
from optuna.storages.journal import JournalFileBackend

from crawler_bench.config.schema import RunConfig
from crawler_bench.paper.claims import find_claim
from crawler_bench.paper.verdicts import Verdict, judge
from crawler_bench.readings.catalogue import Reading
from crawler_bench.readings.laboratory import REGULARIZED, UNREGULARIZED
from crawler_bench.readings.scoring import CAP, CORE, NUMBER_TOLERANCE, PRINTED, SCALE
from crawler_bench.readings.search.space import draw, proposal
from crawler_bench.readings.search.trial import UNTRAINED, Trial, try_reading
from crawler_bench.runs.phases import Phase, unseen
from crawler_bench.statistics.estimates import Estimate

STUDY = "readings"
STARTUP = 100  # trials drawn at random before the sampler learns from what it saw
INFORMED = 10  # one trial of this number is proposed by the sampler, the others are drawn at random
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
    phase: Phase = unseen,
) -> pd.DataFrame:
    """Run the first stage, or what is left of it.

    Args:
        bases: the run of the default reading for each experiment.
        journal: file that keeps the trials.
        first: readings to begin with.
        seeds: of every trial.
        trials: how many.
        jobs: parallel processes; 0 is one per core.
        say: told what was found.
        phase: shows how far it is.

    Returns:
        One row per trial, see `finished`.
    """
    journal.parent.mkdir(parents=True, exist_ok=True)
    if not journal.exists():
        study = _study(journal, 0)
        for reading in first:
            study.enqueue_trial(proposal(reading))
    done = len(finished(journal))
    tasks = (delayed(_work)(journal, dict(bases), tuple(seeds), number) for number in range(done, trials))
    nearest = float("inf")
    workers: Any = Parallel(n_jobs=jobs or os.cpu_count() or 1, return_as="generator_unordered")
    if done < trials:
        with phase("trials", trials, "") as advance:
            advance(done)
            for distance in workers(tasks):
                done, nearest = done + 1, min(nearest, distance)
                advance(done)
        say(f"{done} trials; the nearest since this command began: {nearest:.3f}")
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


@cache
def _opened(journal: Path, process: int) -> optuna.Study:
    """The study, read once by each process."""
    return _study(journal, process)


def _work(journal: Path, bases: Mapping[str, RunConfig], seeds: tuple[int, ...], number: int) -> float:
    """Ask for, run and tell one trial that the model does not refuse; returns its distance."""
    study = _opened(journal, os.getpid())
    informed = study.sampler
    while True:
        if number % INFORMED:
            study.sampler = optuna.samplers.RandomSampler(seed=_SEED + number)
        asked = study.ask()
        reading = Reading(f"trial-{asked.number:04d}", "search", draw(asked))
        study.sampler = informed
        try:
            found = row(try_reading(reading, bases, seeds), bases)
        except ValueError as error:
            asked.set_user_attr("refused", str(error))
            study.tell(asked, state=optuna.trial.TrialState.FAIL)
            number += 1
            continue
        asked.set_user_attr("row", json.dumps(found))
        study.tell(asked, (found["distance"], found["free"]))
        return float(found["distance"])


def finished(journal: Path) -> pd.DataFrame:
    """One row per finished trial, in order: what `row` keeps, and the seconds of a core that it took."""
    states = (optuna.trial.TrialState.COMPLETE,)
    done = _study(journal, 0).get_trials(deepcopy=False, states=states)
    rows = []
    for each in done:
        assert each.duration is not None  # it is complete
        rows.append(json.loads(each.user_attrs["row"]) | {"seconds": each.duration.total_seconds()})
    return pd.DataFrame(rows)


def row(trial: Trial, bases: Mapping[str, RunConfig]) -> dict[str, Any]:
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

    gait, untaught = mean(regularized, "speed"), mean(untrained, "speed")
    ratio = untaught / gait if untaught is not None and gait else None

    def known(claim: str) -> float | None:
        value = float(claims[claim])
        return value if value == value else None

    return {
        "reading": trial.reading.name,
        "score": trial.score.value,
        "distance": trial.score.value + _core_distance(trial, ratio) + CAP * trial.wave_off,
        "free": len(free),
        "free_constants": " ".join(free),
        "within": trial.score.within and not trial.stopped,
        "core_failures": " ".join(trial.score.core_failures),
        "failures": " ".join(_failures(trial, ratio)),
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
        "random_ratio": ratio,
    }


def _core_distance(trial: Trial, ratio: float | None) -> float:
    """Mean distance of the core claims, and of random action from SCALE."""
    distances = trial.score.claims.set_index("claim")["distance"][list(CORE)].tolist()
    excess = CAP if ratio is None else min(max(0.0, ratio / SCALE - 1) / NUMBER_TOLERANCE, CAP)
    return float(np.mean([*distances, excess]))


def _failures(trial: Trial, ratio: float | None) -> list[str]:
    """What a finalist fails by: claims that are not reproduced, and random action that is too fast."""
    failed = []
    for each in trial.score.claims.to_dict("records"):
        ours = Estimate(each["ours"], each["low"], each["high"], each["n"])
        if (
            each["claim"] in (*CORE, *PRINTED)
            and judge(find_claim(each["claim"]), ours) is not Verdict.REPRODUCED
        ):
            failed.append(str(each["claim"]))
    return failed if ratio is not None and ratio <= SCALE else [*failed, "random_ratio"]


def best(trials: pd.DataFrame, number: int) -> list[Reading]:
    """The nearest for each number of free constants, then the second nearest for each, and so on."""
    completed = trials[trials["stopped"] == ""]
    if completed.empty:  # few trials, all hopeless: the nearest of these
        completed = trials
    completed = completed.drop_duplicates("changes").sort_values("distance", kind="stable")
    place = completed.groupby("free").cumcount()
    ordered = completed.assign(place=place).sort_values(["place", "free"], kind="stable")
    return [
        Reading(str(each["reading"]), "search", json.loads(str(each["changes"])))
        for each in ordered.head(number).to_dict("records")
    ]


def ordered_finals(finals: pd.DataFrame) -> pd.DataFrame:
    """The finalists by the rule: fewest failures, then fewest free constants, then the lower score."""
    keyed = finals.assign(failed=[len(str(each).split()) for each in finals["failures"]])
    return keyed.sort_values(["failed", "free", "score"], kind="stable", ignore_index=True)


def run_again(
    readings: Sequence[Reading],
    bases: Mapping[str, RunConfig],
    seeds: Sequence[int],
    *,
    folder: Path,
    jobs: int,
    say: Callable[[str], None],
    phase: Phase = unseen,
    least: float = 0.0,
) -> pd.DataFrame:
    """Run a later stage on fresh seeds; what is finished is looked up.

    Args:
        readings: what to run.
        bases: the run of the default reading for each experiment.
        seeds: of every reading.
        folder: that keeps what is finished.
        jobs: parallel processes; 0 is one per core.
        say: told what was found.
        phase: shows how far it is.
        least: share of the regularized runs that has to find the wiring for the other gaits to be run.

    Returns:
        One row per reading: what `row` keeps, and the seconds of a core that it took.
    """
    folder.mkdir(parents=True, exist_ok=True)
    tasks = (delayed(_again)(each, dict(bases), tuple(seeds), folder, least) for each in readings)
    rows: list[dict[str, Any]] = []
    workers: Any = Parallel(n_jobs=jobs or os.cpu_count() or 1, return_as="generator_unordered")
    with phase("readings on fresh seeds", len(readings), "") as advance:
        for found in workers(tasks):
            rows.append(found)
            advance(len(rows))
            done = f"[{len(rows)}/{len(readings)}, {len(seeds)} seeds each]"
            failures = found["failures"] or "nothing"
            say(f"{done} {found['reading']}: score {found['score']:.3f}, fails {failures}")
    return pd.DataFrame(rows).set_index("reading").loc[[each.name for each in readings]].reset_index()


def _again(
    reading: Reading, bases: Mapping[str, RunConfig], seeds: tuple[int, ...], folder: Path, least: float
) -> dict[str, Any]:
    path = folder / f"{reading.name}-{seeds[0]}-{len(seeds)}.json"
    if path.is_file():
        known: dict[str, Any] = json.loads(path.read_text())
        return known
    began = time.process_time()
    fewest, all_seeds = ((len(seeds), least),), len(seeds)
    trial = try_reading(reading, bases, seeds, fewest=fewest, paired=all_seeds, patient=not least)
    found = row(trial, bases) | {"seconds": time.process_time() - began}
    draft = path.with_suffix(f".{os.getpid()}")
    draft.write_text(json.dumps(found))
    draft.replace(path)
    return found
