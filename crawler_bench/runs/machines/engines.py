"""Where work is done: in this process, in others of this machine, or on a Dask cluster; all behave alike."""

import multiprocessing
import os
import re
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

from joblib import Parallel, delayed
from joblib.externals.loky.process_executor import TerminatedWorkerError

from crawler_bench.config.schema import ConfigError

Found = TypeVar("Found")
Task = tuple[Any, ...]  # the arguments of one call


@dataclass(frozen=True)
class Lost:
    """A task whose worker died, twice.

    Attributes:
        task: the arguments of the call.
        reason: what is known of it, in one line.
    """

    task: Task
    reason: str


class Engine(Protocol):
    """Calls a function with every task, and gives results as they come, in any order."""

    def __call__(self, work: Callable[..., Found], tasks: Iterable[Task]) -> Iterator[Found | Lost]:
        """Call `work(*task)` for every task."""


@dataclass(frozen=True)
class Workers:
    """Who does the work.

    Attributes:
        jobs: number of processes on this machine; 0 means one per core.
        on: empty for processes of this machine; else "dask", "slurm", "kubernetes", or a scheduler's address.
    """

    jobs: int = 0
    on: str = ""

    def __post_init__(self) -> None:
        """Refuse another place.

        Raises:
            ConfigError: naming those that there are.
        """
        if not re.fullmatch(r"|dask|slurm|kubernetes|(tcp|tls|ws|wss|ucx)://\S+", self.on):
            raise ConfigError(
                f"--on {self.on}: work is done on dask, slurm, kubernetes or a scheduler's address, tcp://host:port"
            )

    @property
    def processes(self) -> int:
        """Processes on this machine."""
        return self.jobs or os.cpu_count() or 1


def as_workers(jobs: Workers | int) -> Workers:
    """What a caller gave, who may give a number of processes alone."""
    return jobs if isinstance(jobs, Workers) else Workers(jobs)


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
        yield _Processes(workers.processes)
        complete = True
    finally:
        if not complete:
            end_workers()


def end_workers() -> None:
    """Kill every worker process that this process started; what they were at is done again another time."""
    for child in multiprocessing.active_children():
        child.kill()
    for child in multiprocessing.active_children():
        child.join(1.0)


@dataclass(frozen=True)
class _Processes:
    """joblib's processes.

    When one dies, joblib gives up all that were working. What they were at is then called again, each in a
    process of its own, so that a task that kills whoever works on it is found, and no other task pays for it.
    """

    number: int

    def __call__(self, work: Callable[..., Found], tasks: Iterable[Task]) -> Iterator[Found | Lost]:
        left = enumerate(tasks)
        while True:
            begun: dict[int, Task] = {}
            try:
                pool = Parallel(n_jobs=self.number, return_as="generator_unordered")
                for i, found in pool(delayed(_numbered)(work, i, task) for i, task in _noted(left, begun)):
                    del begun[i]
                    yield found
                return
            except TerminatedWorkerError:
                for task in list(begun.values()):
                    yield _alone(work, task)


def _noted(left: Iterator[tuple[int, Task]], begun: dict[int, Task]) -> Iterator[tuple[int, Task]]:
    for i, task in left:
        begun[i] = task
        yield i, task


def _numbered(work: Callable[..., Found], number: int, task: Task) -> tuple[int, Found]:
    return number, work(*task)


def _alone(work: Callable[..., Found], task: Task) -> Found | Lost:
    """Call a function in a process of its own."""
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        try:
            return pool.submit(work, *task).result()
        except BrokenProcessPool:
            return Lost(task, "the process that ran it died twice: killed, or out of memory")
        except BaseException:
            end_workers()  # leaving the block waits for them
            raise
