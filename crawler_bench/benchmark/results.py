"""Write results/benchmark/: tidy CSVs, tables, figures, trained policies, and what it all cost."""

import itertools
import json
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from crawler_bench.benchmark.benchmark import Benchmark
from crawler_bench.benchmark.cell_hash import Hasher
from crawler_bench.benchmark.figures import curves, policies, scores
from crawler_bench.benchmark.keys import RUN, action_columns
from crawler_bench.benchmark.pairwise import compare
from crawler_bench.benchmark.summary import summarize_benchmark
from crawler_bench.benchmark.tables import cost_sentence, write_tables
from crawler_bench.benchmark.temperature import speed_against_temperature
from crawler_bench.benchmark.traps import absorptions, escapes, stuck_observations, traps
from crawler_bench.config.schema import Experiment, to_yaml
from crawler_bench.gait.record import Record
from crawler_bench.output import style
from crawler_bench.output.csv_files import read_csv, rounded, write_csv
from crawler_bench.runs import store
from crawler_bench.runs.evaluation import read_evaluation
from crawler_bench.runs.policy_files import Policy, write_policy
from crawler_bench.runs.results import typical_run
from crawler_bench.runs.sweep import Outcome
from crawler_bench.runs.training import agent_file
from crawler_bench.statistics.estimates import Array

EXPLAINED_STARTS = 4
EVALUATED = [*RUN, "noise", "start", "speed", "reward", "stalled"]  # what evaluations.csv keeps of a start


def write_benchmark(
    found: Benchmark, entries: Sequence[Experiment], folder: Path, *, say: Callable[[str], None]
) -> str:
    """Write everything, all or nothing.

    Args:
        found: what was measured.
        entries: what was run.
        folder: where to.
        say: told what is being made.

    Returns:
        A sentence about what it cost.
    """
    with store.replace(folder) as draft:
        started = time.time()
        hasher = Hasher({entry.name: entry for entry in entries})
        say("measuring what softer and harder policies do")
        explained, shares = _explain(found, entries)
        frames = _frames(found, hasher) | explained
        for name, frame in frames.items():
            write_csv(frame, draft / f"{name}.csv")
        (draft / "tables").mkdir()
        write_tables(frames["summary"], frames["pairs"], frames["runs"], draft / "tables")
        _write_entries(entries, draft / "entries")
        shown = _representatives(found)
        _write_policies(found, shown, draft / "policies")
        say("drawing the figures")
        for name, figure in _figures(found, explained, shares, shown).items():
            style.save(figure, draft, name)
        cost = _cost(found)
        store.write_command(draft)
        store.write_manifest(draft, started, cost=cost)
    return cost_sentence(cost)


def overview(folder: Path) -> pd.DataFrame:
    """The main numbers, a row an agent, mode and regularization, from the CSV."""
    summary = read_csv(folder / "summary.csv")
    chosen = summary[summary["metric"].isin(["speed", "cycle_duration", "noise_area", "stall_share"])]
    key = ["agent", "mode", "regularization"]
    wide = chosen.pivot_table(index=key, columns="metric", values="value").reset_index()
    return wide.merge(chosen[chosen["metric"] == "speed"][[*key, "n"]], on=key)


def _frames(found: Benchmark, hasher: Hasher) -> dict[str, pd.DataFrame]:
    runs = found.runs.assign(
        hash=[hasher.of_run(*row) for row in found.runs[RUN].itertuples(index=False, name=None)]
    )
    # Summed up from what the CSVs hold, so that anyone who reads them gets the same to the last digit.
    runs, evaluations, curves = (
        rounded(frame) for frame in (runs, found.evaluations[EVALUATED], found.curves)
    )
    frames = {
        "runs": runs,
        "evaluations": evaluations,
        "cycles": found.cycles,
        "policy_tables": found.tables,
        "curves": curves,
        "summary": summarize_benchmark(runs, evaluations, curves, hasher),
        "pairs": compare(runs, evaluations),
    }
    if found.failures:
        frames["failures"] = pd.DataFrame([
            {
                "agent": each.cell.experiment,
                "regularization": each.cell.config.environment.regularization,
                "seed": each.cell.seed,
                "error": each.error,
                "log": each.log,
            }
            for each in found.failures
        ])  # fmt: skip
    return frames


def _write_entries(entries: Sequence[Experiment], folder: Path) -> None:
    """Every entry with all its defaults, as `reproduce-cell` and `benchmark --agent` read it."""
    folder.mkdir()
    for entry in entries:
        own = {"seeds": list(entry.seeds), "grid": {key: list(values) for key, values in entry.grid.items()}}
        text = "".join(f"{key}: {json.dumps(value)}\n" for key, value in own.items())
        (folder / f"{entry.name}.yaml").write_text(text + to_yaml(entry.run))


Key = tuple[str, str, float]  # agent, mode, regularization


def _representatives(found: Benchmark) -> dict[Key, Outcome]:
    """The run to show for every agent, mode and regularization."""
    shown = {}
    groups: Any = found.runs.groupby(["agent", "mode", "regularization"])
    for (agent, mode, regularization), rows in groups:
        candidates = [
            each
            for each in itertools.chain(*found.outcomes.values())
            if (each.cell.experiment, each.cell.config.environment.regularization) == (agent, regularization)
            and _is_mode(found, agent, mode, each)
        ]
        shown[agent, mode, regularization] = typical_run(rows, candidates)
    return shown


def _is_mode(found: Benchmark, agent: str, mode: str, outcome: Outcome) -> bool:
    """Whether an outcome was evaluated in a mode; an agent with one table has one mode, whatever its name."""
    return found.runs.loc[found.runs["agent"] == agent, "mode"].nunique() == 1 or (
        outcome.cell.config.evaluation.mode == mode
    )


def _write_policies(found: Benchmark, shown: dict[Key, Outcome], folder: Path) -> None:
    """The run to show for every agent and regularization, with its tables in all modes."""
    folder.mkdir()
    probabilities = action_columns(found.tables)
    written = set()
    for (agent, _, regularization), outcome in shown.items():
        if (agent, regularization) in written or outcome.folder is None:
            continue
        written.add((agent, regularization))
        seed = outcome.cell.seed
        rows = found.tables[
            (found.tables["agent"] == agent)
            & (found.tables["regularization"] == regularization)
            & (found.tables["seed"] == seed)
        ].sort_values("observation")
        by_mode = {str(mode): part[probabilities].to_numpy(float) for mode, part in rows.groupby("mode")}
        policy = Policy(outcome.cell.config, seed, by_mode)
        path = folder / f"{agent}-eps{regularization:g}-seed{seed:02d}.json"
        write_policy(policy, path, agent_file(outcome.folder))


def _explain(found: Benchmark, entries: Sequence[Experiment]) -> tuple[dict[str, pd.DataFrame], Array]:
    """Why policies stand still: speed of each policy made softer and harder, and its traps, as frames.

    The crawler is that of the first entry; the starts are a few of the evaluation's.
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
    found: Benchmark, explained: dict[str, pd.DataFrame], shares: Array, shown: dict[Key, Outcome]
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
        "softening": curves.softening(explained["softening"], explained["stuck"], agents),
        "traps": policies.trap_matrix(shares),
    }


def _cost(found: Benchmark) -> dict[str, dict[str, float]]:
    """Runs of each agent, and seconds of one core that training and evaluating one took on average."""
    seconds: dict[str, dict[str, dict[Path, float]]] = {}
    for outcome in (each for outcomes in found.outcomes.values() for each in outcomes):
        if outcome.folder is None or outcome.evaluation is None:
            continue
        mine = seconds.setdefault(outcome.cell.experiment, {"training": {}, "evaluation": {}})
        for part, place in (("training", outcome.folder), ("evaluation", outcome.evaluation)):
            manifest = json.loads((place / store.MANIFEST).read_text())
            mine[part][place] = float(manifest["wall_clock_seconds"])
    cost: dict[str, dict[str, float]] = {}
    for agent, parts in seconds.items():
        runs = len(parts["training"])
        cost[agent] = {"runs": runs} | {
            part: round(sum(each.values()) / runs, 2) for part, each in parts.items()
        }
    return cost
