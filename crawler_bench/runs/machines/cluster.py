"""Work on a Dask cluster: on this machine, one that runs, or one that a batch system or Kubernetes grants."""

import itertools
import logging
import math
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from importlib import import_module
from typing import Any

from crawler_bench.config.errors import ConfigError
from crawler_bench.runs.machines.engines import Found, Lost, Task, Workers, end_workers

try:
    import dask
    import distributed
except ImportError:
    raise ConfigError("--on needs Dask: pip install 'crawler-bench[cluster]'") from None

DEATHS = 0  # of workers that a task may have a part in before it is called again alone
RECOUNT = 2.0  # seconds after which workers are counted again
LONG = 300.0  # seconds without any worker after which to give up
GONE = "the Dask scheduler is gone; the same command goes on from the runs that are finished"
CONNECT = "10s"  # for a scheduler to answer
PATIENCE = 1.5  # seconds to say goodbye in
CLASSES = {"slurm": "dask_jobqueue:SLURMCluster", "kubernetes": "dask_kubernetes.operator:KubeCluster"}


@contextmanager
def connected(workers: Workers) -> Iterator["_Cluster"]:
    """Connect to a cluster, or start one; what was started ends with the block.

    Raises:
        ConfigError: if there is none, or its workers have several threads.
    """
    settings = {
        "distributed.scheduler.allowed-failures": DEATHS,
        "distributed.worker.memory.terminate": False,  # the system's own limit is enough, and knows better
    }
    with dask.config.set(settings), _silent():
        started = None if "://" in workers.on else _start(workers)
        try:
            try:
                client = distributed.Client(started or workers.on, timeout=CONNECT)
            except OSError as error:
                raise ConfigError(f"--on {workers.on}: no scheduler answers there ({error})") from None
            try:
                _wait_for_workers(client, workers.on)
                _require_one_thread(client)
                yield _Cluster(client, workers.on)
            finally:
                _close(client)
        finally:
            if started is not None:
                _close(started)
                end_workers()


@contextmanager
def _silent() -> Iterator[None]:
    """Keep Dask from tracing what is said here in one line."""
    logger = logging.getLogger("distributed.client")
    logger.disabled = True
    try:
        yield
    finally:
        logger.disabled = False


def _start(workers: Workers) -> Any:
    if workers.on == "dask":
        return distributed.LocalCluster(
            n_workers=workers.processes,
            threads_per_worker=1,
            dashboard_address="127.0.0.1:0",
            silence_logs="CRITICAL",
        )
    if not workers.jobs:
        raise ConfigError(f"--on {workers.on}: say with --jobs how many workers to ask for")
    module, _, name = CLASSES[workers.on].partition(":")
    try:
        kind = getattr(import_module(module), name)
    except ImportError:
        package = module.partition(".")[0].replace("_", "-")
        raise ConfigError(f"--on {workers.on} needs {package}: pip install {package}") from None
    try:
        cluster = kind()  # all it needs stands in Dask's configuration files
    except (ValueError, TypeError, OSError) as error:
        raise ConfigError(f"--on {workers.on}: {error}; see docs/scaling.md for the configuration") from None
    cluster.scale(workers.jobs)
    return cluster


def _wait_for_workers(client: Any, where: str) -> None:
    if not client.nthreads():
        print(f"crawler-bench: waiting for the first worker on {where}", file=sys.stderr)
        client.wait_for_workers(1)


def _require_one_thread(client: Any) -> None:
    """Refuse workers with threads: they would compute at the same time in one process."""
    several = [address for address, threads in client.nthreads().items() if threads > 1]
    if several:
        raise ConfigError(f"the worker {several[0]} has several threads: start workers with --nthreads 1")


def _close(what: Any) -> None:
    with suppress(Exception):  # it may be gone
        what.close(timeout=PATIENCE)


@dataclass(frozen=True)
class _Cluster:
    """Dask's workers; a task whose worker dies is called again on another one, once.

    The scheduler blames all tasks that a dead worker had. So those are called again when all else is done,
    one at a time. And it gets as many tasks as there are workers, so that few are blamed and no sweep fills
    its memory.
    """

    client: Any
    where: str

    def __call__(self, work: Callable[..., Found], tasks: Iterable[Task]) -> Iterator[Found | Lost]:
        """Call `work(*task)` for every task.

        Raises:
            RuntimeError: if the scheduler is gone, or no worker has been there for long.
        """
        left = iter(tasks)
        flying: dict[Any, Task] = {}
        suspects: list[Task] = []
        alone = False
        most, counted, seen = 0, -math.inf, time.monotonic()
        while True:
            if time.monotonic() > counted + RECOUNT:
                counted, number = time.monotonic(), self._count_workers()
                seen = counted if number else seen
                if counted > seen + LONG:
                    raise RuntimeError(f"no worker is left on {self.where}; the same command goes on")
                most = max(1, number)
            for task in itertools.islice(left, max(0, most - len(flying))):
                flying[self.client.submit(work, *task, pure=False)] = task
            if not flying and suspects:
                alone, task = True, suspects.pop()
                flying[self.client.submit(work, *task, pure=False)] = task
            if not flying:
                return
            for future in self._done(flying):
                try:
                    found = self._result(future, flying[future])
                except TimeoutError:  # lost with its worker: it is being called again
                    continue
                task = flying.pop(future)
                if isinstance(found, Lost) and not alone:
                    suspects.append(task)
                else:
                    yield found

    def _count_workers(self) -> int:
        try:
            return len(self.client.nthreads())
        except (OSError, TypeError, ValueError):
            raise RuntimeError(GONE) from None

    def _done(self, flying: dict[Any, Task]) -> list[Any]:
        """The futures that have come to an end, after a while if there is none."""
        with suppress(TimeoutError, distributed.CancelledError):
            distributed.wait(list(flying), timeout=RECOUNT, return_when="FIRST_COMPLETED")
        return [future for future in flying if future.done()]

    def _result(self, future: Any, task: Task) -> Any:
        if future.status == "finished":
            return future.result(timeout=RECOUNT)
        error = None if future.cancelled() else future.exception(timeout=RECOUNT)
        if isinstance(error, distributed.KilledWorker):
            return Lost(task, "the worker that ran it died, twice: killed, or over a limit")
        if error is not None:
            raise error
        raise RuntimeError(GONE)
