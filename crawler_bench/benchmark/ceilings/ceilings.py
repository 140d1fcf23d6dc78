"""All ceilings of a benchmark: searched once, kept like a run, and certified by a command of its own."""

import hashlib
import itertools
import json
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from joblib import Parallel, delayed

from crawler_bench.benchmark.ceilings.objective import Objective, Policy
from crawler_bench.benchmark.ceilings.stochastic import evolve
from crawler_bench.benchmark.ceilings.tables import Certificate, certify, climb
from crawler_bench.config.schema import RunConfig, to_mapping
from crawler_bench.gait.metrics import policy_text
from crawler_bench.physics.compiled import KERNEL_HASH, source_hash
from crawler_bench.runs import store
from crawler_bench.runs.phases import Phase, unseen

RANDOM, TABLE, STOCHASTIC, STATE, TREE = KINDS = ("random", "table", "stochastic table", "state", "tree")
NOISE = 0.1  # s of the ceilings with noise
HORIZONS = (50, 100, 200)  # decisions that the policy on the whole state looks ahead
OPTIMISM = 1.5  # times the best table's reward: a crawl of the tree that could not win by this is cut
SEED = 2020
COLUMNS = ["regularization", "noise", "kind", "reward", "speed", "policy", "proof"]


@dataclass(frozen=True)
class Effort:
    """How hard to search.

    Attributes:
        climbs: random tables that climbs begin from.
        generations: of CMA-ES.
        most_visited: observations of the tables that the tree tries.
    """

    climbs: int
    generations: int
    most_visited: int


FULL = Effort(climbs=1000, generations=300, most_visited=5)
SMOKE = Effort(climbs=4, generations=2, most_visited=2)


def find_ceilings(
    run: RunConfig,
    regularizations: list[float],
    runs_root: Path,
    effort: Effort,
    *,
    jobs: int,
    say: Callable[[str], None],
    phase: Phase = unseen,
) -> pd.DataFrame:
    """Search for all ceilings, unless it has been done.

    Args:
        run: its parameters and evaluation are those of the benchmark.
        regularizations: epsilon.
        runs_root: folder of run folders; the ceilings are kept in it.
        effort: how hard to search.
        jobs: parallel processes; 0 is one per core.
        say: is told what is searched.
        phase: shows how far the search is.

    Returns:
        One row per regularization, noise (0 and NOISE) and kind: regularization, noise, kind, reward (L per
        decision), speed (L / tau_theta, of the same policy with epsilon 0, NaN where it was not measured),
        policy (digits or a JSON table) and proof (in words, what is known of it).
    """
    place = runs_root / f"ceilings-{_key(run, regularizations, effort)}"

    def write(draft: Path) -> None:
        started = time.monotonic()
        pairs = list(itertools.product(regularizations, (0.0, NOISE)))
        say(f"searching for ceilings: {effort.climbs} climbs for each of {len(pairs)} objectives")
        tasks = [delayed(_search)(objective_of(run, *pair), effort) for pair in pairs]
        found = _shown(tasks, jobs, phase, "searching for the best policies", "objectives")
        frame = pd.DataFrame([row for rows in found for row in rows], columns=COLUMNS)
        frame.to_csv(draft / "ceilings.csv", index=False)
        store.write_manifest(draft, started, effort=asdict(effort))

    store.make(place, write, say=say)
    return pd.read_csv(place / "ceilings.csv", dtype={"policy": str})


def objective_of(run: RunConfig, regularization: float, noise: float) -> Objective:
    """The measure of a benchmark's runs."""
    return Objective(run.parameters, run.evaluation, regularization, noise)


def certificates(ceilings: pd.DataFrame, run: RunConfig, *, jobs: int, phase: Phase = unseen) -> pd.DataFrame:
    """Certify the best tables of `find_ceilings` again.

    Returns:
        One row per regularization and noise: these, policy, worth, visited, changes, measured, best_change,
        holds.
    """
    tables = ceilings[ceilings["kind"] == TABLE].to_dict("records")
    tasks = [
        delayed(certify)(
            objective_of(run, row["regularization"], row["noise"]),
            np.array([int(digit, 36) for digit in row["policy"]]),
        )
        for row in tables
    ]
    made: list[Certificate] = _shown(tasks, jobs, phase, "certifying", "tables")
    return pd.DataFrame([
        {name: row[name] for name in ("regularization", "noise", "policy")}
        | asdict(certificate)
        | {"holds": certificate.holds}
        for row, certificate in zip(tables, made, strict=True)
    ])  # fmt: skip


def _shown(tasks: list[Any], jobs: int, phase: Phase, name: str, unit: str) -> list[Any]:
    """What the tasks return, in their order, while `phase` shows how many are done."""
    found = []
    with phase(name, len(tasks), unit) as advance:
        for each in Parallel(n_jobs=jobs or -1, return_as="generator")(tasks):
            found.append(each)
            advance(len(found))
    return found


def _search(objective: Objective, effort: Effort) -> list[tuple[Any, ...]]:
    """All ceilings of one objective, as rows of `find_ceilings`."""
    n = objective.parameters.n_segments
    uniform = np.full((n, n), 1 / n)
    climbed = climb(objective, effort.climbs, SEED)
    certificate = certify(objective, climbed.policy)
    evolved = evolve(objective, climbed.policy, effort.generations, SEED)
    table = np.eye(n)[climbed.policy]
    rows = [
        _row(objective, RANDOM, objective.of_table(uniform)[0], uniform, "every neuron equally likely"),
        _row(
            objective, TABLE, climbed.worth, table,
            f"{climbed.ended_there} of {climbed.climbs} climbs end there, the others at {climbed.ends - 1} "
            f"other worths; no change of one or two entries improves it: "
            f"{'holds' if certificate.holds else 'FAILS'} ({certificate.measured} of {certificate.changes} "
            f"measured, the best earns {certificate.best_change:.4g})",
        ),
        _row(
            objective, STOCHASTIC, evolved.worth, evolved.table,
            f"standard error {evolved.error:.1e}; {evolved.candidates} tables measured",
        ),
    ]  # fmt: skip
    if objective.noise:
        return rows
    ahead = {horizon: objective.of_lookahead(climbed.policy, horizon) for horizon in HORIZONS}
    horizon = max(ahead, key=lambda each: ahead[each])
    words = f"looks {horizon} decisions ahead along the best table"
    rows.append(_row(objective, STATE, ahead[horizon], None, words))
    rows.append(_tree_row(objective, climbed.policy, effort))
    return rows


def _tree_row(objective: Objective, policy: Policy, effort: Effort) -> tuple[Any, ...]:
    """What the tree proves from the first start."""
    alone = objective.quick(1, 1.0)
    worth = alone.of_policy(policy)[0]
    limit = OPTIMISM * max(worth, 0.0)
    best, found, (ended, given_up, cut) = alone.best_of_tree(0, effort.most_visited, limit)
    words = (
        f"from the first start, where the best table earns {worth:.3e}: no table that visits at most "
        f"{effort.most_visited} observations earns more than this, if none earns over {OPTIMISM:g} times "
        f"that in what is left of a crawl; {ended} crawls to the end, {cut} cut, {given_up} visit more"
    )
    text = "".join("-" if action < 0 else np.base_repr(action, 36).lower() for action in found)
    return (objective.regularization, objective.noise, TREE, best, np.nan, text, words)


def _row(objective: Objective, kind: str, reward: float, table: Any, proof: str) -> tuple[Any, ...]:
    speed, text = np.nan, ""
    if table is not None:
        plain = Objective(objective.parameters, objective.evaluation, 0.0, objective.noise)
        speed = plain.of_table(table)[0] / objective.parameters.decision_interval
        sure = (table.max(axis=1) == 1).all()
        text = policy_text(table) if sure else json.dumps(np.round(table, 6).tolist())
    return (objective.regularization, objective.noise, kind, reward, speed, text, proof)


def _key(run: RunConfig, regularizations: list[float], effort: Effort) -> str:
    """Ten digits that name a search: what decides it, and the sources that it runs."""
    here = Path(__file__).parent
    content = {
        "parameters": to_mapping(run)["parameters"], "evaluation": to_mapping(run)["evaluation"],
        "regularizations": regularizations, "effort": asdict(effort),
        "sources": [KERNEL_HASH, source_hash(here, here.parents[1] / "gait" / "rollout.py")],
    }  # fmt: skip
    del content["evaluation"]["mode"]
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:10]
