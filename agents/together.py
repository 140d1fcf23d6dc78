"""Several Q-learning agents side by side, each on a crawler of its own, in one compiled call.

Every agent ends up as if it had learned alone, to the last bit: nothing is shared but the call.
"""

import itertools
from collections.abc import Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from typing import Any

import numpy as np
from numpy.typing import NDArray

from agents.loop import learn_on_crawlers
from agents.qlearning import Callback, QLearning
from crawler_bench.envs.randomness import live_state


def learn_together(
    agents: Sequence[QLearning],
    total_timesteps: int,
    callbacks: Sequence[Callback | None] | None = None,
    threads: int = 1,
) -> None:
    """Let every agent learn from so many more decisions, as its own `learn` would.

    Args:
        agents: K agents on K crawlers; all crawlers with the same number of segments.
        total_timesteps: number of decisions of each agent.
        callbacks: one for each agent, as for `QLearning.learn`; one that returns False stops its own agent.
        threads: among which the agents are divided.

    Raises:
        ValueError: if an agent has no crawler of its own, a wrapper of unknown effect stands round it, or
            there are not as many callbacks as agents.
    """
    _require_crawlers(agents)
    callbacks = [None] * len(agents) if callbacks is None else callbacks
    if len(callbacks) != len(agents):
        raise ValueError(f"there are {len(callbacks)} callbacks for {len(agents)} agents")
    plans = [agent.start(total_timesteps) for agent in agents]
    goes_on = np.ones(len(agents), dtype=bool)
    with ThreadPoolExecutor(threads) as pool:
        for chunk in itertools.zip_longest(*plans, fillvalue=0):
            n_decisions = np.where(goes_on, np.array(chunk, dtype=np.int64), 0)
            _learn(agents, n_decisions, pool, threads)
            for i in n_decisions.nonzero()[0].tolist():
                goes_on[i] = agents[i].count(int(n_decisions[i]), callbacks[i])
            if not goes_on.any():
                break


def _require_crawlers(agents: Sequence[QLearning]) -> None:
    for agent in agents:
        if not agent.runs_compiled():
            raise ValueError(f"agents learn together on crawlers only, not on {agent.env}")
    if len({id(_crawler(agent)) for agent in agents}) < len(agents):
        raise ValueError("agents that learn together need a crawler each")
    if len({agent.q_table.shape for agent in agents}) > 1:
        raise ValueError("agents that learn together need crawlers of the same number of segments")


def _crawler(agent: QLearning) -> Any:
    assert agent.env is not None
    return agent.env.unwrapped


def _learn(agents: Sequence[QLearning], n_decisions: NDArray[np.int64], pool: Executor, threads: int) -> None:
    """Collect what every agent and crawler is, let the compiled loop change it, and give it back."""
    crawlers = [_crawler(agent) for agent in agents]
    q_tables = np.array([agent.q_table for agent in agents])
    observations = np.array([agent.observation or 0 for agent in agents], dtype=np.int64)
    generators = np.array([live_state(agent.rng) for agent in agents])
    memories = np.array([crawler.memory for crawler in crawlers])
    env_generators = np.array([crawler.generator_state for crawler in crawlers])
    rows: tuple[Any, ...] = (
        q_tables,
        observations,
        n_decisions,
        np.array([agent.learning_rate for agent in agents]),
        np.array([agent.discount for agent in agents]),
        np.array([agent.end_is_terminal for agent in agents]),
        generators,
        memories,
        np.array([crawler.task for crawler in crawlers]),
        env_generators,
    )
    bounds = [len(agents) * part // threads for part in range(threads + 1)]
    parts = [slice(start, end) for start, end in itertools.pairwise(bounds)]
    list(pool.map(lambda part: learn_on_crawlers(*(row[part] for row in rows)), parts))
    for i, (agent, crawler) in enumerate(zip(agents, crawlers, strict=True)):
        agent.q_table[:] = q_tables[i]
        agent.observation = int(observations[i])
        live_state(agent.rng)[:] = generators[i]
        crawler.memory[:] = memories[i]
        crawler.generator_state[:] = env_generators[i]
