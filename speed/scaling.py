"""How a sweep scales: cells that only sleep, on more and more workers; `python -m speed.scaling` prints it.

A worker that sleeps needs no core, so that many workers show what the seam between them and the client costs.
"""

import argparse
import resource
import time

import pandas as pd

from crawler_bench.output.cells import format_number, markdown
from crawler_bench.runs.machines.engines import Workers
from crawler_bench.runs.machines.workplaces import engine


def measure(workers: Workers, cells: int, seconds: float) -> dict[str, float]:
    """Sleep in every cell.

    Args:
        workers: who does it.
        cells: how many there are.
        seconds: how long each sleeps.

    Returns:
        Cells per second, the share of the time that the workers slept, what a cell costs beyond its sleep
        (ms, of one worker's time), and the memory of this process (MiB).
    """
    with engine(workers) as run:
        for _ in run(time.sleep, [(seconds,)] * 2 * workers.processes):
            pass  # all workers are up
        started = time.perf_counter()
        done = sum(1 for _ in run(time.sleep, ((seconds,) for _ in range(cells))))
        elapsed = time.perf_counter() - started
    return {
        "cells/s": done / elapsed,
        "asleep": done * seconds / elapsed / workers.processes,
        "overhead (ms)": 1000 * (elapsed * workers.processes / done - seconds),
        "client (MiB)": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
    }


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(prog="python -m speed.scaling", description=__doc__)
    parser.add_argument("--on", default="", help="as of the commands: dask, or nothing for processes")
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 2, 4, 8, 16, 32])
    parser.add_argument("--cells", type=int, default=100, help="for each worker")
    parser.add_argument("--seconds", type=float, default=0.1, help="that a cell sleeps")
    words = parser.parse_args()
    rows = [
        {"workers": number} | measure(Workers(number, words.on), words.cells * number, words.seconds)
        for number in words.workers
    ]
    print(markdown(pd.DataFrame(rows).map(format_number)))


if __name__ == "__main__":
    main()
