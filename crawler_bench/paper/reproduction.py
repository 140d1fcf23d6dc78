"""The paper reproduced: experiments, claims, figures and films, written to results/paper/."""

import json
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from crawler_bench.config.schema import Experiment
from crawler_bench.gait import metrics
from crawler_bench.gait.record import Record
from crawler_bench.gait.rollout import rollout
from crawler_bench.output import animation, kymographs, style
from crawler_bench.output.csv_files import write_csv
from crawler_bench.paper.claims import CLAIMS, noise_crossover
from crawler_bench.paper.figure_1 import fig_1a
from crawler_bench.paper.figure_2 import learning, policies
from crawler_bench.paper.figure_3 import cycle_durations, power_by_phase, speed_against_noise
from crawler_bench.paper.figure_s1 import untrained
from crawler_bench.paper.tables import claims_table, verdict_counts
from crawler_bench.paper.verdicts import Claim, Results, judge_claims
from crawler_bench.runs import store
from crawler_bench.runs.evaluation import Evaluation, read_evaluation
from crawler_bench.runs.results import read_outcomes, typical_run
from crawler_bench.runs.sweep import Outcome, require_success, run_experiments
from crawler_bench.runs.training import agent_file

GAITS = ("regularized", "unregularized")


@dataclass(frozen=True)
class Reproduction:
    """Everything that was measured.

    Attributes:
        outcomes: one per run, failed ones too.
        runs: one row per run.
        evaluations: one row per run, noise and start.
        cycles: one row per cycle.
    """

    outcomes: list[Outcome]
    runs: pd.DataFrame
    evaluations: pd.DataFrame
    cycles: pd.DataFrame

    @property
    def failures(self) -> list[Outcome]:
        """Runs that did not finish."""
        return [outcome for outcome in self.outcomes if outcome.error]

    def claims(self, claims: tuple[Claim, ...] = CLAIMS, options: str = "") -> pd.DataFrame:
        """The claims, judged by the runs; see `judge_claims`."""
        return judge_claims(Results(self.runs, self.evaluations), claims, options)


def reproduce(experiments: Iterable[Experiment], runs_root: Path, *, jobs: int, quiet: bool) -> Reproduction:
    """Train and evaluate every run of the experiments; finished runs are looked up.

    Raises:
        RuntimeError: if no run at all succeeded.
    """
    outcomes = run_experiments(experiments, runs_root, jobs=jobs, quiet=quiet)
    require_success(outcomes)
    return Reproduction(outcomes, *read_outcomes(outcomes))


def write_results(
    found: Reproduction, folder: Path, *, options: str, say: Callable[[str], None]
) -> pd.DataFrame:
    """Write claims, runs, figures, films, trained tables and a manifest; all or nothing.

    Args:
        found: what was measured.
        folder: where to write; replaced.
        options: appended to the commands in the table of claims, to name the same preset.
        say: called with each step in words.

    Returns:
        The claims.
    """
    started = time.time()
    claims = found.claims(options=options)
    order = ["experiment", "regularization", "seed"]
    frames = {
        "claims": claims, "runs": found.runs.sort_values(order, kind="stable"),
        "evaluations": found.evaluations, "cycles": found.cycles,
    }  # fmt: skip
    with store.replace(folder) as draft:
        for name, frame in frames.items():
            write_csv(frame, draft / f"{name}.csv")
        (draft / "claims.md").write_text(f"{verdict_counts(claims)}\n\n{claims_table(claims)}\n")
        _write_policies(found, draft / "policies")
        say("drawing the figures")
        for name, figure in _figures(found).items():
            style.save(figure, draft, name)
        for gait in GAITS:
            say(f"filming the {gait} gait")
            record = representative(found, gait)[1].gait
            for suffix in (".gif", ".mp4"):
                animation.animate(record, draft / f"{gait}{suffix}", f"{gait.capitalize()} gait")
        store.write_command(draft)
        names = [outcome.folder.name for outcome in found.outcomes if outcome.folder]
        store.write_manifest(draft, started, runs=names)
    return claims


def _write_policies(found: Reproduction, folder: Path) -> None:
    """Copy the trained tables, without what only a resumed training needs."""
    folder.mkdir()
    for outcome in found.outcomes:
        if outcome.folder is not None and outcome.cell.experiment in GAITS:
            content = json.loads(agent_file(outcome.folder).read_text())
            for key in ("generators", "environment", "observation"):
                content.pop(key, None)
            name = f"{outcome.cell.experiment}-seed{outcome.cell.seed:02d}.json"
            (folder / name).write_text(json.dumps(content, indent=1) + "\n")


def representative(found: Reproduction, experiment: str) -> tuple[Outcome, Evaluation]:
    """The run to show for an experiment."""
    outcome = typical_run(found.runs, [each for each in found.outcomes if each.cell.experiment == experiment])
    assert outcome.evaluation is not None
    return outcome, read_evaluation(outcome.evaluation)


def _figures(found: Reproduction) -> dict[str, Figure]:
    """All figures by file name."""
    shown = {gait: representative(found, gait) for gait in GAITS}
    gaits = {gait: evaluation.gait for gait, (_, evaluation) in shown.items()}
    phased = {
        gait: metrics.power_by_phase(record, metrics.wave(record).boundaries)
        for gait, record in gaits.items()
    }
    crossing, _ = noise_crossover(Results(found.runs, found.evaluations))
    snapshots = {gait: _snapshots(outcome) for gait, (outcome, _) in shown.items()}
    run = {gait: _name_run(*each) for gait, each in shown.items()}
    return {
        "fig_1a": fig_1a(),
        "fig_2a": kymographs.gait(gaits["regularized"], f"Fig. 2A. Regularized, {run['regularized']}"),
        "fig_2b": kymographs.gait(gaits["unregularized"], f"Fig. 2B. Unregularized, {run['unregularized']}"),
        "fig_2c": policies(
            {gait: evaluation.table for gait, (_, evaluation) in shown.items()},
            {gait: metrics.visited_observations(record) for gait, record in gaits.items()},
        ),
        "fig_3a": power_by_phase(phased),
        "fig_3b": cycle_durations(found.cycles[found.cycles["experiment"].isin(GAITS)]),
        "fig_3c": speed_against_noise(
            found.evaluations[found.evaluations["experiment"].isin((*GAITS, "untrained"))],
            (crossing.value, crossing.low, crossing.high),
        ),
        "fig_s1": untrained(_untrained_record(found)),
        "fig_learning": learning(snapshots, _distances(found)),
    }  # fmt: skip


def _name_run(outcome: Outcome, evaluation: Evaluation) -> str:
    """Which run is shown, in words: its regularization, seed and policy."""
    epsilon, seed = outcome.cell.config.environment.regularization, outcome.cell.seed
    policy = metrics.policy_text(evaluation.table)
    return f"ε = {epsilon:g} (a typical run: seed {seed}, policy {policy})"


def _untrained_record(found: Reproduction) -> Record:
    """The untrained crawler from the undeformed body: all actions equally likely."""
    cell = next(outcome.cell for outcome in found.outcomes if outcome.cell.experiment == "untrained")
    n = cell.config.parameters.n_segments
    table = np.full((n, n), 1 / n)
    return rollout(cell.config.parameters, table, warm_up=0, duration=120, noise=0, start=(cell.seed,))


def _snapshots(outcome: Outcome) -> tuple[np.ndarray, np.ndarray]:
    assert outcome.folder is not None
    with np.load(outcome.folder / "snapshots.npz") as arrays:
        return arrays["decisions"], arrays["q_table"]


def _distances(found: Reproduction) -> pd.DataFrame:
    """Distance of the greedy policy to nearest-neighbour wiring through every run."""
    frames = []
    for outcome in found.outcomes:
        if outcome.folder is not None and outcome.cell.experiment in GAITS:
            decisions, q = _snapshots(outcome)
            distance = [metrics.diagonal_distance(table.argmax(axis=1)) for table in q]
            key = {"experiment": outcome.cell.experiment, "seed": outcome.cell.seed}
            frames.append(pd.DataFrame(key | {"decisions": decisions, "diagonal_distance": distance}))
    return pd.concat(frames, ignore_index=True)
