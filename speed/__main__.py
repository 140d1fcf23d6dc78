"""Measure all speeds and write them: `python -m speed [--quick] [--out FOLDER]`."""

import os
import time
from pathlib import Path

# Before anything starts threads: they would wait for each other on the one core.
for _name in ("OMP_NUM_THREADS", "NUMBA_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[_name] = "1"

import argparse
from importlib.metadata import PackageNotFoundError, version

import pandas as pd
import torch

from crawler_bench.output.csv_files import write_csv
from crawler_bench.output.style import save
from crawler_bench.runs.store import write_manifest
from speed import counts, environments, figures, learning, physics, scaling
from speed.measure import FULL, QUICK, Effort, Row

PAIRS = (
    physics.against_solve, physics.exact_against_solve,
    physics.exact_against_stepped, physics.batch_against_one,
    environments.single, environments.vector, learning.tabular, learning.over_nothing,
)  # fmt: skip
OUT = {False: Path("results/performance"), True: Path("results/smoke/performance")}


def main() -> None:
    """Measure, write, say where."""
    parser = argparse.ArgumentParser(prog="python -m speed", description=__doc__)
    parser.add_argument(
        "--quick", action="store_true", help="small, to see that all works; numbers mean little"
    )
    parser.add_argument("--out", type=Path, help=f"default {OUT[False]}, with --quick {OUT[True]}")
    arguments = parser.parse_args()
    effort = QUICK if arguments.quick else FULL
    folder = arguments.out or OUT[effort.quick]
    folder.mkdir(parents=True, exist_ok=True)
    started, load, core = time.time(), os.getloadavg(), use_one_core(pin=not effort.quick)
    write_tables(folder, effort)
    write_figures(folder)
    facts = {"quick": effort.quick, "seconds": effort.seconds, "repeats": effort.repeats, "core": core}
    peers = {name: _version(name) for name in ("envpool", "mujoco")}
    write_manifest(folder, started, **facts, peers=peers, load_before=load, load_after=os.getloadavg())
    print(folder)


def use_one_core(pin: bool) -> int | None:
    """Keep to one thread and, if asked and possible, one core, which is returned; so do started processes."""
    torch.set_num_threads(1)
    if not (pin and hasattr(os, "sched_setaffinity")):
        return None
    core = max(os.sched_getaffinity(0))
    os.sched_setaffinity(0, {core})
    return core


def write_tables(folder: Path, effort: Effort) -> None:
    """Measure everything, a CSV for each kind of number."""
    rows: list[Row] = []
    for measure in PAIRS:
        rows += measure(effort)
        print(measure.__name__, flush=True)
    write_csv(pd.DataFrame([row.as_dict() for row in rows]), folder / "ratios.csv")
    write_csv(pd.DataFrame(learning.shares(effort)), folder / "learning.csv")
    write_csv(counts.of_a_decision(effort), folder / "counts.csv")
    costs = scaling.against_segments(effort)
    write_csv(costs, folder / "segments.csv")
    write_csv(scaling.against_batch(effort), folder / "batch.csv")
    values = [*scaling.exponents(costs), *scaling.memory(), *scaling.start_up(effort)]
    write_csv(pd.DataFrame(values), folder / "values.csv")


def write_figures(folder: Path) -> None:
    """Draw what the tables say."""
    save(figures.ratios(pd.read_csv(folder / "ratios.csv")), folder, "ratios")
    segments, batch = (pd.read_csv(folder / f"{name}.csv") for name in ("segments", "batch"))
    save(figures.cost(segments, "segments", "segments N", "Cost of a long body"), folder, "segments")
    save(figures.cost(batch, "size", "crawlers in the batch", "Cost in a batch"), folder, "batch")


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


if __name__ == "__main__":
    main()
