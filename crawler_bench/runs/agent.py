"""Agents: what the harness asks of one, and the class behind a name."""

import inspect
import re
from importlib import import_module
from typing import Any, Protocol, Self, cast

import numpy as np
from numpy.typing import NDArray

from crawler_bench.config.errors import ConfigError
from crawler_bench.config.files import agent_spec


class Agent(Protocol):
    """The interface of a Stable-Baselines3 agent, as far as training and evaluation use it."""

    def __init__(self, *, env: Any, seed: int | None, **settings: Any) -> None: ...

    def learn(self, total_timesteps: int, *, callback: Any, progress_bar: bool) -> Any:
        """Learn from more decisions; call `callback(locals(), globals())` now and then, the agent as self."""

    def predict(self, observation: Any, *, deterministic: bool) -> tuple[Any, Any]:
        """Actions for an array of observations, and the state of a policy with memory."""

    def save(self, path: Any) -> None:
        """Write the agent as one file."""

    @classmethod
    def load(cls, path: Any, env: Any) -> Self:
        """Read what `save` wrote."""


METHODS = ("learn", "predict", "save", "load")
LEARN_KEYWORDS = ("callback", "progress_bar")


def agent_class(name: str) -> type[Agent]:
    """Import the class of an agent.

    Args:
        name: a registered name or "module:Class".

    Raises:
        ConfigError: if no agent has that name, it cannot be imported, or it is not an agent.
    """
    spec = agent_spec(name)
    if not re.fullmatch(r"[^\W\d]\w*(\.[^\W\d]\w*)*:[^\W\d]\w*", spec):
        raise ConfigError(f"agent {spec!r} is not of the form module:Class")
    module, _, attribute = spec.partition(":")
    try:
        require_our_agents(module)
        found = getattr(import_module(module), attribute)
    except Exception as error:  # the module is the user's: anything can happen while it runs
        known = isinstance(error, ImportError | AttributeError | ConfigError)
        reason = str(error) if known else f"{type(error).__name__}: {error}"
        raise ConfigError(f"agent {spec!r} cannot be imported: {' '.join(reason.split())}") from None
    _require_agent(spec, found)
    return cast(type[Agent], found)


def require_our_agents(module: str) -> None:
    """Refuse another package called `agents` before its modules are looked for."""
    if module.partition(".")[0] != "agents":
        return
    agents = import_module("agents")
    if not hasattr(agents, "PROJECT"):
        raise ConfigError(
            f"the package 'agents' that Python finds is not crawler-bench's but {agents.__file__}; "
            "uninstall that one (it may be openai-agents) or use a fresh virtual environment"
        )


def _require_agent(spec: str, found: Any) -> None:
    if not isinstance(found, type):
        raise ConfigError(
            f"{spec!r} is not an agent: an agent is a class with {', '.join(METHODS)}, like "
            f"Stable-Baselines3's; this is a {type(found).__name__}"
        )
    if missing := [method for method in METHODS if not callable(getattr(found, method, None))]:
        raise ConfigError(
            f"{spec!r} is not an agent: an agent has {', '.join(METHODS)}; it has no {missing[0]}"
        )
    if missing := [keyword for keyword in LEARN_KEYWORDS if not _takes(found.learn, keyword)]:  # type: ignore[attr-defined]
        raise ConfigError(f"{spec!r} is not an agent: its learn must accept {' and '.join(missing)}")


def _takes(function: Any, keyword: str) -> bool:
    known = inspect.signature(function).parameters
    return keyword in known or any(each.kind is each.VAR_KEYWORD for each in known.values())


def is_stable_baselines(kind: type) -> bool:
    """Whether a class derives from Stable-Baselines3: it learns from many crawlers and saves an archive."""
    return any(base.__module__.startswith("stable_baselines3.") for base in kind.__mro__)


def ask(agent: Agent, observation: NDArray[Any], n_actions: int, **how: Any) -> tuple[NDArray[np.int64], Any]:
    """Ask an agent what it does.

    Args:
        agent: with `predict`.
        observation: K of them.
        n_actions: N.
        how: the arguments of `predict` beside the observations.

    Returns:
        (K,) actions, and the state that it returned.

    Raises:
        ConfigError: if it answers with something else than K actions, 0 to N - 1.
    """
    name, count = type(agent).__name__, len(observation)
    try:
        answered, state = agent.predict(observation, **how)
        actions = np.asarray(answered)
    except (TypeError, ValueError, IndexError, RuntimeError) as error:
        reason = " ".join(str(error).split())
        raise ConfigError(f"{name}.predict cannot take an array of {count} observations: {reason}") from error
    fits = actions.shape == (count,) and actions.dtype.kind in "iu"
    if not fits or actions.min() < 0 or actions.max() >= n_actions:
        raise ConfigError(
            f"{name}.predict, asked for {count} observations, must return {count} whole numbers from 0 to "
            f"{n_actions - 1}, not an array of shape {actions.shape} and type {actions.dtype}"
        )
    return np.asarray(actions, dtype=np.int64), state
