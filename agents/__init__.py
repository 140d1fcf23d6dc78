"""Learners and reference policies for the crawler.

An agent is a class with the interface of a Stable-Baselines3 agent: `Agent(env, ..., seed)`, `learn`,
`predict`, `save` and `load`. It is named by a registered name or, anyone's, as "module:Class".
"""

from importlib.metadata import entry_points
from typing import Any

ENTRY_POINT_GROUP = "crawler_bench.agents"

REGISTRY = {
    "qlearning": "agents.qlearning:QLearning",
    "dqn": "agents.dqn:DQN",
    "ppo": "agents.ppo:PPO",
    "random": "agents.reference:Random",
    "still": "agents.reference:Still",
    "wave": "agents.reference:Wave",
}


def registered() -> dict[str, str]:
    """Every known agent, ours and those of installed packages: name to "module:Class"."""
    return REGISTRY | {point.name: point.value for point in entry_points(group=ENTRY_POINT_GROUP)}


def agent_spec(name: str) -> str:
    """Turn the name of an agent into its "module:Class"; a "module:Class" stays as it is.

    Raises:
        ValueError: if no agent has that name.
    """
    known = registered()
    if name not in known and ":" not in name:
        raise ValueError(
            f"no agent is called {name!r}; there are {', '.join(known)}, or name your own module:Class"
        )
    return known.get(name, name)


def agent_class(name: str) -> Any:
    """Import the class of an agent.

    Raises:
        ValueError: if it cannot be found.
    """
    from crawler_bench.config.schema import import_agent  # imported late: a learner needs no configuration

    return import_agent(agent_spec(name))
