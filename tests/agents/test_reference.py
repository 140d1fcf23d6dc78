"""The policies that do not learn, and the interface of all agents."""

from pathlib import Path

import numpy as np
import pytest

from crawler_bench.config.files import AGENTS
from crawler_bench.envs.crawler import CrawlerEnv
from crawler_bench.physics.parameters import CrawlerParameters
from crawler_bench.runs.agent import agent_class


@pytest.mark.parametrize("name", sorted(AGENTS))
def test_every_registered_agent_has_the_whole_interface(name: str, tmp_path: Path) -> None:
    env = CrawlerEnv()
    agent = agent_class(name)(env, seed=0)
    agent.learn(100)
    actions, _ = agent.predict(np.arange(10), state=None, episode_start=None, deterministic=True)
    assert actions.shape == (10,)
    agent.save(tmp_path / "agent.json")
    loaded = agent_class(name).load(tmp_path / "agent.json", env=env)
    assert loaded.num_timesteps == agent.num_timesteps >= 100  # PPO learns whole rollouts
    first, again = (each.predict(np.arange(10), deterministic=True)[0] for each in (agent, loaded))
    np.testing.assert_array_equal(first, again)


def test_random_is_uniform_and_seeded() -> None:
    env = CrawlerEnv()
    actions = agent_class("random")(env, seed=0).predict(np.zeros(20_000, dtype=int))[0]
    counts = np.bincount(actions, minlength=10)
    assert counts.min() > 1850
    assert counts.max() < 2150
    np.testing.assert_array_equal(
        actions[:50], agent_class("random")(env, seed=0).predict(np.zeros(50, dtype=int))[0]
    )


def test_wave_is_the_diagonal() -> None:
    assert agent_class("wave")(CrawlerEnv()).predict(np.arange(10))[0].tolist() == list(range(10))


def test_still_stands_still() -> None:
    env = CrawlerEnv()
    agent = agent_class("still")(env)
    observation, _ = env.reset(seed=0)
    places = []
    for _ in range(1000):
        observation, *_, info = env.step(int(agent.predict(observation)[0]))
        places.append(info["centroid"])
    assert places[-1] - places[500] < 1e-3
    eleven = CrawlerEnv(CrawlerParameters(n_segments=11))
    middle = agent_class("still")(env=eleven, seed=None).predict(np.arange(11), deterministic=True)[0]
    np.testing.assert_array_equal(middle, 10 - middle)  # as far from the head's end as from the tail's
