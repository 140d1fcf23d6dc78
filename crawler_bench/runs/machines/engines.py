"""What joblib's processes and Dask's workers have in common, and how a user says who does the work."""

import multiprocessing
import os
import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

from crawler_bench.config.errors import ConfigError

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


def end_workers() -> None:
    """Kill every worker process that this process started; what they were at is done again another time."""
    for child in multiprocessing.active_children():
        child.kill()
    for child in multiprocessing.active_children():
        child.join(1.0)
