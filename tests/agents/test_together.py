"""Agents that learn side by side against each of them alone."""

from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import crawler_bench
from agents.qlearning import QLearning
from agents.together import learn_together
from crawler_bench.envs.crawler import CrawlerEnv
from crawler_bench.physics.parameters import CrawlerParameters

SETTINGS: list[tuple[dict[str, Any], dict[str, Any]]] = [
    ({"regularization": 0.01}, {"seed": 1}),
    ({"regularization": 0.0, "noise": 0.1}, {"seed": 2, "learning_rate": 0.1}),
    ({"time_limit": 9.0}, {"seed": 3, "discount": 0.8, "end_is_terminal": True}),
    ({"parameters": CrawlerParameters(integrator="step"), "episode_distance": 0.05}, {"seed": 4}),
    ({}, {"seed": 1, "initial_q": 0.0}),
]


def team() -> list[QLearning]:
    return [QLearning(gym.make(crawler_bench.ENV_ID, **task), **settings) for task, settings in SETTINGS]


def assert_same(one: QLearning, other: QLearning) -> None:
    np.testing.assert_array_equal(one.q_table, other.q_table)
    assert one.num_timesteps == other.num_timesteps
    assert one.observation == other.observation
    assert one.rng.bit_generator.state == other.rng.bit_generator.state
    assert one.env is not None
    assert other.env is not None
    first, second = one.env.unwrapped, other.env.unwrapped
    assert isinstance(first, CrawlerEnv)
    assert isinstance(second, CrawlerEnv)
    assert first.get_state() == second.get_state()
    assert first.lifetime == second.lifetime
    np.testing.assert_array_equal(first.memory, second.memory)


@pytest.mark.parametrize("threads", [1, 2, 7])
def test_each_learns_as_if_alone_to_the_bit(threads: int) -> None:
    together, alone = team(), team()
    for agents in (together, alone):
        agents[1].learn(333)  # so that its callbacks come at other times
    learn_together(together, 2500, threads=threads)
    learn_together(together, 700, threads=threads)
    for one, other in zip(together, alone, strict=True):
        assert_same(one, other.learn(2500).learn(700))


def test_callbacks_are_told_and_stop_their_own_agent() -> None:
    def recorder(seen: list[tuple[int, float]], last: int) -> Any:
        def callback(local: dict[str, Any], _global: dict[str, Any]) -> bool:
            agent = local["self"]
            seen.append((agent.num_timesteps, agent.q_table.sum() + sum(agent.env.unwrapped.lifetime)))
            return len(seen) < last

        return callback

    together, alone = team(), team()
    for agents in (together, alone):
        agents[1].learn(333)
    seen: list[list[tuple[int, float]]] = [[] for _ in together]
    expected: list[list[tuple[int, float]]] = [[] for _ in together]
    stops = [9, 9, 2, 1, 9]
    learn_together(together, 3500, [recorder(*each) for each in zip(seen, stops, strict=True)])
    for i, agent in enumerate(alone):
        agent.learn(3500, callback=recorder(expected[i], stops[i]))
        assert_same(together[i], agent)
    assert seen == expected
    assert [done for done, _ in seen[1]] == [1000, 2000, 3000, 3833]
    assert [agent.num_timesteps for agent in together] == [3500, 3833, 2000, 1000, 3500]


def test_what_cannot_learn_together_is_refused() -> None:
    env = CrawlerEnv()
    with pytest.raises(ValueError, match="need a crawler each"):
        learn_together([QLearning(env, seed=0), QLearning(env, seed=1)], 10)
    with pytest.raises(ValueError, match="same number of segments"):
        learn_together([QLearning(env), QLearning(CrawlerEnv(CrawlerParameters(n_segments=5)))], 10)
    with pytest.raises(ValueError, match="on crawlers only"):
        learn_together([QLearning(gym.wrappers.TransformReward(CrawlerEnv(), float))], 10)
    with pytest.raises(ValueError, match="1 callbacks for 2 agents"):
        learn_together([QLearning(env), QLearning(CrawlerEnv())], 10, [None])
