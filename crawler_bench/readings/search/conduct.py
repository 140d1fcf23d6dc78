"""The whole search, stage by stage, and its results folder; see search/rounds.py for the rule."""

import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from crawler_bench.config.schema import RunConfig
from crawler_bench.output.csv_files import write_csv
from crawler_bench.output.style import save
from crawler_bench.readings.catalogue import FORMER, Reading
from crawler_bench.readings.search.figures import front, trapping
from crawler_bench.readings.search.freeing import freeing
from crawler_bench.readings.search.holding import FURTHER, holding
from crawler_bench.readings.search.leads import LEADS
from crawler_bench.readings.search.off_diagonal import off_diagonal
from crawler_bench.readings.search.rounds import best, ordered_finals, run_again, run_trials
from crawler_bench.readings.sizes import Size
from crawler_bench.runs import store
from crawler_bench.runs.phases import Phase, unseen

LEAST = 0.7  # share of the runs that has to find the wiring for a reading to be measured whole again
STAGES = ("trials", "again", "finals")


def search(
    bases: Mapping[str, RunConfig],
    size: Size,
    *,
    scratch: Path,
    folder: Path,
    jobs: int,
    say: Callable[[str], None],
    phase: Phase = unseen,
) -> pd.DataFrame:
    """Run the search, or what is left of it, and write what it found.

    Args:
        bases: the run of the default reading for each experiment.
        size: how much is run.
        scratch: folder that keeps finished trials; the same one goes on.
        folder: of the results.
        jobs: parallel processes; 0 is one per core.
        say: told what was found.
        phase: shows how far each part is.

    Returns:
        One row per finalist, the one that the rule chooses first.
    """
    started = time.monotonic()
    trial_seeds, again_seeds, final_seeds = size.search_seeds
    say(f"{size.trials} trials of {len(trial_seeds)} seeds; what is finished is in {scratch}")
    trials = run_trials(
        bases,
        scratch / "journal.log",
        first=LEADS,
        seeds=trial_seeds,
        trials=size.trials,
        jobs=jobs,
        say=say,
        phase=phase,
    )
    say(f"the best {size.again} again on {len(again_seeds)} fresh seeds")
    readings = best(trials, size.again)
    later: Any = {"folder": scratch, "jobs": jobs, "say": say, "phase": phase}
    again = run_again(readings, bases, again_seeds, least=LEAST, **later)
    say(f"the best {size.finals} of these, and the former default, on {len(final_seeds)} fresh seeds")
    finalists = [*_first(again, size.finals), FORMER]
    finals = ordered_finals(run_again(finalists, bases, final_seeds, **later))
    chosen = {each.name: each for each in finalists}[str(finals["reading"].iloc[0])]
    say(f"the rule chooses {chosen.name}")
    with store.replace(folder) as draft:
        for name, frame in zip(STAGES, (trials, again, finals), strict=True):
            write_csv(frame, draft / f"{name}.csv")
        say("looking into the runs of it that end off the diagonal")
        write_csv(off_diagonal(chosen, bases, final_seeds, phase), draft / "off_diagonal.csv")
        say("changing one field of it at a time, to see which frees a trapped learner")
        write_csv(freeing(chosen, bases, again_seeds[:FURTHER], jobs, phase), draft / "freeing.csv")
        say("trying it with other integrators, at another interval, on further seeds")
        write_csv(holding(chosen, bases, again_seeds[:FURTHER], jobs, phase), draft / "holding.csv")
        save(front(trials, finals), draft, "front")
        save(trapping(trials, again, finals), draft, "trapping")
        store.write_command(draft)
        hours = (
            sum(frame.get("seconds", pd.Series(dtype=float)).sum() for frame in (trials, again, finals))
            / 3600
        )
        store.write_manifest(draft, started, seeds=size.search_seeds, core_hours=round(hours, 2))
    say(f"all {len(trials) + len(again) + len(finals)} trials took {hours:.2g} hours of one core")
    return finals


def _first(again: pd.DataFrame, number: int) -> list[Reading]:
    """The first by the rule of the finals."""
    by_name = {each.name: each for each in best(again, len(again))}
    return [by_name[name] for name in ordered_finals(again)["reading"] if name in by_name][:number]
