"""Tabular Q-learning, by hand, as in Mishra, van Rees & Mahadevan 2020 [M20, eq. 12].

    Q(o, a) <- (1 - alpha) Q(o, a) + alpha (r + gamma max_a' Q(o', a'))

The policy is greedy. It explores because all values start equal and high: an action that has been tried
disappoints, and another takes its turn.
"""

import json
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import ArrayLike, NDArray
from rich.progress import track

from agents.checked import checked_observation, checked_table, number, require
from agents.loop import greedy, learn_on_crawler, update
from agents.stepping import Environment, Step, crawler_in, require_single, reset, shape_of, start_of, step
from agents.watched import Callback, Watched
from crawler_bench.envs.crawler import CrawlerEnv
from crawler_bench.envs.randomness import live_state

# gym.make adds these, and they change nothing: under them the compiled loop is the same loop.
_TRANSPARENT_WRAPPERS = (gym.wrappers.OrderEnforcing, gym.wrappers.PassiveEnvChecker)
_SAVED = ("learning_rate", "discount", "initial_q", "seed", "end_is_terminal")


class QLearning(Watched):
    """A table of values, learned by eq. 12, with the interface of a Stable-Baselines3 agent.

    Args:
        env: any Gymnasium environment with Discrete observations and actions, or a vector of one of
            Stable-Baselines3.
        learning_rate: alpha, in (0, 1].
        discount: gamma, in [0, 1).
        initial_q: the uniform, high value that every entry starts from.
        seed: of the agent's own generator and of the environment's first reset.
        end_is_terminal: a reading of the paper: no future is counted after the last decision of an episode,
            even of a truncated one. False looks through truncation, as crawling goes on for ever.
        compiled: use the compiled loop where the environment is the crawler; False is for comparison.
        verbose: 1 logs on the screen, as Stable-Baselines3 does; learning then goes decision by decision.
        tensorboard_log: folder to log to, for TensorBoard; likewise.

    Attributes:
        q_table: (observations, actions) values.
        observation: what it acts on next, counted from 0; None until the environment is reset.
    """

    CALLBACK_INTERVAL = 1000  # decisions between two calls of a callback

    def __init__(
        self,
        env: Environment | None,
        learning_rate: float = 0.05,
        discount: float = 0.95,
        initial_q: float = 3.9,
        seed: int | None = None,
        *,
        end_is_terminal: bool = False,
        compiled: bool = True,
        verbose: int = 0,
        tensorboard_log: str | None = None,
    ) -> None:
        super().__init__(verbose, tensorboard_log)
        self.learning_rate = number("learning_rate", learning_rate, lambda x: 0 < x <= 1, "in (0, 1]")
        self.discount = number("discount", discount, lambda x: 0 <= x < 1, "in [0, 1)")
        self.initial_q = number("initial_q", initial_q, np.isfinite, "a finite number")
        for name, value in (("end_is_terminal", end_is_terminal), ("compiled", compiled)):
            require(isinstance(value, bool), name, value, "true or false")
        self.end_is_terminal, self.compiled = end_is_terminal, compiled
        self.seed = None if seed is None else int(seed)
        self.num_timesteps = 0
        agent_seed, env_seed, tie_seed = np.random.SeedSequence(seed).spawn(3)
        self.rng = np.random.default_rng(agent_seed)
        self._env_seed = int(env_seed.generate_state(1)[0]) if seed is not None else None
        self._rng_state = live_state(self.rng)
        self.prediction_rng = np.random.default_rng(tie_seed)  # asking for an action leaves learning as it is
        self.observation: int | None = None
        self.q_table: NDArray[np.float64] = np.empty((0, 0))
        self.env: Environment | None = None
        if env is not None:
            self.set_env(env)
            self.q_table = np.full(shape_of(env), self.initial_q)

    def set_env(self, env: Environment) -> None:
        """Learn in another environment of the same spaces from now on; it is reset first."""
        require_single(env)
        shape = shape_of(env)
        if self.q_table.size and shape != self.q_table.shape:
            raise ValueError(f"the table is {self.q_table.shape}, the environment needs {shape}")
        self.env, self._vec_env = env, None
        self.observation = None

    @property
    def observation_space(self) -> gym.spaces.Space[Any]:
        """Of the environment; without one, the rows of the table."""
        return (
            self.env.observation_space if self.env is not None else gym.spaces.Discrete(self.q_table.shape[0])
        )

    @property
    def action_space(self) -> gym.spaces.Space[Any]:
        """Of the environment; without one, the columns of the table."""
        return self.env.action_space if self.env is not None else gym.spaces.Discrete(self.q_table.shape[1])

    @property
    def policy(self) -> NDArray[np.int64]:
        """(observations,) the greedy action for each observation; the lowest of equal ones."""
        return np.asarray(self.q_table.argmax(axis=1), dtype=np.int64)

    def learn(
        self,
        total_timesteps: int,
        callback: Callback = None,
        log_interval: int | None = 4,
        tb_log_name: str = "QLearning",
        reset_num_timesteps: bool = False,
        progress_bar: bool = False,
    ) -> "QLearning":
        """Learn from more decisions, going on where the last call stopped.

        Args:
            total_timesteps: number of decisions.
            callback: a function, called as callback(locals(), globals()) every CALLBACK_INTERVAL decisions,
                with the agent in locals["self"]; returning False stops the learning. Or a callback of
                Stable-Baselines3, or a list of them, called at every decision.
            log_interval: episodes between two points of the log, if there is one; None for none.
            tb_log_name: of the run, in the folder `tensorboard_log`.
            reset_num_timesteps: count from 0 and reset the environment first; Stable-Baselines3 does by
                default.
            progress_bar: show one.

        Returns:
            The agent itself.
        """
        if reset_num_timesteps:
            self.num_timesteps, self.observation = 0, None
        in_mid_episode = self.observation is not None
        self._prepare()
        if self._is_watched(callback):
            self._learn_watched(
                total_timesteps, callback, log_interval, tb_log_name, reset_num_timesteps, progress_bar,
                in_mid_episode,
            )  # fmt: skip
            return self
        assert callback is None or callable(callback)
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
            first, self._env_seed = reset(self.env, self._env_seed), None  # which holds for one reset
            self.observation = int(first) - start_of(self.env.observation_space)
        self._rng_state = live_state(self.rng)
        shape = shape_of(self.env)
        self.q_table = np.ascontiguousarray(self.q_table, dtype=np.float64)
        if self.q_table.shape != shape:
            raise ValueError(f"the table is {self.q_table.shape}, the environment needs {shape}")
        self.observation = checked_observation(self.observation, shape[0])

    def _plain_loop(self, n_decisions: int) -> None:
        """Eq. 12 on any environment, one step at a time."""
        for _ in range(n_decisions):
            self._decide()

    def _decide(self) -> tuple[int, Step]:
        assert self.env is not None
        assert self.observation is not None
        Q, o = self.q_table, self.observation
        first_o, first_a = start_of(self.env.observation_space), start_of(self.env.action_space)
        a = greedy(Q[o], self._rng_state)
        made = step(self.env, a + first_a)
        o_next = int(made.outcome) - first_o
        no_future = made.terminated or (made.truncated and self.end_is_terminal)
        target = made.reward + (0.0 if no_future else self.discount * Q[o_next].max())
        update(Q, o, a, target, self.learning_rate)
        self.observation = int(made.observation) - first_o
        return a + first_a, made

    def _compiled_loop(self, n_decisions: int) -> None:
        assert self.env is not None
        assert self.observation is not None
        crawler: Any = self.env.unwrapped
        self.observation = learn_on_crawler(
            self.q_table, self.observation, n_decisions, self.learning_rate, self.discount,
            self.end_is_terminal, self._rng_state, crawler.memory, crawler.task, crawler.generator_state,
        )  # fmt: skip

    def _runs_compiled(self) -> bool:
        """Whether the environment is the crawler itself, so that the compiled loop is the same loop."""
        env: Any = self.env
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
        start_o = start_of(self.env.observation_space) if self.env is not None else 0
        start_a = start_of(self.env.action_space) if self.env is not None else 0
        seen = np.asarray(observation, dtype=np.int64)
        rng = live_state(self.prediction_rng)
        chosen = [greedy(self.q_table[o - start_o], rng) + start_a for o in seen.ravel()]
        return np.array(chosen, dtype=np.int64).reshape(seen.shape), state

    def save(self, path: str | Path) -> None:
        """Write everything that decides the future as JSON, a crawler in mid-episode included."""
        crawler = crawler_in(self.env)
        content = {
            "agent": "qlearning",
            **{name: getattr(self, name) for name in _SAVED},
            "num_timesteps": self.num_timesteps,
            "policy": self.policy.tolist(),
            "q_table": self.q_table.tolist(),
            "generators": [self.rng.bit_generator.state, self.prediction_rng.bit_generator.state],
            "observation": self.observation,
            "environment": None if crawler is None else crawler.get_state(),
        }
        Path(path).write_text(json.dumps(content, indent=1) + "\n")

    @classmethod
    def load(cls, path: str | Path, env: Environment | None = None) -> "QLearning":
        """Read a saved agent; with a crawler as `env`, learning goes on bit by bit as if never stopped.

        Raises:
            ValueError: if the file holds no such agent.
        """
        try:
            content = {"end_is_terminal": False} | json.loads(Path(path).read_text())
            agent = cls(None, **{name: content[name] for name in _SAVED})
            agent.q_table = checked_table(content["q_table"])
            agent.num_timesteps = int(content["num_timesteps"])
            agent._env_seed = None if agent.num_timesteps else agent._env_seed
            agent.rng.bit_generator.state, agent.prediction_rng.bit_generator.state = content["generators"]
            if env is not None:
                agent._go_on(env, content["observation"], content["environment"])
        except (ValueError, KeyError, TypeError, OverflowError) as error:
            what = error if isinstance(error, ValueError) else repr(error)
            raise ValueError(f"{path} is not a saved Q-learning agent: {what}") from None
        return agent

    def _go_on(self, env: Environment, observation: Any, snapshot: dict[str, Any] | None) -> None:
        """Put a crawler where the saved one was; any other environment starts from a reset."""
        self.set_env(env)
        crawler = crawler_in(env)
        if snapshot is not None and crawler is not None:
            reset(env)  # wrappers want one before the first step
            crawler.set_state(snapshot)
            if observation is not None:
                self.observation = checked_observation(observation, len(self.q_table))


def _chunks(done: int, total: int, interval: int) -> list[int]:
    """Split `total` decisions so that every chunk but the last ends on a multiple of the interval."""
    ends = [*range(interval - done % interval, total, interval), total] if total > 0 else []
    return [end - start for start, end in zip([0, *ends], ends, strict=False)]
