"""Work in processes of this machine."""

import multiprocessing
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass

from joblib import Parallel, delayed
from joblib.externals.loky.process_executor import TerminatedWorkerError

from crawler_bench.runs.machines.engines import Found, Lost, Task, end_workers


@dataclass(frozen=True)
class Processes:
    """joblib's processes.

    When one dies, joblib gives up all that were working. What they were at is then called again, each in a
    process of its own, so that a task that kills whoever works on it is found, and no other task pays for it.
    """

    number: int

    def __call__(self, work: Callable[..., Found], tasks: Iterable[Task]) -> Iterator[Found | Lost]:
        """Call `work(*task)` for every task."""
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
