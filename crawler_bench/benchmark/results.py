"""Write results/benchmark/: tidy CSVs, tables, figures, trained policies, and the cost of all runs."""

import itertools
import json
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from crawler_bench.benchmark.benchmark import Benchmark, learner_of
from crawler_bench.benchmark.ceilings.ceilings import COLUMNS
from crawler_bench.benchmark.cell_hash import Hasher
from crawler_bench.benchmark.entries import traits
from crawler_bench.benchmark.figures import curves, keyholes, policies, scores
from crawler_bench.benchmark.keyholes import keyhole_worth, profiles
from crawler_bench.benchmark.keys import GROUP, LEARNER, RUN, Group, action_columns, select
from crawler_bench.benchmark.pairwise import compare
from crawler_bench.benchmark.recorded import Recorded
from crawler_bench.benchmark.summary import measure_runs, summarize_benchmark
from crawler_bench.benchmark.tables import cost_sentence, write_tables
from crawler_bench.benchmark.temperature import speed_against_temperature
from crawler_bench.benchmark.traps import absorptions, escapes, stuck_observations, traps
from crawler_bench.config.schema import Experiment, to_yaml
from crawler_bench.gait.record import Record
from crawler_bench.output import style
from crawler_bench.output.csv_files import read_csv, rounded, write_csv
from crawler_bench.runs import store
from crawler_bench.runs.evaluation import read_evaluation
from crawler_bench.runs.policies.files import Policy, write_policy
from crawler_bench.runs.results import typical_run
from crawler_bench.runs.sweep import Outcome
from crawler_bench.runs.training import agent_file
from crawler_bench.statistics.estimates import Array

EXPLAINED_STARTS = 4
EVALUATED = [*RUN, "noise", "start", "speed", "reward", "stalled"]  # columns of evaluations.csv


def write_benchmark(
    found: Benchmark,
    entries: Sequence[Experiment],
    folder: Path,
    *,
    say: Callable[[str], None],
    ceilings: pd.DataFrame | None = None,
    others: Sequence[Recorded] = (),
) -> str:
    """Write everything, all or nothing.

    Args:
        found: what was measured.
        entries: what was run.
        folder: where to write; replaced.
        say: called with each step in words.
        ceilings: of `ceilings.find_ceilings`; without them nothing is measured against a ceiling.
        others: recorded runs, which `found` holds already.

    Returns:
        One sentence: what all runs cost.
    """
    with store.replace(folder) as draft:
        started = time.monotonic()
        hasher = Hasher({entry.name: entry for entry in entries})
        say("measuring traps, and speed against the temperature of a policy")
        explained, shares = _explain(found, entries)
        known = pd.DataFrame(columns=COLUMNS) if ceilings is None else rounded(ceilings)
        frames = _frames(found, hasher, traits(entries, others), known) | explained
        for name, frame in frames.items():
            write_csv(frame, draft / f"{name}.csv")
        (draft / "tables").mkdir()
        write_tables(frames["summary"], frames["pairs"], frames["runs"], draft / "tables")
        _write_entries(entries, draft / "entries")
        shown = _representatives(found)
        _write_policies(found, shown, draft / "policies")
        say("drawing the figures")
        for name, figure in _figures(found, frames, shares, shown).items():
            style.save(figure, draft, name)
        cost = _cost(found)
        store.write_command(draft)
        store.write_manifest(draft, started, cost=cost)
    return cost_sentence(cost)


def overview(folder: Path) -> pd.DataFrame:
    """The main numbers, one row per agent, mode and regularization, from the CSV."""
    summary = read_csv(folder / "summary.csv")
    chosen = summary[summary["metric"].isin(["speed", "cycle_duration", "noise_area", "stall_share"])]
    wide = chosen.pivot_table(index=GROUP, columns="metric", values="value").reset_index()
    return wide.merge(select(chosen, metric="speed")[[*GROUP, "n"]], on=GROUP)


def _frames(
    found: Benchmark, hasher: Hasher, entries: pd.DataFrame, ceilings: pd.DataFrame
) -> dict[str, pd.DataFrame]:
    runs = found.runs.assign(
        hash=[hasher.of_run(*row) for row in found.runs[RUN].itertuples(index=False, name=None)]
    )
    # Summarized from what the CSVs hold, so that anyone who reads them gets the same to the last digit.
    runs, evaluations, curves = (
        rounded(frame) for frame in (runs, found.evaluations[EVALUATED], found.curves)
    )
    frames = {
        "runs": runs,
        "evaluations": evaluations,
        "cycles": found.cycles,
        "policy_tables": found.tables,
        "curves": curves,
        "summary": summarize_benchmark(runs, evaluations, curves, hasher, ceilings),
        "pairs": compare(runs, evaluations, entries),
        "profiles": profiles(measure_runs(runs, evaluations, curves, ceilings)),
        "ceilings": ceilings,
    }
    frames["keyholes"] = keyhole_worth(frames["summary"], entries)
    if found.failures:
        failed = [(*learner_of(each), each.error, each.log) for each in found.failures]
        frames["failures"] = pd.DataFrame(failed, columns=[*LEARNER, "error", "log"])
    return frames


def _write_entries(entries: Sequence[Experiment], folder: Path) -> None:
    """Write every entry with all its defaults, as `reproduce-cell` and `benchmark --agent` read it."""
    folder.mkdir()
    for entry in entries:
        own = {"seeds": list(entry.seeds), "grid": {key: list(values) for key, values in entry.grid.items()}}
        text = "".join(f"{key}: {json.dumps(value)}\n" for key, value in own.items())
        (folder / f"{entry.name}.yaml").write_text(text + to_yaml(entry.run))


def _representatives(found: Benchmark) -> dict[Group, Outcome]:
    """The run to show for every agent, mode and regularization."""
    shown = {}
    groups: Any = found.runs.groupby(GROUP)
    for (agent, mode, regularization), rows in groups:
        candidates = [
            each
            for each in itertools.chain(*found.outcomes.values())
            if (each.cell.experiment, each.cell.config.environment.regularization) == (agent, regularization)
            and _is_mode(found, agent, mode, each)
        ]
        if candidates:  # a recorded run has no agent to show
            shown[agent, mode, regularization] = typical_run(rows, candidates)
    return shown


def _is_mode(found: Benchmark, agent: str, mode: str, outcome: Outcome) -> bool:
    """Whether an outcome was evaluated in a mode; an agent with one table has one mode, whatever its name."""
    one_mode = select(found.runs, agent=agent)["mode"].nunique() == 1
    return one_mode or outcome.cell.config.evaluation.mode == mode


def _write_policies(found: Benchmark, shown: dict[Group, Outcome], folder: Path) -> None:
    """Write the run to show for every agent and regularization, with its tables in all modes."""
    folder.mkdir()
    probabilities = action_columns(found.tables)
    written = set()
    for (agent, _, regularization), outcome in shown.items():
        if (agent, regularization) in written or outcome.folder is None:
            continue
        written.add((agent, regularization))
        seed = outcome.cell.seed
        rows = select(found.tables, agent=agent, regularization=regularization, seed=seed)
        if rows.empty:  # no table: its archive alone would not say in which keyhole, or with what memory
            continue
        rows = rows.sort_values("observation")
        by_mode = {str(mode): part[probabilities].to_numpy(float) for mode, part in rows.groupby("mode")}
        policy = Policy(outcome.cell.config, seed, by_mode)
        path = folder / f"{agent}-eps{regularization:g}-seed{seed:02d}.json"
        write_policy(policy, path, agent_file(outcome.folder))


def _explain(found: Benchmark, entries: Sequence[Experiment]) -> tuple[dict[str, pd.DataFrame], Array]:
    """Why policies stand still: their speed against temperature, and their traps.

    The crawler is that of the first entry, the starts are the first EXPLAINED_STARTS of the evaluation.

    Returns:
        Frames by name of their CSV, and the (N, N) map of `traps`.
    """
    run = entries[0].run
    few = run.evaluation.model_copy(update={"starts": min(run.evaluation.starts, EXPLAINED_STARTS)})
    shares = traps(run.parameters, few)
    ends = absorptions(found.tables, run.parameters, few)
    frames = {
        "softening": speed_against_temperature(found.tables, run.parameters, few),
        "stuck": stuck_observations(found.tables, shares),
        "absorptions": ends,
        "escapes": escapes(ends, found.tables, run.parameters, few),
    }
    return frames, shares


def _figures(
    found: Benchmark, frames: dict[str, pd.DataFrame], shares: Array, shown: dict[Group, Outcome]
) -> dict[str, Figure]:
    """All figures by file name."""
    gaits: dict[str, Record] = {}
    for (agent, mode, regularization), outcome in shown.items():
        if regularization == max(key[2] for key in shown) and outcome.evaluation is not None:
            gaits[f"{agent}, {mode}"] = read_evaluation(outcome.evaluation).gait
    agents = list(dict.fromkeys(found.runs["agent"]))  # so that each keeps its colour in every figure
    return {
        "speeds": scores.speeds(found.runs),
        "cycle_durations": scores.cycle_durations(found.cycles, found.runs),
        "noise": curves.noise_curves(found.evaluations),
        "learning_curves": curves.learning_curves(found.curves, found.runs, agents),
        "policies": policies.policy_matrices(found.tables, found.runs),
        "gaits": policies.gaits(gaits),
        "softening": curves.softening(frames["softening"], frames["stuck"], agents),
        "traps": policies.trap_matrix(shares),
        "keyholes": keyholes.worth(frames["keyholes"], frames["ceilings"]),
        "profiles": keyholes.profiles(frames["profiles"], agents),
    }


def _cost(found: Benchmark) -> dict[str, dict[str, float]]:
    """Runs of each agent, and mean seconds of one core to train one and to evaluate one."""
    seconds: dict[str, dict[str, dict[Path, float]]] = {}
    for outcome in (each for outcomes in found.outcomes.values() for each in outcomes):
        if outcome.folder is None or outcome.evaluation is None:
            continue
        mine = seconds.setdefault(outcome.cell.experiment, {"training": {}, "evaluation": {}})
        for part, place in (("training", outcome.folder), ("evaluation", outcome.evaluation)):
            manifest = json.loads((place / store.MANIFEST).read_text())
            mine[part][place] = float(manifest["wall_clock_seconds"])
    return {
        agent: {"runs": (runs := len(parts["training"]))}
        | {part: round(sum(each.values()) / runs, 2) for part, each in parts.items()}
        for agent, parts in seconds.items()
    }
