"""Measure everything, append it to the history, draw it, and say which goals fail."""

import argparse
import json
import os
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import torch

from crawler_bench.runs.folders.checksums import seal
from crawler_bench.runs.store import write_manifest
from speed import environments, figures, learning, physics, start_up
from speed.history import History
from speed.measure import FULL, QUICK, Effort, Measurement

PARTS: tuple[Callable[[Effort], list[Measurement]], ...] = (
    physics.exact_against_solve, physics.exact_against_stepped, physics.against_segments,
    physics.against_batch, physics.memory, environments.single, environments.vector, learning.tabular,
    learning.shares, start_up.warm, start_up.cold,
)  # fmt: skip
OUT = {False: Path("results/speed"), True: Path("results/smoke/speed")}


def main(words: Sequence[str] | None = None) -> int:
    """Measure and write.

    Args:
        words: of the command line; None for those of this process.

    Returns:
        Exit code: 1 if a goal fails, except with --quick, whose numbers mean little.
    """
    parser = argparse.ArgumentParser(prog="python -m speed", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="a few seconds, to see that everything runs")
    parser.add_argument("--out", type=Path, help=f"default {OUT[False]}, with --quick {OUT[True]}")
    arguments = parser.parse_args(words)
    effort = QUICK if arguments.quick else FULL
    folder = arguments.out or OUT[effort.quick]
    started, load, core = time.monotonic(), os.getloadavg(), use_one_core(pin=not effort.quick)
    measured: list[Measurement] = []
    for part in PARTS:
        measured += part(effort)
        print(f"{part.__module__}.{part.__name__}", flush=True)
    folder.mkdir(parents=True, exist_ok=True)
    facts = {"quick": effort.quick, "core": core, "load": [load, os.getloadavg()]}
    write_manifest(folder, started, **facts)
    history = History(folder)
    history.append(json.loads((folder / "manifest.json").read_text()), measured)
    figures.draw(history, folder)
    seal(folder, folder.name)
    print(folder)
    failed = [each for each in measured if not each.goal_met]
    for each in failed:
        print(f"goal failed: {each.describe()}", file=sys.stderr)
    return int(bool(failed) and not effort.quick)


def use_one_core(pin: bool) -> int | None:
    """Use one thread and, if asked and possible, one core, for this process and those that it starts.

    Returns:
        The core, None if there is no keeping to one.
    """
    torch.set_num_threads(1)
    if not (pin and hasattr(os, "sched_setaffinity")):
        return None
    core = max(os.sched_getaffinity(0))
    os.sched_setaffinity(0, {core})
    return core
