"""The policies that ship with the package: the paper's two gaits, and the best of every agent that learns.

They are taken from results/, never typed in. When `crawler-bench reproduce` or `benchmark` has changed it:

    python -m crawler_bench.report.policies

A policy that does not crawl as fast as the results say is refused: then they are older than the code.
"""

import json
import math
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from crawler_bench.config.files import config_folder, load_experiment
from crawler_bench.config.schema import override
from crawler_bench.gait.metrics import policy_text
from crawler_bench.runs.evaluation import measure
from crawler_bench.runs.policies.files import Policy, read_policy, write_policy
from crawler_bench.runs.results import typical_row

SHIPPED = Path(__file__).resolve().parents[1] / "policies"
GAITS = ("regularized", "unregularized")
SAME_SPEED = 1e-3  # relative difference that other machines and roundings explain


def collect(results: Path) -> dict[str, tuple[Policy, float]]:
    """Every policy to ship by its name, with its speed (L/tau) according to the results.

    Args:
        results: the folder of results: `paper` and `benchmark` are read.
    """
    found = {name: _gait(results / "paper", name) for name in GAITS}
    best: dict[str, tuple[Policy, float]] = {}
    for policy, speed in _compared(results / "benchmark"):
        agent = policy.config.agent
        if policy.config.decisions and (agent not in best or speed > best[agent][1]):
            best[agent] = policy, speed
    return found | dict(sorted(best.items()))


def write(results: Path, folder: Path) -> list[str]:
    """Write the policies of `collect` as JSON in place of those that are there; returns their names."""
    found = collect(results)
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("*.json"):
        old.unlink()
    for name, (policy, _) in found.items():
        write_policy(policy, folder / f"{name}.json")
    return list(found)


def require_speed(name: str, policy: Policy, speed: float) -> None:
    """Let a policy crawl without noise, and compare.

    Raises:
        ValueError: if it does not crawl as fast as it should.
    """
    config = override(policy.config, {"evaluation.noise": [0.0]}, name)
    table = policy.table_of(config.evaluation.mode)
    now = float(measure(config, policy.seed, table, config.evaluation).starts["speed"].mean())
    if not math.isclose(now, speed, rel_tol=SAME_SPEED):
        raise ValueError(
            f"{name} crawls at {now:.6g} L/tau, the results say {speed:.6g}: they are older than the code; "
            "run `crawler-bench reproduce` and `crawler-bench benchmark` first"
        )


def _gait(paper: Path, name: str) -> tuple[Policy, float]:
    """The run that the paper's figures show of an experiment."""
    runs = pd.read_csv(paper / "runs.csv", dtype={"policy": str})
    row = typical_row(runs[runs["experiment"] == name])
    seed = int(row["seed"])
    saved = json.loads((paper / "policies" / f"{name}-seed{seed:02d}.json").read_text())
    values = np.array(saved["q_table"])
    table = np.eye(values.shape[1])[values.argmax(axis=1)]
    if policy_text(table) != row["policy"]:
        raise ValueError(f"{paper}: the policy of {name}, seed {seed}, is not the one in runs.csv")
    run = load_experiment(config_folder() / "paper" / f"{name}.yaml").run
    return Policy(run, seed, {run.evaluation.mode: table}), float(row["speed"])


def _compared(benchmark: Path) -> Iterator[tuple[Policy, float]]:
    """Every shared policy of the comparison in each of its modes, with its speed."""
    runs = pd.read_csv(benchmark / "runs.csv", dtype={"policy": str})
    for path in sorted((benchmark / "policies").glob("*.json")):
        policy = read_policy(path)
        entry = path.stem.partition("-eps")[0]
        regularization = policy.config.environment.regularization
        mine = runs[(runs["agent"] == entry) & (runs["seed"] == policy.seed)]
        mine = mine[mine["regularization"] == regularization]
        for mode, speed in zip(mine["mode"], mine["speed"], strict=True):
            if mode in policy.tables:
                config = override(policy.config, {"evaluation.mode": mode}, entry)
                yield replace(policy, config=config), float(speed)


def main(results: Path) -> None:
    """Check and write the shipped policies."""
    for name, (policy, speed) in collect(results).items():
        require_speed(name, policy, speed)
        print(f"{name}: {speed:.4g} L/tau, as the results say")
    print(f"written to {SHIPPED}: {', '.join(write(results, SHIPPED))}")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else SHIPPED.parents[1] / "results")
