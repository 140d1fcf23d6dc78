"""The same body seen through other keyholes than the index of its most contracted segment.

| keyhole | space | what it shows |
|---|---|---|
| index | Discrete(N) | the most contracted segment [M20, eq. 9]: `CrawlerEnv` itself |
| one-hot | Box(N) | the same as N zeros and ones, for code that knows only Box |
| strain | Box(N) | the strain of every segment, each sensed with the error that the index is made from |
| state | Box(7 N + 6) | all that decides the future of the body, without error |

Physics, reward and ends of episodes are those of `CrawlerEnv` with the same seed and actions. Every number is
clipped to [-BOUND, BOUND], which no body of ours comes near.
"""

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from crawler_bench.envs.batch import CrawlerBatch
from crawler_bench.envs.randomness import random
from crawler_bench.envs.transition import Task
from crawler_bench.physics.compiled import inner_kernel
from crawler_bench.physics.state import Array

INDEX, ONE_HOT, STRAIN, STATE = KEYHOLES = ("index", "one-hot", "strain", "state")
BOUND = 100.0
NOISE = Task._fields.index("noise")
Frames = NDArray[np.float32]


def size(keyhole: str, n_segments: int) -> int:
    """How many numbers a keyhole shows of a body of N segments."""
    return 7 * n_segments + 6 if keyhole == STATE else n_segments


def space(keyhole: str, n_segments: int) -> gym.spaces.Box:
    """The observation space of a keyhole that is not the index.

    Raises:
        ValueError: if there is no such keyhole.
    """
    if keyhole not in KEYHOLES[1:]:
        raise ValueError(
            f"keyhole = {keyhole!r} is not possible: it must be one of {', '.join(KEYHOLES[1:])}"
        )
    low, high = (0.0, 1.0) if keyhole == ONE_HOT else (-BOUND, BOUND)
    return gym.spaces.Box(low, high, (size(keyhole, n_segments),), np.float32)


def look(keyhole: str, index: NDArray[np.int64], nodes: NDArray[np.void], errors: Array) -> Frames:
    """What a keyhole shows of K bodies.

    Args:
        keyhole: any but the index.
        index: (K,) the most contracted segment of each, as sensed.
        nodes: (K, N + 1) records; for the state they must have been reported.
        errors: (K, N) of the sensed strains.

    Returns:
        (K, size) float32, arrays of the caller's own.
    """
    n = nodes.shape[1] - 1
    if keyhole == ONE_HOT:
        shown: Array = np.eye(n)[index]
    elif keyhole == STRAIN:
        shown = nodes["strain"][:, :-1] + errors
    else:
        shown = body_state(nodes)
    return np.clip(shown, -BOUND, BOUND).astype(np.float32)


def body_state(nodes: NDArray[np.void]) -> Array:
    """(K, 7 N + 6) all that decides the future of K bodies, wherever they are.

    N strains; then of every node: whether it slides forward, sticks or slides backward (1, 0, -1), sine and
    cosine of its neuron's phase theta, its muscle's drive F, velocity (L / tau_theta) and muscle force (k L).
    Where the body is, and for how long the episode has gone on, decides only when a truncation comes, which a
    learner looks through.
    """
    phase = 2 * np.arctan(nodes["neuron"])
    parts = (nodes["slip"], np.sin(phase), np.cos(phase), nodes["drive"], nodes["velocity"], nodes["force"])
    return np.concatenate([nodes["strain"][:, :-1], *parts], axis=1)


class KeyholeBatch(CrawlerBatch):
    """A batch of crawlers that looks at each through a keyhole whenever it is observed.

    Attributes:
        keyhole: any but the index.
        view: (K, size) what is seen of each crawler now.
        final_view: (K, size) what was seen before `begin` last put crawlers to rest.
    """

    keyhole: str
    view: Frames
    final_view: Frames

    @classmethod
    def through(cls, keyhole: str, batch: CrawlerBatch) -> "KeyholeBatch":
        """The crawlers of a batch, which is not to be used any more, seen through a keyhole.

        Raises:
            ValueError: if there is no such keyhole.
        """
        made = cls.__new__(cls)
        made.__dict__.update(batch.__dict__)
        made.keyhole = keyhole
        shape = space(keyhole, batch.n_segments).shape
        made.view = np.zeros((batch.end.size, *shape), dtype=np.float32)
        made.final_view = made.view.copy()
        return made

    def begin(self, chosen: NDArray[np.bool_] | None = None) -> None:
        """Put crawlers to rest, all or the (K,) chosen ones, and look at those."""
        self.final_view, before = self.view.copy(), self.generators.copy()
        super().begin(chosen)
        self.see(before, np.ones(self.end.size), chosen)

    def decide(self, actions: object) -> int:
        """Decide as `CrawlerBatch.decide` does, and look."""
        before, intervals = self.generators.copy(), self.odometers["episode_intervals"].copy()
        resting = self.ended.copy()  # these are put to rest and observed once
        n_ended = super().decide(actions)
        observed = np.where(resting, 1.0, self.odometers["episode_intervals"] - intervals)
        self.see(before, observed)
        return n_ended

    def see(
        self, before: NDArray[np.uint64], observed: Array, which: NDArray[np.bool_] | None = None
    ) -> None:
        """Look at crawlers that have just been observed.

        Args:
            before: (K, 4) the generators before that.
            observed: (K,) how often each has been observed since; the last time counts.
            which: (K,) which crawlers; by default all.
        """
        if self.keyhole == STATE:
            self.report()
        errors = np.zeros((self.end.size, self.n_segments))
        if self.keyhole == STRAIN:
            draw_errors(before.copy(), observed, self._tasks[:, NOISE].copy(), errors)
        shown = look(self.keyhole, self.observation, self.nodes, errors)
        self.view = shown if which is None else np.where(which[:, None], shown, self.view)


@inner_kernel
def draw_errors(generators: NDArray[np.uint64], observed: Array, noise: Array, errors: Array) -> None:
    """Draw the errors of sensed strains again that the last of several observations has drawn.

    Args:
        generators: (K, 4) as they were before the first of these observations; moved on.
        observed: (K,) number of observations.
        noise: (K,) largest error; where it is 0 none was drawn, and `errors` stays as it is.
        errors: (K, N) filled.
    """
    n = errors.shape[1]
    for i in range(errors.shape[0]):
        if noise[i] > 0.0:
            for _ in range(int(observed[i] - 1.0) * n):
                random(generators[i])
            for j in range(n):
                errors[i, j] = noise[i] * (2.0 * random(generators[i]) - 1.0)
