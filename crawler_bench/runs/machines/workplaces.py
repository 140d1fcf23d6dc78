"""Where work is done: in this process, in others of this machine, or on a Dask cluster; all behave alike."""

from collections.abc import Iterator
from contextlib import contextmanager

from crawler_bench.runs.machines.engines import Engine, Workers, end_workers
from crawler_bench.runs.machines.processes import Processes


@contextmanager
def engine(workers: Workers) -> Iterator[Engine]:
    """Give an engine; when the block ends, however it does, its workers on this machine end, too."""
    if workers.on:
        from crawler_bench.runs.machines.cluster import connected  # loads Dask, an optional dependency

        with connected(workers) as found:
            yield found
        return
    complete = False
    try:
        yield Processes(workers.processes)
        complete = True
    finally:
        if not complete:
            end_workers()
