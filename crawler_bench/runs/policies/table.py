"""The whole policy of an agent, whoever learned it: with N observations and no memory it is a table."""

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from crawler_bench.config.errors import ConfigError
from crawler_bench.runs.agent import Agent, ask

Array = NDArray[np.float64]
Mode = Literal["deterministic", "stochastic"]

DRAWS = 2000  # at each observation, from a stochastic policy that does not tell its probabilities
ROUNDING = 1e-6  # of the sum of a row of probabilities, which a network computes in single precision


def action_table(agent: Agent, n_segments: int, mode: Mode = "deterministic") -> Array:
    """The policy of an agent as a table of probabilities.

    Args:
        agent: anything with `predict`, or with the attribute `action_probabilities`, which then is the answer
            in both modes.
        n_segments: N.
        mode: "deterministic", the action that the agent thinks best; "stochastic", the probabilities that it
            acts with while it learns: a policy network's, a value network's with the last exploration rate,
            the table's own, and for an agent that tells none of these the shares of DRAWS predictions.

    Returns:
        (N, N) probabilities of each action at each observation; every row sums to 1.

    Raises:
        ConfigError: if the agent answers with something else than actions, 0 to N - 1, or probabilities.
    """
    if (known := getattr(agent, "action_probabilities", None)) is not None:
        try:
            return probabilities(known, n_segments)
        except ValueError as error:
            raise ConfigError(f"{type(agent).__name__}.action_probabilities: {error}") from None
    observations = np.arange(n_segments)
    greedy = np.eye(n_segments)[ask(agent, observations, n_segments, deterministic=True)[0]]
    if mode == "deterministic" or hasattr(agent, "q_table"):
        return greedy
    network: Any = getattr(agent, "policy", None)
    if hasattr(network, "get_distribution"):
        distribution = network.get_distribution(network.obs_to_tensor(observations)[0]).distribution
        likely = distribution.probs.detach().numpy().astype(np.float64)
        return np.asarray(likely / likely.sum(axis=1, keepdims=True))
    if (rate := getattr(agent, "exploration_rate", None)) is not None:
        return np.asarray((1 - rate) * greedy + rate / n_segments)
    drawn, _ = ask(agent, np.repeat(observations, DRAWS), n_segments, deterministic=False)
    counted = drawn.reshape(n_segments, DRAWS)
    return np.array([np.bincount(row, minlength=n_segments) / DRAWS for row in counted])


def greedy_policy(agent: Agent, n_segments: int) -> Array | None:
    """The deterministic policy in the middle of learning.

    None where there is no such table, because the agent has a memory, or where asking might disturb the
    learning.
    """
    if (table := getattr(agent, "q_table", None)) is not None:
        return np.asarray(np.eye(n_segments)[table.argmax(axis=1)])
    if hasattr(agent, "action_probabilities"):
        return action_table(agent, n_segments)
    if not hasattr(getattr(agent, "policy", None), "obs_to_tensor"):
        return None
    actions, state = ask(agent, np.arange(n_segments), n_segments, deterministic=True)
    return np.asarray(np.eye(n_segments)[actions]) if state is None else None


def probabilities(table: Any, n_segments: int) -> Array:
    """Check that a table is a policy: (N, N) probabilities, each row with the sum 1.

    Raises:
        ValueError: if it is not.
    """
    try:
        checked = np.array(table, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        checked = np.empty(0)
    fits = checked.shape == (n_segments, n_segments) and n_segments >= 2
    fits = fits and bool(((checked >= 0) & (checked <= 1 + ROUNDING)).all())
    if not fits or np.abs(checked.sum(axis=1) - 1).max() > ROUNDING:
        raise ValueError(
            f"a policy is {n_segments} rows of {n_segments} probabilities, each row with the sum 1"
        )
    return checked
