"""Tabular Q-learning, by hand, as in Mishra, van Rees & Mahadevan 2020 [M20, eq. 12].

    Q(o, a) <- (1 - alpha) Q(o, a) + alpha (r + gamma max_a' Q(o', a'))

The policy is greedy. It explores because all values start equal and high: an action that has been tried
disappoints, and another takes its turn.
"""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import ArrayLike, NDArray

from agents.loop import greedy, learn_on_crawler, update
from crawler_bench.envs.crawler import CrawlerEnv
from crawler_bench.envs.randomness import live_state

Callback = Callable[[dict[str, Any], dict[str, Any]], bool | None]

# Wrappers that gym.make adds and that change nothing: under them the compiled loop is the same loop.
_TRANSPARENT_WRAPPERS = (gym.wrappers.OrderEnforcing, gym.wrappers.PassiveEnvChecker)
_SAVED = ("learning_rate", "discount", "initial_q", "seed", "end_is_terminal")


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
        self.learning_rate = _number("learning_rate", learning_rate, lambda x: 0 < x <= 1, "in (0, 1]")
        self.discount = _number("discount", discount, lambda x: 0 <= x < 1, "in [0, 1)")
        self.initial_q = _number("initial_q", initial_q, np.isfinite, "a finite number")
        for name, value in (("end_is_terminal", end_is_terminal), ("compiled", compiled)):
            _require(isinstance(value, bool), name, value, "true or false")
        self.end_is_terminal, self.compiled = end_is_terminal, compiled
        self.seed = None if seed is None else int(seed)
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
            self.q_table = np.full(_shape(env), self.initial_q)

    def set_env(self, env: gym.Env[Any, Any]) -> None:
        """Learn in another environment of the same spaces from now on; it is reset first."""
        shape = _shape(env)
        if self.q_table.size and shape != self.q_table.shape:
            raise ValueError(f"the table is {self.q_table.shape}, the environment needs {shape}")
        self.env = env
        self.observation = None

    @property
    def policy(self) -> NDArray[np.int64]:
        """(observations,) the greedy action for each observation; the lowest of equal ones."""
        return np.asarray(self.q_table.argmax(axis=1), dtype=np.int64)

    def learn(
        self, total_timesteps: int, callback: Callback | None = None, progress_bar: bool = False
    ) -> "QLearning":
        """Learn from more decisions, going on where the last call stopped.

        Args:
            total_timesteps: number of decisions.
            callback: called as callback(locals, globals) every CALLBACK_INTERVAL decisions, with the agent
                in locals["self"]; returning False stops the learning.
            progress_bar: show one.

        Returns:
            The agent itself.
        """
        from rich.progress import track

        self._prepare()
        chunks = _chunks(self.num_timesteps, total_timesteps, self.CALLBACK_INTERVAL)
        loop = self._compiled_loop if self._runs_compiled() else self._plain_loop
        for n_decisions in track(chunks, "learning", disable=not progress_bar):
            loop(n_decisions)
            self.num_timesteps += n_decisions
            if callback is not None and callback(locals(), globals()) is False:
                break
        return self

    def _prepare(self) -> None:
        """Reset the environment, unless in mid-episode, and check what compiled loops take on trust.

        Raises:
            ValueError: if there is no environment, or the table or the observation does not fit it.
        """
        if self.env is None:
            raise ValueError("this agent has no environment yet: call set_env first")
        if self.observation is None:
            first, _ = self.env.reset(seed=self._env_seed if self.num_timesteps == 0 else None)
            self.observation = int(first) - _start(self.env.observation_space)
        shape = _shape(self.env)
        self.q_table = np.ascontiguousarray(self.q_table, dtype=np.float64)
        if self.q_table.shape != shape:
            raise ValueError(f"the table is {self.q_table.shape}, the environment needs {shape}")
        self.observation = _checked_observation(self.observation, shape[0])

    def _plain_loop(self, n_decisions: int) -> None:
        """Eq. 12 on any environment, one step at a time."""
        assert self.env is not None
        assert self.observation is not None
        Q, alpha, gamma, o = self.q_table, self.learning_rate, self.discount, self.observation
        rng = live_state(self.rng)
        first_o, first_a = _start(self.env.observation_space), _start(self.env.action_space)
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
        assert self.observation is not None
        crawler: Any = self.env.unwrapped
        self.observation = learn_on_crawler(
            self.q_table, self.observation, n_decisions, self.learning_rate, self.discount,
            self.end_is_terminal, live_state(self.rng), crawler.memory, crawler.task, crawler.generator_state,
        )  # fmt: skip

    def _runs_compiled(self) -> bool:
        """Whether the environment is the crawler itself, so that the compiled loop is the same loop."""
        env = self.env
        while isinstance(env, _TRANSPARENT_WRAPPERS):
            env = env.env
        return self.compiled and type(env) is CrawlerEnv and env.render_mode != "human"

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
        start_o = _start(self.env.observation_space) if self.env else 0
        start_a = _start(self.env.action_space) if self.env else 0
        seen = np.asarray(observation, dtype=np.int64)
        rng = live_state(self.prediction_rng)
        chosen = [greedy(self.q_table[o - start_o], rng) + start_a for o in seen.ravel()]
        return np.array(chosen, dtype=np.int64).reshape(seen.shape), state

    def save(self, path: str | Path) -> None:
        """Write everything that decides the future as JSON, a crawler in mid-episode included."""
        environment = self.env.unwrapped if self.env is not None else None
        content = {
            "agent": "qlearning",
            **{name: getattr(self, name) for name in _SAVED},
            "num_timesteps": self.num_timesteps,
            "policy": self.policy.tolist(),
            "q_table": self.q_table.tolist(),
            "generators": [self.rng.bit_generator.state, self.prediction_rng.bit_generator.state],
            "observation": self.observation,
            "environment": environment.get_state() if isinstance(environment, CrawlerEnv) else None,
        }
        Path(path).write_text(json.dumps(content, indent=1) + "\n")

    @classmethod
    def load(cls, path: str | Path, env: gym.Env[Any, Any] | None = None) -> "QLearning":
        """Read a saved agent; with a crawler as `env`, learning goes on bit by bit as if never stopped.

        Raises:
            ValueError: if the file holds no such agent.
        """
        try:
            content = {"end_is_terminal": False} | json.loads(Path(path).read_text())
            agent = cls(None, **{name: content[name] for name in _SAVED})
            agent.q_table = _checked_table(content["q_table"])
            agent.num_timesteps = int(content["num_timesteps"])
            agent.rng.bit_generator.state, agent.prediction_rng.bit_generator.state = content["generators"]
            if env is not None:
                agent._go_on(env, content["observation"], content["environment"])
        except (ValueError, KeyError, TypeError, OverflowError) as error:
            what = error if isinstance(error, ValueError) else repr(error)
            raise ValueError(f"{path} is not a saved Q-learning agent: {what}") from None
        return agent

    def _go_on(self, env: gym.Env[Any, Any], observation: Any, snapshot: dict[str, Any] | None) -> None:
        """Put a crawler where the saved one was; any other environment starts from a reset."""
        self.set_env(env)
        if snapshot is not None and isinstance(env.unwrapped, CrawlerEnv):
            env.reset()  # wrappers want one before the first step
            env.unwrapped.set_state(snapshot)
            if observation is not None:
                self.observation = _checked_observation(observation, len(self.q_table))


def _shape(env: gym.Env[Any, Any]) -> tuple[int, int]:
    observations, actions = env.observation_space, env.action_space
    if not (isinstance(observations, gym.spaces.Discrete) and isinstance(actions, gym.spaces.Discrete)):
        raise ValueError(f"a table needs Discrete spaces; this environment has {observations} and {actions}")
    return int(observations.n), int(actions.n)


def _start(space: Any) -> int:
    return int(space.start)


def _require(condition: Any, name: str, value: Any, allowed: str) -> None:
    if not condition:
        raise ValueError(f"{name} = {value!r} is not possible: it must be {allowed}")


def _number(name: str, value: Any, possible: Callable[[float], Any], allowed: str) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = np.nan
    _require(possible(number), name, value, allowed)
    return number


def _checked_table(values: Any) -> NDArray[np.float64]:
    table = np.array(values, dtype=np.float64)
    if table.ndim != 2 or not table.size or not np.isfinite(table).all():
        raise ValueError("q_table must be rows of equally many finite numbers")
    return table


def _checked_observation(observation: Any, n_observations: int) -> int:
    whole = isinstance(observation, int | np.integer) and not isinstance(observation, bool)
    fits = whole and 0 <= observation < n_observations
    _require(fits, "observation", observation, f"a whole number from 0 to {n_observations - 1}")
    return int(observation)


def _chunks(done: int, total: int, interval: int) -> list[int]:
    """Split `total` decisions so that every chunk but the last ends on a multiple of the interval."""
    ends = [*range(interval - done % interval, total, interval), total] if total > 0 else []
    return [end - start for start, end in zip([0, *ends], ends, strict=False)]
