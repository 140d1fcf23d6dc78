"""Many crawlers, each with its own body, task and generator, in one compiled call.

Crawler i of a batch does what a `CrawlerEnv` with the same arguments and the same seed does, to the last bit:
both go through `decide`.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from crawler_bench.envs.arguments import require_count, require_parameters
from crawler_bench.envs.transition import RUNNING, Packed, begin, decide, make_task, most_decisions, report
from crawler_bench.physics.coefficients import as_floats, stepping
from crawler_bench.physics.compiled import inner_kernel
from crawler_bench.physics.parameters import CrawlerParameters
from crawler_bench.physics.state import Array, make_memory, nodes_of, odometer_of

# Columns of the outcome of a decision.
REWARD, DISPLACED, GRADIENT, CENTROID = range(4)


class CrawlerBatch:
    """K crawlers and all that changes while they live.

    Args:
        parameters: one for each crawler, or one for all; all with the same number of segments.
        num_envs: K.
        regularization: one for each, or one for all; so the following.
        noise: largest error of a sensed strain.
        episode_distance: L.
        time_limit: tau_theta.
        max_decisions: in an episode, whatever the time limit; None for no such limit.

    Attributes:
        memory: (K, size) floats, see physics/state.py.
        nodes: (K, N + 1) records, the same memory by name.
        odometers: (K,) records, likewise.
        generators: (K, 4) raw generator states.
        observation: (K,) what each crawler senses now.
        outcome: (K, 4) REWARD, DISPLACED, GRADIENT, CENTROID of the last decision.
        end: (K,) how the episode ended with the last decision, or RUNNING.
        ended: (K,) whether it ended, be it with max_decisions.
        begun: whether episodes have begun.
        most_decisions: in any episode, or None without a limit.

    Raises:
        ValueError: if a number is not possible, the numbers of segments differ, or there are not K of
            something.
    """

    def __init__(
        self,
        parameters: CrawlerParameters | Sequence[CrawlerParameters],
        num_envs: int,
        regularization: float | Sequence[float] = 0.01,
        noise: float | Sequence[float] = 0.0,
        episode_distance: float | Sequence[float] = 8.83,
        time_limit: float | Sequence[float] = 4000.0,
        max_decisions: int | None = None,
    ) -> None:
        require_count("num_envs", num_envs)
        given = [require_parameters(each) for each in _each("parameters", parameters, num_envs)]
        settings = zip(
            given,
            *(
                _each(name, value, num_envs)
                for name, value in (
                    ("regularization", regularization), ("noise", noise),
                    ("episode_distance", episode_distance), ("time_limit", time_limit),
                )
            ),
            strict=True,
        )  # fmt: skip
        self.parameters = given
        if len({each.n_segments for each in given}) > 1:
            raise ValueError("all crawlers of a batch need the same n_segments")
        self._tasks = np.array([make_task(*each)[0] for each in settings])
        # If one takes steps, all can: the kernels are the same for the whole batch.
        takes_steps = any(make_task(each)[1] is not None for each in given)
        self._steppings = np.array([as_floats(stepping(each)) for each in given]) if takes_steps else None
        self.n_segments = given[0].n_segments
        self.memory = np.tile(make_memory(self.n_segments), (num_envs, 1))
        self.generators = np.zeros((num_envs, 4), dtype=np.uint64)
        self.observation = np.zeros(num_envs, dtype=np.int64)
        self.outcome = np.zeros((num_envs, 4))
        self.end = np.zeros(num_envs, dtype=np.int64)
        self.ended = np.zeros(num_envs, dtype=np.bool_)
        self._decisions = np.zeros(num_envs, dtype=np.int64)  # in the present episode
        self._max_decisions = np.iinfo(np.int64).max if max_decisions is None else max_decisions
        time_limits = _each("time_limit", time_limit, num_envs)
        limits = [most_decisions(*each) for each in zip(given, time_limits, strict=True)]
        counts = [each for each in limits if each is not None]
        longest = max(counts) if len(counts) == num_envs else None
        known = [each for each in (max_decisions, longest) if each is not None]
        self.most_decisions = min(known, default=None)
        self.begun = False

    @property
    def nodes(self) -> Any:
        """State of every node of every crawler, (K, N + 1) records."""
        return nodes_of(self.memory)

    @property
    def odometers(self) -> Any:
        """What every crawler counts over decisions, (K,) records."""
        return odometer_of(self.memory)

    def set_tasks(self, tasks: Mapping[int, Packed]) -> None:
        """Give some crawlers, named by their place, other tasks with the same parameters."""
        for i, (task, _) in tasks.items():
            self._tasks[i] = task

    def seed(self, seeds: Sequence[int | None]) -> None:
        """Seed each crawler's generator as `CrawlerEnv.reset(seed=...)` does; None leaves one as it is."""
        for i, seed in enumerate(seeds):
            if seed is not None:
                self.generators[i] = seed_words(np.random.PCG64(np.random.SeedSequence(seed)))

    def begin(self, chosen: NDArray[np.bool_] | None = None) -> None:
        """Put crawlers to rest and observe them: all, or the (K,) chosen ones."""
        which = np.ones_like(self.ended) if chosen is None else chosen
        _begin_chosen(
            which, self.memory, self._tasks, self.generators, self.observation, self.outcome, self.end,
            self.ended, self._decisions,
        )  # fmt: skip
        self.begun = True

    def decide(self, actions: Any) -> int:
        """Hold one neuron of each crawler ON for a decision interval.

        A crawler whose episode has ended makes no decision but is put to rest and observed.

        Args:
            actions: (K,) from 0 to N - 1.

        Returns:
            How many episodes ended.

        Raises:
            ResetNeeded: if no episode has begun.
            ValueError: if the actions are not K neurons; no crawler has moved then.
        """
        if not self.begun:
            raise ResetNeeded("the crawlers have no episode yet: call reset() before step()")
        given = np.asarray(actions)
        if given.shape == self.end.shape and given.dtype.kind in "iu":
            chosen = np.asarray(given, dtype=np.int64, order="C")
            n_ended = _decide_all(
                self.memory, self.n_segments, chosen, self._tasks, self._steppings, self.generators,
                self.observation, self.outcome, self.end, self.ended, self._decisions, self._max_decisions,
            )  # fmt: skip
            if n_ended >= 0:
                return n_ended
        allowed = f"{self.end.size} whole numbers from 0 to {self.n_segments - 1}"
        raise ValueError(f"actions are not possible: {allowed} are needed")

    def draw(self) -> tuple[NDArray[np.uint8], ...]:
        """A picture of each crawler, (height, width, 3)."""
        from crawler_bench.envs.rendering import draw_crawler

        self.report()
        intervals = self.odometers["episode_intervals"]
        return tuple(
            draw_crawler(self.nodes["displacement"][i], float(intervals[i]) * each.decision_interval)
            for i, each in enumerate(self.parameters)
        )

    def report(self) -> None:
        """Write all of the state of each crawler, and its power, to its memory."""
        _report_all(self.memory, self._tasks)


def _each(name: str, value: Any, num_envs: int) -> list[Any]:
    several = isinstance(value, Sequence | np.ndarray) and not isinstance(value, str)
    values = list(value) if several else [value] * num_envs
    if len(values) != num_envs:
        raise ValueError(f"{name} has {len(values)} values for {num_envs} crawlers")
    return values


def seed_words(generator: Any) -> list[int]:
    """The four words of a generator's state, see envs/randomness.py."""
    content = generator.state["state"]
    word = 2**64
    return [
        content["state"] % word, content["state"] // word, content["inc"] % word, content["inc"] // word,
    ]  # fmt: skip


@inner_kernel
def _begin_chosen(
    chosen: NDArray[np.bool_],
    memory: Array,
    tasks: Array,
    generators: NDArray[np.uint64],
    observation: NDArray[np.int64],
    outcome: Array,
    end: NDArray[np.int64],
    ended: NDArray[np.bool_],
    decisions: NDArray[np.int64],
) -> None:
    for i in range(memory.shape[0]):
        if chosen[i]:
            observation[i] = begin(memory[i], (tasks[i], None), generators[i])
            outcome[i] = 0.0
            end[i], ended[i], decisions[i] = RUNNING, False, 0


@inner_kernel
def _report_all(memory: Array, tasks: Array) -> None:
    for i in range(memory.shape[0]):
        report(memory[i], (tasks[i], None))


@inner_kernel
def _decide_all(
    memory: Array,
    n_segments: int,
    actions: NDArray[np.int64],
    tasks: Array,
    steppings: Array | None,
    generators: NDArray[np.uint64],
    observation: NDArray[np.int64],
    outcome: Array,
    end: NDArray[np.int64],
    ended: NDArray[np.bool_],
    decisions: NDArray[np.int64],
    max_decisions: int,
) -> int:
    """Return how many episodes ended; -1 if an action is none, and then no crawler has moved."""
    for action in actions:
        if not 0 <= action < n_segments:
            return -1
    n_ended = 0
    for i in range(memory.shape[0]):
        if ended[i]:
            observation[i] = begin(memory[i], (tasks[i], None), generators[i])
            outcome[i] = 0.0
            end[i], ended[i], decisions[i] = RUNNING, False, 0
            continue
        if steppings is None:
            made = decide(memory[i], actions[i], (tasks[i], None), generators[i])
        else:
            made = decide(memory[i], actions[i], (tasks[i], steppings[i]), generators[i])
        decisions[i] += 1
        observation[i], end[i] = made.observation, made.end
        ended[i] = made.end != RUNNING or decisions[i] >= max_decisions
        outcome[i, REWARD], outcome[i, DISPLACED] = made.reward, made.displacement
        outcome[i, GRADIENT], outcome[i, CENTROID] = made.gradient, made.centroid
        n_ended += ended[i]
    return n_ended
