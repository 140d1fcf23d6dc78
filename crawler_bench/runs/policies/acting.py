"""How an agent is measured: as a table, where it is one, and otherwise by asking it at every decision."""

import inspect
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crawler_bench.config.errors import ConfigError
from crawler_bench.envs.keyholes import INDEX, space
from crawler_bench.gait.record import Array
from crawler_bench.runs.agent import Agent, ask
from crawler_bench.runs.policies.table import Mode, action_table

_MEMORY_ARGUMENTS = ("state", "episode_start")


class Acting:
    """An agent that is asked at every decision, with its state handed on.

    Args:
        agent: with Stable-Baselines3's `predict`.
        mode: "deterministic", the actions that it thinks best; "stochastic", those that it takes while it
            learns: drawn from its distribution, or its best ones but for the last exploration rate.
        n_actions: N.
        seed: of everything that is drawn.
    """

    def __init__(self, agent: Agent, mode: Mode, n_actions: int, seed: int) -> None:
        self.agent: Any = agent
        self.rate = getattr(agent, "exploration_rate", None) if mode == "stochastic" else None
        self.deterministic = mode == "deterministic" or self.rate is not None
        self.n_actions = n_actions
        self.rng = np.random.default_rng([seed, n_actions])
        self.keywords = _memory_arguments(agent)
        if hasattr(agent, "set_random_seed"):
            import torch

            torch.set_num_threads(1)  # small networks: threads would cost more than they do
            agent.set_random_seed(int(self.rng.integers(2**31)))

    def __call__(
        self, observation: NDArray[Any], state: Any, episode_start: NDArray[np.bool_]
    ) -> tuple[NDArray[np.int64], Any]:
        """Actions for K observations, and the state for the next ones.

        Raises:
            ConfigError: if the agent answers with something else than K actions, 0 to N - 1.
        """
        memory = {"state": state, "episode_start": episode_start}
        given = {name: memory[name] for name in self.keywords}
        actions, state = ask(
            self.agent, observation, self.n_actions, deterministic=self.deterministic, **given
        )
        if self.rate is not None:
            explores = self.rng.random(actions.size) < self.rate
            actions = np.where(explores, self.rng.integers(self.n_actions, size=actions.size), actions)
        return actions, state


def policy_of(agent: Agent, keyhole: str, mode: Mode, n_segments: int, seed: int) -> Array | Acting:
    """The (N, N) table of an agent that is one; for any other, how it acts.

    An agent on the index is a table unless its `predict` returns a state.

    Raises:
        ConfigError: if it cannot be measured, in one line that says why.
    """
    if keyhole == INDEX and not remembers(agent, n_segments):
        return action_table(agent, n_segments, mode)
    shown: Any = np.zeros(2, dtype=np.int64)
    if keyhole != INDEX:
        shown = np.zeros((2, *space(keyhole, n_segments).shape), dtype=np.float32)
    acting = Acting(agent, mode, n_segments, seed)
    _, state = acting(shown, None, np.ones(2, dtype=np.bool_))
    if state is not None and len(acting.keywords) < len(_MEMORY_ARGUMENTS):
        raise ConfigError(
            f"{type(agent).__name__}.predict returns a state but takes no state and episode_start: what it "
            "remembers cannot be handed on, so it cannot be measured"
        )
    return Acting(agent, mode, n_segments, seed)


def remembers(agent: Agent, n_segments: int) -> bool:
    """Whether an agent on the index has a memory: its `predict` returns a state.

    Raises:
        ConfigError: if it has one that it does not return: asked twice for its deterministic actions, it
            answers differently.
    """
    if any(getattr(agent, name, None) is not None for name in ("action_probabilities", "q_table")):
        return False
    observations = np.arange(n_segments)
    first, state = ask(agent, observations, n_segments, deterministic=True)
    if state is not None:
        return True
    if any((ask(agent, observations, n_segments, deterministic=True)[0] != first).any() for _ in range(3)):
        raise ConfigError(
            f"{type(agent).__name__}.predict, asked again for its deterministic actions, gives others and no "
            "state: a policy with a memory must return it as its state, or it cannot be measured"
        )
    return False


def _memory_arguments(agent: Agent) -> list[str]:
    """Which of `state` and `episode_start` the agent's `predict` takes."""
    known = inspect.signature(agent.predict).parameters
    if any(each.kind is each.VAR_KEYWORD for each in known.values()):
        return list(_MEMORY_ARGUMENTS)
    return [name for name in _MEMORY_ARGUMENTS if name in known]
