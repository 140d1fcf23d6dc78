"""What a policy is worth: the benchmark's own measure, from its own starts, as fast as it can be computed."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from crawler_bench.benchmark.ceilings.crawls import explore, follow, look_ahead
from crawler_bench.config.schema import EvaluationConfig
from crawler_bench.envs.batch import seed_words
from crawler_bench.envs.transition import Packed, make_task
from crawler_bench.gait.rollout import Start, begin_crawl
from crawler_bench.physics.parameters import CrawlerParameters
from crawler_bench.physics.state import Array

Policy = NDArray[np.int64]  # (N,) one action for each observation


@dataclass(frozen=True)
class Objective:
    """Mean reward of a decision over all starts of an evaluation, frozen: `reward` of its runs.

    Attributes:
        parameters: the crawler.
        evaluation: starts, warm-up and duration.
        regularization: epsilon; with 0, the reward is the speed in rest lengths per decision.
        noise: largest error of a sensed strain.
    """

    parameters: CrawlerParameters
    evaluation: EvaluationConfig
    regularization: float
    noise: float

    @property
    def steps(self) -> int:
        """Decision intervals of a crawl."""
        return round(self.evaluation.duration / self.parameters.decision_interval)

    def quick(self, starts: int, share: float) -> "Objective":
        """The same from fewer starts over a share of the duration."""
        fewer = {"starts": min(starts, self.evaluation.starts), "duration": self.evaluation.duration * share}
        return replace(self, evaluation=self.evaluation.model_copy(update=fewer))

    def of_table(self, table: Array, policy_seed: int = 0) -> tuple[float, NDArray[np.bool_]]:
        """Worth of an (N, N) table of probabilities, L, and which observations it visits, (N,)."""
        cumulative, n = np.cumsum(table, axis=1), self.parameters.n_segments
        total, visited = 0.0, np.zeros(n, dtype=np.bool_)
        for key, start in zip(self._keys, self._starts, strict=True):
            policy_rng = seed_words(np.random.default_rng([policy_seed, *key]).bit_generator)
            total += follow(
                start.memory.copy(), start.observation, cumulative, self._task,
                self.parameters.intervals_per_decision, self._words(start),
                np.array(policy_rng, dtype=np.uint64), self.steps, visited,
            )  # fmt: skip
        return total / (self.steps * len(self._keys)), visited

    def of_policy(self, policy: Policy) -> tuple[float, NDArray[np.bool_]]:
        """Worth of a deterministic table, and which observations it visits."""
        return self.of_table(np.eye(policy.size)[policy])

    def of_lookahead(self, policy: Policy, horizon: int) -> float:
        """Worth of `look_ahead` on a deterministic table, which senses no noise and so meets none."""
        cumulative, n = np.cumsum(np.eye(policy.size)[policy], axis=1), policy.size
        total, visited = 0.0, np.zeros(n, dtype=np.bool_)
        for start in self._starts:
            memory = start.memory.copy()
            total += look_ahead(
                memory, start.observation, cumulative, self._quiet_task, self._words(start), self.steps,
                horizon, memory.copy(), visited,
            )  # fmt: skip
        return total / (self.steps * len(self._keys))

    def best_of_tree(
        self, start: int, most_visited: int, limit: float
    ) -> tuple[float, Policy, NDArray[np.int64]]:
        """From one start, as `explore` does: worth of the best (L per decision), policy, counts of crawls."""
        n, begun = self.parameters.n_segments, self._starts[start]
        memories = np.zeros((n + 2, begun.memory.size))
        memories[0] = begun.memory
        best, counts = np.full(n, -1, dtype=np.int64), np.zeros(3, dtype=np.int64)
        total = explore(
            memories, begun.observation, np.full(n, -1, dtype=np.int64), self._quiet_task, self._words(begun),
            self.steps, most_visited, limit, best, np.zeros((3, n + 1), dtype=np.int64), counts,
            np.zeros(n + 1),
        )  # fmt: skip
        return total / self.steps, best, counts

    @property
    def _keys(self) -> list[tuple[int, int]]:
        return [(self.evaluation.seed, start) for start in range(self.evaluation.starts)]

    @cached_property
    def _starts(self) -> list[Start]:
        return [begin_crawl(self.parameters, self.evaluation.warm_up, key) for key in self._keys]

    @cached_property
    def _task(self) -> Packed:
        return make_task(replace(self.parameters, decide_on="interval"), self.regularization, self.noise)

    @cached_property
    def _quiet_task(self) -> Packed:
        return make_task(replace(self.parameters, decide_on="interval"), self.regularization)

    @staticmethod
    def _words(start: Start) -> NDArray[np.uint64]:
        return np.array(seed_words(start.noise.bit_generator), dtype=np.uint64)
