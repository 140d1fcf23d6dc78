"""Tabular Q-learning, by hand, as in Mishra, van Rees & Mahadevan 2020 [M20, eq. 12].

    Q(o, a) <- (1 - alpha) Q(o, a) + alpha (r + gamma max_a' Q(o', a'))

The policy is greedy; what makes it explore is that all values start equal and high, so that an action that
has been tried disappoints, and another takes its turn.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import ArrayLike, NDArray

from agents import saving
from agents.loop import greedy, learn_on_crawler, update
from crawler_bench.envs.crawler import CrawlerEnv
from crawler_bench.envs.randomness import live_state

Callback = Callable[[dict[str, Any], dict[str, Any]], bool | None]

# Wrappers that gym.make adds and that change nothing: under them the compiled loop is the same loop.
_TRANSPARENT_WRAPPERS = (gym.wrappers.OrderEnforcing, gym.wrappers.PassiveEnvChecker)


class QLearning:
    """A table of values, learned by eq. 12, with the interface of a Stable-Baselines3 agent.

    Args:
        env: any Gymnasium environment with Discrete observations and actions.
        learning_rate: alpha, in (0, 1].
        discount: gamma, in [0, 1).
        initial_q: the uniform, high value that every entry starts from.
        seed: of the agent's own generator and of the environment's first reset.
        end_is_terminal: a reading of the paper: no future is counted after the last decision of an episode,
            even of a truncated one. False looks through truncation, as crawling goes on for ever.
        compiled: use the compiled loop where the environment is the crawler; False is for comparison.

    Attributes:
        q_table: (observations, actions) values.
        num_timesteps: decisions learned from so far.
        observation: what it acts on next, counted from 0; None until the environment is reset.
    """

    CALLBACK_INTERVAL = 1000  # decisions between two calls of a callback

    def __init__(
        self,
        env: gym.Env[Any, Any] | None,
        learning_rate: float = 0.05,
        discount: float = 0.95,
        initial_q: float = 0.2,
        seed: int | None = None,
        *,
        end_is_terminal: bool = False,
        compiled: bool = True,
    ) -> None:
        learning_rate, discount = _number("learning_rate", learning_rate), _number("discount", discount)
        initial_q = _number("initial_q", initial_q)
        if not 0 < learning_rate <= 1:
            raise ValueError(f"learning_rate = {learning_rate!r} is not possible: it must be in (0, 1]")
        if not 0 <= discount < 1:
            raise ValueError(f"discount = {discount!r} is not possible: it must be in [0, 1)")
        if not np.isfinite(initial_q):
            raise ValueError(f"initial_q = {initial_q!r} is not possible: it must be a finite number")
        if not isinstance(end_is_terminal, bool):
            raise ValueError(
                f"end_is_terminal = {end_is_terminal!r} is not possible: it must be true or false"
            )
        self.learning_rate, self.discount, self.initial_q = learning_rate, discount, initial_q
        self.end_is_terminal = end_is_terminal
        self.seed, self.compiled = None if seed is None else int(seed), compiled
        self.num_timesteps = 0
        agent_seed, env_seed, tie_seed = np.random.SeedSequence(seed).spawn(3)
        self.rng = np.random.default_rng(agent_seed)
        self._env_seed = int(env_seed.generate_state(1)[0]) if seed is not None else None
        self.prediction_rng = np.random.default_rng(tie_seed)  # asking for an action leaves learning as it is
        self.observation: int | None = None
        self.q_table: NDArray[np.float64] = np.empty((0, 0))
        self.env: gym.Env[Any, Any] | None = None
        if env is not None:
            self.set_env(env)
            self.q_table = np.full(self._shape(env), float(initial_q))

    @staticmethod
    def _shape(env: gym.Env[Any, Any]) -> tuple[int, int]:
        spaces = env.observation_space, env.action_space
        if not (isinstance(spaces[0], gym.spaces.Discrete) and isinstance(spaces[1], gym.spaces.Discrete)):
            raise ValueError(
                f"a table needs Discrete spaces; this environment has {spaces[0]} and {spaces[1]}"
            )
        return int(spaces[0].n), int(spaces[1].n)

    def set_env(self, env: gym.Env[Any, Any]) -> None:
        """Learn in another environment of the same spaces from now on; it is reset first."""
        if self.q_table.size and self._shape(env) != self.q_table.shape:
            raise ValueError(f"the table is {self.q_table.shape}, the environment needs {self._shape(env)}")
        self._shape(env)
        self.env = env
        self.observation = None

    @property
    def policy(self) -> NDArray[np.int64]:
        """(observations,) the greedy action for each observation; the lowest of equal ones."""
        return np.asarray(self.q_table.argmax(axis=1), dtype=np.int64)

    def learn(
        self, total_timesteps: int, callback: Callback | None = None, progress_bar: bool = False
    ) -> "QLearning":
        """Learn from so many more decisions, going on where the last call stopped.

        Args:
            total_timesteps: number of decisions.
            callback: called as callback(locals, globals) every CALLBACK_INTERVAL decisions, the agent
                standing in locals["self"]; returning False stops the learning.
            progress_bar: show one.

        Returns:
            The agent itself.
        """
        from rich.progress import track

        chunks = self.start(total_timesteps)
        loop = self._compiled_loop if self.runs_compiled() else self._plain_loop
        for n_decisions in track(chunks, "learning", disable=not progress_bar):
            loop(n_decisions)
            if not self.count(n_decisions, callback):
                break
        return self

    def start(self, total_timesteps: int) -> list[int]:
        """Get ready to learn: reset the environment, unless in mid-episode.

        Returns:
            Numbers of decisions to learn from, from one call of a callback to the next.
        """
        if self.env is None:
            raise ValueError("this agent has no environment yet: call set_env first")
        if self.observation is None:
            first, _ = self.env.reset(seed=self._env_seed if self.num_timesteps == 0 else None)
            self.observation = int(first) - self._start(self.env.observation_space)
        return _chunks(self.num_timesteps, total_timesteps, self.CALLBACK_INTERVAL)

    def count(self, n_decisions: int, callback: Callback | None) -> bool:
        """Count decisions learned from and tell the callback; False if that stops the learning."""
        self.num_timesteps += n_decisions
        return callback is None or callback(locals(), globals()) is not False

    def _plain_loop(self, n_decisions: int) -> None:
        """Eq. 12 on any environment, one step at a time."""
        assert self.env is not None
        assert self.observation is not None
        Q, alpha, gamma, o = self.q_table, self.learning_rate, self.discount, self.observation
        rng = live_state(self.rng)
        first_o, first_a = self._start(self.env.observation_space), self._start(self.env.action_space)
        for _ in range(n_decisions):
            a = greedy(Q[o], rng)
            seen, r, terminated, truncated, _ = self.env.step(a + first_a)
            o_next = int(seen) - first_o
            no_future = terminated or (truncated and self.end_is_terminal)
            update(Q, o, a, float(r) + (0.0 if no_future else gamma * Q[o_next].max()), alpha)
            o = o_next
            if terminated or truncated:
                seen, _ = self.env.reset()
                o = int(seen) - first_o
        self.observation = o

    def _compiled_loop(self, n_decisions: int) -> None:
        assert self.env is not None
        crawler: Any = self.env.unwrapped
        self.observation = learn_on_crawler(
            self.q_table, self.observation or 0, n_decisions, self.learning_rate, self.discount,
            self.end_is_terminal, live_state(self.rng), crawler.memory, crawler.task, crawler.generator_state,
        )  # fmt: skip

    def runs_compiled(self) -> bool:
        """Whether the environment is the crawler itself, so that the compiled loop is the same loop."""
        env = self.env
        while isinstance(env, _TRANSPARENT_WRAPPERS):
            env = env.env
        return self.compiled and type(env) is CrawlerEnv and env.render_mode != "human"

    @staticmethod
    def _start(space: Any) -> int:
        return int(space.start)

    def predict(
        self,
        observation: ArrayLike,
        state: tuple[NDArray[Any], ...] | None = None,
        episode_start: NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[NDArray[np.int64], tuple[NDArray[Any], ...] | None]:
        """Act greedily on one observation or a batch of them.

        Args:
            observation: whole numbers of any shape.
            state: passed through; the policy has no memory.
            episode_start: ignored.
            deterministic: ignored; the greedy policy is, up to ties.

        Returns:
            Actions of the same shape, and the state.
        """
        start_o = self._start(self.env.observation_space) if self.env else 0
        start_a = self._start(self.env.action_space) if self.env else 0
        seen = np.asarray(observation, dtype=np.int64)
        rng = live_state(self.prediction_rng)
        chosen = [greedy(self.q_table[o - start_o], rng) + start_a for o in seen.ravel()]
        return np.array(chosen, dtype=np.int64).reshape(seen.shape), state

    def save(self, path: str | Path) -> None:
        """Write everything that decides the future as JSON, a crawler in mid-episode included."""
        saving.save(self, path)

    @classmethod
    def load(cls, path: str | Path, env: gym.Env[Any, Any] | None = None) -> "QLearning":
        """Read a saved agent; with a crawler as `env`, learning goes on bit by bit as if never stopped.

        Raises:
            ValueError: if the file holds no such agent.
        """
        return saving.load(cls, path, env)


def _number(name: str, value: Any) -> float:
    try:
        return float(value)
    except (TypeError, ValueError):
        raise ValueError(f"{name} = {value!r} is not possible: it must be a number") from None


def _chunks(done: int, total: int, interval: int) -> list[int]:
    """Split `total` decisions so that every chunk but the last ends on a multiple of the interval."""
    ends = [*range(interval - done % interval, total, interval), total] if total > 0 else []
    return [end - start for start, end in zip([0, *ends], ends, strict=False)]
