"""Many crawlers as a Gymnasium vector environment."""

from collections.abc import Sequence
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.envs.registration import EnvSpec
from gymnasium.error import ResetNeeded
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from crawler_bench.envs.arguments import require_count
from crawler_bench.envs.batch import CENTROID, DISPLACED, GRADIENT, REWARD, CrawlerBatch
from crawler_bench.envs.specification import with_longest_episode
from crawler_bench.physics.parameters import CrawlerParameters

Info = dict[str, Any]
Mask = NDArray[np.bool_]


class CrawlerVectorEnv(VectorEnv[Any, Any, Any]):
    """K crawlers, stepped in one compiled call; see `CrawlerEnv` for what each of them is.

    `parameters` and the four numbers of the task may be given once for all or as a sequence, one for each
    crawler; the number of segments must be the same. It gives what Gymnasium's `SyncVectorEnv` of K
    `CrawlerEnv` with the same arguments gives, infos and their `_key` masks included; crawler i with seed s
    gives the numbers of a `CrawlerEnv` with seed s.

    `gym.make_vec("crawler_bench/Crawler-v0", num_envs=256)` makes one.

    Args:
        num_envs: K.
        parameters: of the bodies.
        regularization: epsilon of eq. 11, at least 0.
        noise: largest error of a sensed strain, at least 0.
        episode_distance: L, above 0.
        time_limit: tau_theta, above 0.
        render_mode: None or "rgb_array".
        autoreset_mode: when a crawler whose episode has ended is reset: with the next step, within the same
            step (its last observation and info then stand in `infos["final_obs"]` and `infos["final_info"]`),
            or by `reset(options={"reset_mask": ended})` alone.
        max_episode_steps: decisions after which an episode is truncated, as `gym.make` does for one crawler.

    Raises:
        ValueError: if an argument is not possible.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012 (Gymnasium declares it as an attribute of instances)
        "autoreset_mode": AutoresetMode.NEXT_STEP, "render_modes": ["rgb_array"], "render_fps": 25,
    }  # fmt: skip

    def __init__(
        self,
        num_envs: int = 1,
        parameters: CrawlerParameters | Sequence[CrawlerParameters] | None = None,
        regularization: float | Sequence[float] = 0.01,
        noise: float | Sequence[float] = 0.0,
        episode_distance: float | Sequence[float] = 8.83,
        time_limit: float | Sequence[float] = 4000.0,
        render_mode: str | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        max_episode_steps: int | None = None,
    ) -> None:
        if render_mode not in (None, "rgb_array"):
            raise ValueError(
                f"render_mode = {render_mode!r} is not possible: it must be None or 'rgb_array'; "
                "gymnasium.wrappers.vector.HumanRendering shows that in a window"
            )
        if max_episode_steps is not None:
            require_count("max_episode_steps", max_episode_steps)
        self.autoreset_mode = _autoreset_mode(autoreset_mode)
        self.metadata = type(self).metadata | {"autoreset_mode": self.autoreset_mode}
        self.crawlers = CrawlerBatch(
            parameters if parameters is not None else CrawlerParameters(), num_envs,
            regularization, noise, episode_distance, time_limit, max_episode_steps,
        )  # fmt: skip
        self.num_envs, self.render_mode = num_envs, render_mode
        n = self.crawlers.n_segments
        self.single_observation_space = gym.spaces.Discrete(n)
        self.single_action_space = gym.spaces.Discrete(n)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._intervals = np.array([each.decision_interval for each in self.crawlers.parameters])
        self._seeded = False

    @property
    def spec(self) -> EnvSpec | None:
        """As `gym.make_vec` has set it, with the longest episode of any crawler in it."""
        return self._spec

    @spec.setter
    def spec(self, spec: EnvSpec | None) -> None:
        self._spec = with_longest_episode(spec, self.crawlers.most_decisions, in_kwargs=True)

    _spec: EnvSpec | None = None

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.int64], Info]:
        """Put crawlers to rest.

        Args:
            seed: one for each crawler, or the first of K successive ones, or None to go on drawing.
            options: with a (K,) mask as "reset_mask", only these crawlers are reset.

        Raises:
            ValueError: if there are not K seeds, or not K values in the mask, or none of them is True.
            TypeError: if the mask is not an array of booleans.
            ResetNeeded: if a mask leaves out crawlers that have never been reset.
        """
        mask = self._reset_mask(options or {})
        if seed is None and not self._seeded:
            seed = int(np.random.SeedSequence().generate_state(1)[0])
        if seed is not None:
            seeds: list[int | None] = (
                list(range(seed, seed + self.num_envs)) if isinstance(seed, int | np.integer) else list(seed)
            )
            if len(seeds) != self.num_envs:
                raise ValueError(f"{len(seeds)} seeds for {self.num_envs} crawlers")
            super().reset(seed=seeds[0])
            self.crawlers.seed([each if chosen else None for each, chosen in zip(seeds, mask, strict=True)])
            self._seeded = True
        self.crawlers.begin(mask)
        return self.crawlers.observation.copy(), self._infos(mask)

    def step(self, actions: Any) -> tuple[NDArray[np.int64], NDArray[np.float64], Mask, Mask, Info]:
        """Hold one neuron of each crawler ON for a decision interval.

        Raises:
            ValueError: if the actions are not K neurons, 0 to N - 1.
            ResetNeeded: before the first reset; with autoreset mode DISABLED also for an episode that has
                ended.
        """
        crawlers = self.crawlers
        if self.autoreset_mode == AutoresetMode.DISABLED and crawlers.ended.any():
            over = crawlers.ended.nonzero()[0].tolist()
            raise ResetNeeded(
                f"the episodes of the crawlers {over} have ended: reset them, options={{'reset_mask': ...}}"
            )
        n_ended = crawlers.decide(actions)
        crawlers.report()
        truncated, rewards = crawlers.ended.copy(), crawlers.outcome[:, REWARD].copy()
        final: Info = {}
        if n_ended and self.autoreset_mode == AutoresetMode.SAME_STEP:
            final = self._final(truncated)
            crawlers.begin(truncated)
        terminated = np.zeros(self.num_envs, dtype=np.bool_)
        infos = self._infos(np.ones(self.num_envs, dtype=np.bool_)) | final
        return crawlers.observation.copy(), rewards, terminated, truncated, infos

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """Draw every crawler as `CrawlerEnv.render` does.

        Returns:
            K pictures of shape (height, width, 3), which Gymnasium's wrappers tile, or None without a render
            mode.
        """
        if self.render_mode is None:
            gym.logger.warn('render() needs a render mode: gym.make_vec(..., render_mode="rgb_array")')
            return None
        return self.crawlers.draw()

    def _reset_mask(self, options: dict[str, Any]) -> Mask:
        """The crawlers to reset, checked as `SyncVectorEnv` checks it."""
        if "reset_mask" not in options:
            return np.ones(self.num_envs, dtype=np.bool_)
        mask, name = options["reset_mask"], "`options['reset_mask']` must"
        if not isinstance(mask, np.ndarray):
            raise TypeError(f"{name} be a numpy array, got {type(mask)}")
        if mask.shape != (self.num_envs,):
            raise ValueError(f"{name} have shape `({self.num_envs},)`, got {mask.shape}")
        if mask.dtype != np.bool_:
            raise TypeError(f"{name} have `dtype=np.bool_`, got {mask.dtype}")
        if not mask.any():
            raise ValueError(
                f"{name} contain a boolean array with at least one True value, got reset_mask={mask}"
            )
        if not (mask.all() or self.crawlers.begun):
            raise ResetNeeded("the first reset must be of all crawlers")
        return mask

    def _infos(self, mask: Mask) -> Info:
        """What `SyncVectorEnv` makes of the infos of some crawlers: zeros for the others, and masks."""
        crawlers = self.crawlers
        nodes, outcome = crawlers.nodes, crawlers.outcome
        values = {
            "time": crawlers.odometers["episode_intervals"] * self._intervals,
            "centroid": outcome[:, CENTROID].copy(),
            "displacement": outcome[:, DISPLACED].copy(),
            "strain_gradient": outcome[:, GRADIENT].copy(),
            "strain": nodes["strain"][:, :-1].copy(),
            "muscle_force": nodes["force"].copy(),
            "node_velocity": nodes["velocity"].copy(),
            "power": nodes["power"].copy(),
            "end": crawlers.end.copy(),
        }
        infos: Info = {}
        for key, value in values.items():
            value[~mask] = 0
            infos[key], infos[f"_{key}"] = value, mask.copy()
        return infos

    def _final(self, ended: Mask) -> Info:
        observations = np.full(self.num_envs, None, dtype=object)
        observations[ended] = self.crawlers.observation[ended]
        return {
            "final_obs": observations, "_final_obs": ended.copy(),
            "final_info": self._infos(ended), "_final_info": ended.copy(),
        }  # fmt: skip


def _autoreset_mode(given: AutoresetMode | str) -> AutoresetMode:
    try:
        return AutoresetMode(given)
    except ValueError:
        names = ", ".join(repr(mode.value) for mode in AutoresetMode)
        raise ValueError(f"autoreset_mode = {given!r} is not possible: it must be one of {names}") from None
