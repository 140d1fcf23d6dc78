"""What a sweep has to do, how far it is, and about how long the rest takes.

The folders tell: a run is trained once its folder is there, measured once its evaluation is. So the count is
right whoever does the work, this process or another one that shares the disk.
"""

import json
import os
import statistics
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from crawler_bench.config.errors import ConfigError
from crawler_bench.config.schema import RunConfig
from crawler_bench.runs import store
from crawler_bench.runs.agent import agent_class, is_stable_baselines
from crawler_bench.runs.evaluation import evaluation_folder

# Seconds of one core, where no finished run tells better; from results/benchmark/manifest.json.
PER_DECISION = 5e-7  # of a table
PER_DEEP_DECISION = 3e-4  # of a network
PER_CRAWL = 0.012  # of an evaluation
REMEMBERED = 7  # finished runs of an agent that say how long the next one takes
POLL = 1.0  # s between two looks at the folders
PATIENCE = 15.0  # s between two lines where there is no terminal


class SweepProgress:
    """Counts what is trained and measured of a sweep.

    Args:
        runs: configuration and seed of every run, each once.
        root: folder of run folders.
        jobs: how many run at a time.
    """

    def __init__(self, runs: Sequence[tuple[RunConfig, int]], root: Path, jobs: int) -> None:
        self._root, self._jobs = root, max(1, jobs)
        self._runs = [(config, store.run_folder(root, config, seed)) for config, seed in runs]
        self._untrained: set[int] = set(range(len(runs)))
        self._unmeasured: set[int] = set(range(len(runs)))
        self._poll()
        self._costs = self._estimate()
        self._to_do = self._left()
        self._started = time.monotonic()

    @property
    def counts(self) -> tuple[int, int, int]:
        """Runs that are trained, runs that are measured, all runs."""
        total = len(self._runs)
        return total - len(self._untrained), total - len(self._unmeasured), total

    def plan(self) -> str:
        """One line, before anything is done: how many runs, what is finished, where, about how long."""
        trained, measured, total = self.counts
        runs = f"{total} run{'' if total == 1 else 's'} in {self._root}"
        if measured == total:
            return f"{runs}: all trained and measured"
        todo = f"{total - trained} to train ({trained} finished), {total - measured} to measure ({measured})"
        about = format_duration(self._to_do / min(self._jobs, total - measured))
        return f"{runs}: {todo}, {self._jobs} at a time, about {about}"

    def now(self) -> str:
        """The phases: training 14/40, measuring 3/40."""
        trained, measured, total = self.counts
        training = [f"training {trained}/{total}"] if trained < total else []
        return ", ".join([*training, f"measuring {measured}/{total}"])

    def seconds_left(self) -> float:
        """Time for what is left, at the pace since the start; what was finished before does not count."""
        left = self._left()
        done, elapsed = self._to_do - left, time.monotonic() - self._started
        pace = elapsed / done if done > 0.02 * self._to_do else 1 / self._jobs
        return left * pace

    def give_up(self, config: RunConfig, seed: int) -> None:
        """Count a run that failed as neither to train nor to measure."""
        folder = store.run_folder(self._root, config, seed)
        for index, (_, known) in enumerate(self._runs):
            if known == folder:
                self._untrained.discard(index)
                self._unmeasured.discard(index)

    @contextmanager
    def shown(self, console: Console) -> Iterator[None]:
        """Show the phases while a block runs: a bar on a terminal, else a line now and then."""
        if console.quiet:
            yield
            return
        over = threading.Event()
        said = TextColumn("{task.description}")
        columns = (said, BarColumn(), TimeElapsedColumn(), TextColumn("{task.fields[left]}"))
        bar = Progress(*columns, console=console, disable=not console.is_terminal, transient=True)
        with bar:
            task = bar.add_task(self.now(), total=max(self._to_do, 1e-9), left="")

            def watch() -> None:
                said, last = self.now(), time.monotonic()
                while not over.wait(POLL):
                    with suppress(OSError):  # a folder that somebody has moved meanwhile
                        self._poll()
                    left = f"about {format_duration(self.seconds_left())} left"
                    done = self._to_do - self._left()
                    bar.update(task, description=self.now(), completed=done, left=left)
                    if not console.is_terminal and self.now() != said and time.monotonic() - last > PATIENCE:
                        said, last = self.now(), time.monotonic()
                        console.print(f"{said}, {left}", markup=False, soft_wrap=True)

            watcher = threading.Thread(target=watch, name="sweep progress", daemon=True)
            watcher.start()
            try:
                yield
            finally:
                over.set()
                watcher.join()

    def _poll(self) -> None:
        """Look which folders have appeared; of those that have not, the list of names tells at once."""
        there = set(os.listdir(self._root)) if self._root.is_dir() else set()
        for index in sorted(self._unmeasured):
            config, folder = self._runs[index]
            if folder.name not in there:
                continue
            if index in self._untrained and store.is_run(folder):
                self._untrained.discard(index)
            if index not in self._untrained:
                place = evaluation_folder(folder, config.evaluation)
                if (place / store.MANIFEST).is_file():
                    self._unmeasured.discard(index)

    def _left(self) -> float:
        """Seconds of one core for what is neither trained nor measured."""
        training = sum(self._costs[index][0] for index in list(self._untrained))
        return training + sum(self._costs[index][1] for index in list(self._unmeasured))

    def _estimate(self) -> list[tuple[float, float]]:
        """Seconds that training and measuring each run take."""
        agents = {config.agent for index, (config, _) in enumerate(self._runs) if index in self._unmeasured}
        paces = {agent: _seconds_per_decision(self._root, agent) for agent in agents}
        costs, trained = [], set()
        for config, folder in self._runs:
            training = 0.0 if folder in trained else config.decisions * paces.get(config.agent, 0.0)
            trained.add(folder)  # two evaluations of one run train it once
            crawls = config.evaluation.starts * len(config.evaluation.noise)
            costs.append((training, crawls * PER_CRAWL))
        return costs


def seconds_to_train(root: Path, config: RunConfig) -> float:
    """About how long one run takes to train, by what finished runs of its agent took."""
    return config.decisions * _seconds_per_decision(root, config.agent)


def _seconds_per_decision(root: Path, agent: str) -> float:
    """What the newest finished runs of an agent took, or a guess from what kind of agent it is."""
    name = agent.rpartition(":")[2].lower()
    manifests = [path for path in root.glob(f"{name}-eps*/{store.MANIFEST}") if path.is_file()]
    newest = sorted(manifests, key=lambda path: path.stat().st_mtime)[-REMEMBERED:]
    paces = []
    for path in newest:
        try:
            seconds = float(json.loads(path.read_text())["wall_clock_seconds"])
            decisions = store.read_run(path.parent)[0].decisions
        except (OSError, ValueError, KeyError, TypeError):
            continue
        if decisions:
            paces.append(seconds / decisions)
    if paces:
        return statistics.median(paces)
    try:
        return PER_DEEP_DECISION if is_stable_baselines(agent_class(agent)) else PER_DECISION
    except ConfigError:  # it will be reported as a failed run
        return 0.0


def format_duration(seconds: float) -> str:
    """A time as one would say it: "8 s", "12 min", "3.5 h"."""
    if seconds < 90:
        return f"{max(1, round(seconds))} s"
    minutes = seconds / 60
    return f"{minutes:.0f} min" if minutes < 90 else f"{minutes / 60:.1f} h"
