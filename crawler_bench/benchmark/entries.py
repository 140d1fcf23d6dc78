"""Entries of the benchmark: what an entry compares, said by its configuration, and tuned entries as files."""

import json
from collections.abc import Iterable
from pathlib import Path

import pandas as pd

from crawler_bench.benchmark.recorded import Recorded
from crawler_bench.config.files import config_folder, load_experiment
from crawler_bench.config.schema import Experiment, RunConfig, Tuning
from crawler_bench.output.csv_files import write_csv
from crawler_bench.runs import store

TUNED = "-tuned"
TRAITS = ["agent", "algorithm", "keyhole", "tuned"]


def traits(entries: Iterable[Experiment], others: Iterable[Recorded] = ()) -> pd.DataFrame:
    """What entries have in common and what not, which says who is compared with whom.

    Args:
        entries: of the benchmark.
        others: recorded runs; a learner that is not ours is an algorithm of its own.

    Returns:
        One row per entry: agent (its name), algorithm (the class it runs, in small letters without hyphens),
        keyhole, tuned (whether its name says so).
    """
    rows = [
        (
            each.name, each.run.agent.rpartition(":")[2].lower().replace("-", ""),
            each.run.environment.keyhole,
            each.name.endswith(TUNED),
        )
        for each in entries
    ]  # fmt: skip
    rows += [(each.agent, each.agent, each.config.environment.keyhole, False) for each in others]
    return pd.DataFrame(rows, columns=TRAITS).drop_duplicates("agent", ignore_index=True)


def write_search(
    tuning: Tuning,
    best: RunConfig,
    trials: pd.DataFrame,
    importance: pd.DataFrame,
    folder: Path,
    started: float,
) -> Path:
    """Write what `tuning.tune` found: trials.csv, importance.csv, and the entry, whose path is returned.

    Args:
        tuning: what was searched.
        best: the run with the best settings.
        trials: one row per trial.
        importance: one row per setting.
        folder: of these results alone.
        started: `time.monotonic()` when the search began.
    """
    entry = f"{tuning.name}{TUNED}.yaml"
    with store.replace(folder) as draft:
        write_csv(trials, draft / "trials.csv")
        write_csv(importance, draft / "importance.csv")
        (draft / entry).write_text(tuned_entry(tuning, best))
        store.write_command(draft)
        store.write_manifest(draft, started)
    return folder / entry


def tuned_entry(tuning: Tuning, best: RunConfig) -> str:
    """What a search found as the text of a file in configs/benchmark.

    Everything but the settings is that of the agent's default entry, if there is one, so that both learn from
    the same number of decisions with the same seeds; else that of the search.
    """
    path = config_folder() / "benchmark" / f"{tuning.name}.yaml"
    entry = load_experiment(path) if path.is_file() else tuning
    content = {
        "agent": best.agent, "settings": best.settings, "decisions": entry.run.decisions,
        "crawlers": entry.run.crawlers, "seeds": len(entry.seeds),
        "grid": {key: list(values) for key, values in entry.grid.items()},
    }  # fmt: skip
    if entry.run.environment.keyhole != "index":
        content["environment"] = {"keyhole": entry.run.environment.keyhole}
    lines = (f"{key}: {json.dumps(value)}\n" for key, value in content.items() if value)
    seeds = f"{min(tuning.seeds)} to {max(tuning.seeds)}"
    return (
        f"# The best of {tuning.trials} trials (results/tuning/{tuning.name}/trials.csv, `crawler-bench tune "
        f"{tuning.name}`) on the seeds {seeds}, which are not compared.\n" + "".join(lines)
    )
