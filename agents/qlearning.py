"""Tabular Q-learning, by hand, as in Mishra, van Rees & Mahadevan 2020 [M20, eq. 12].

    Q(o, a) <- (1 - alpha) Q(o, a) + alpha (r + gamma max_a' Q(o', a'))

The policy is greedy; what makes it explore is that all values start equal and high, so that an action that
has been tried disappoints, and another takes its turn.
"""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import ArrayLike, NDArray

from crawler_bench.envs.crawler import CrawlerEnv
from crawler_bench.envs.randomness import State, live_state, random
from crawler_bench.envs.transition import RUNNING, Memory, Task, begin, decide
from crawler_bench.physics.compilation import kernel

Callback = Callable[[dict[str, Any], dict[str, Any]], bool | None]

# Wrappers that gym.make adds and that change nothing: under them the compiled loop is the same loop.
_TRANSPARENT_WRAPPERS = (gym.wrappers.OrderEnforcing, gym.wrappers.PassiveEnvChecker)


@kernel
def greedy(values: NDArray[np.float64], rng: State) -> int:
    """Index of the highest of the values, ties broken at random (a tie of m takes m - 1 draws)."""
    best, index, ties = -np.inf, 0, 0
    for a in range(values.size):
        if values[a] > best:
            best, index, ties = values[a], a, 1
        elif values[a] == best:
            ties += 1
            if random(rng) * ties < 1.0:
                index = a
    return index


@kernel
def update(Q: NDArray[np.float64], o: int, a: int, target: float, alpha: float) -> None:
    """Move Q(o, a) towards the target r + gamma max_a' Q(o', a') [M20, eq. 12]."""
    Q[o, a] = (1.0 - alpha) * Q[o, a] + alpha * target


@kernel
def learn_on_crawler(
    Q: NDArray[np.float64],
    o: int,
    n_decisions: int,
    alpha: float,
    gamma: float,
    end_is_terminal: bool,
    rng: State,
    memory: Memory,
    task: Task,
    env_rng: State,
) -> int:
    """The loop of `QLearning.learn` on the crawler, compiled; gives the same Q to the last bit."""
    for _ in range(n_decisions):
        a = greedy(Q[o], rng)
        o_next, r, _, _, _, end = decide(memory, a, task, env_rng)
        ended = end != RUNNING  # by distance or time, which truncates: worth looking through
        update(Q, o, a, r + (0.0 if ended and end_is_terminal else gamma * Q[o_next].max()), alpha)
        o = begin(memory, task, env_rng) if ended else o_next
    return o


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
        self._prediction_rng = np.random.default_rng(
            tie_seed
        )  # asking for an action must not change learning
        self._observation: int | None = None
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
        self._observation = None

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

        if self.env is None:
            raise ValueError("this agent has no environment yet: call set_env first")
        if self._observation is None:
            first, _ = self.env.reset(seed=self._env_seed if self.num_timesteps == 0 else None)
            self._observation = int(first) - self._start(self.env.observation_space)
        loop = self._compiled_loop if self._runs_compiled() else self._plain_loop
        chunks = _chunks(self.num_timesteps, total_timesteps, self.CALLBACK_INTERVAL)
        for n_decisions in track(chunks, "learning", disable=not progress_bar):
            loop(n_decisions)
            self.num_timesteps += n_decisions
            if callback is not None and callback(locals(), globals()) is False:
                break
        return self

    def _plain_loop(self, n_decisions: int) -> None:
        """Eq. 12 on any environment, one step at a time."""
        assert self.env is not None
        assert self._observation is not None
        Q, alpha, gamma, o = self.q_table, self.learning_rate, self.discount, self._observation
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
        self._observation = o

    def _compiled_loop(self, n_decisions: int) -> None:
        assert self.env is not None
        crawler: Any = self.env.unwrapped
        self._observation = learn_on_crawler(
            self.q_table, self._observation or 0, n_decisions, self.learning_rate, self.discount,
            self.end_is_terminal, live_state(self.rng), crawler.memory, crawler.task, crawler.generator_state,
        )  # fmt: skip

    def _runs_compiled(self) -> bool:
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
        rng = live_state(self._prediction_rng)
        chosen = [greedy(self.q_table[o - start_o], rng) + start_a for o in seen.ravel()]
        return np.array(chosen, dtype=np.int64).reshape(seen.shape), state

    def save(self, path: str | Path) -> None:
        """Write everything that decides the future as JSON, a crawler in mid-episode included."""
        environment = self.env.unwrapped if self.env is not None else None
        content = {
            "agent": "qlearning",
            "learning_rate": self.learning_rate,
            "discount": self.discount,
            "initial_q": self.initial_q,
            "end_is_terminal": self.end_is_terminal,
            "seed": self.seed,
            "num_timesteps": self.num_timesteps,
            "policy": self.policy.tolist(),
            "q_table": self.q_table.tolist(),
            "generators": [self.rng.bit_generator.state, self._prediction_rng.bit_generator.state],
            "observation": self._observation,
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
            content = json.loads(Path(path).read_text())
            agent = cls(
                None, content["learning_rate"], content["discount"], content["initial_q"], content["seed"],
                end_is_terminal=content.get("end_is_terminal", False),
            )  # fmt: skip
            agent.q_table = np.array(content["q_table"], dtype=np.float64)
            agent.num_timesteps = content["num_timesteps"]
            agent.rng.bit_generator.state, agent._prediction_rng.bit_generator.state = content["generators"]
            observation, snapshot = content["observation"], content["environment"]
        except (json.JSONDecodeError, UnicodeDecodeError, KeyError, TypeError) as error:
            raise ValueError(f"{path} is not a saved Q-learning agent ({error!r})") from None
        if env is not None:
            agent.set_env(env)
            if snapshot is not None and isinstance(env.unwrapped, CrawlerEnv):
                env.reset()  # wrappers want one before the first step
                env.unwrapped.set_state(snapshot)
                agent._observation = observation
        return agent


def _number(name: str, value: Any) -> float:
    try:
        return float(value)
    except (TypeError, ValueError):
        raise ValueError(f"{name} = {value!r} is not possible: it must be a number") from None


def _chunks(done: int, total: int, interval: int) -> list[int]:
    """Split `total` decisions so that every chunk but the last ends on a multiple of the interval."""
    ends = [*range(interval - done % interval, total, interval), total] if total > 0 else []
    return [end - start for start, end in zip([0, *ends], ends, strict=False)]
