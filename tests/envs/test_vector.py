"""The vector environment against the single one: the same crawlers, however they are stepped."""

from dataclasses import replace
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

import crawler_bench
from crawler_bench.envs.crawler import CrawlerEnv
from crawler_bench.envs.vector import CrawlerVectorEnv
from crawler_bench.physics import CrawlerParameters

BODIES = [
    CrawlerParameters(),
    CrawlerParameters(damping=2.0, tau_f=0.5),
    CrawlerParameters(head_muscle="external", spike_phase="2pi"),
    CrawlerParameters(observation="most_stretched", decision_interval=0.3),
]
# Goals near enough, and times short enough, that some episodes end in either way.
SETTINGS: dict[str, list[float]] = {
    "regularization": [0.0, 0.01, 0.02, 0.1],
    "noise": [0.0, 0.05, 0.1, 0.2],
    "episode_distance": [0.5, 0.1, 2.0, 0.05],
    "time_limit": [1000.0, 40.0, 90.0, 33.0],
}


def singles(bodies: list[CrawlerParameters]) -> list[CrawlerEnv]:
    return [CrawlerEnv(body, **{k: v[i] for k, v in SETTINGS.items()}) for i, body in enumerate(bodies)]


def half_at_random(rng: np.random.Generator, observation: NDArray[np.int64]) -> NDArray[np.int64]:
    """Crawl, and stray from it."""
    stray = rng.integers(10, size=observation.size)
    return np.where(rng.random(observation.size) < 0.3, stray, observation)


def assert_same_info(infos: dict[str, Any], i: int, info: dict[str, Any]) -> None:
    for key, value in info.items():
        if key == "end":
            assert infos[key][i] == value
        else:
            np.testing.assert_allclose(infos[key][i], value, rtol=0, atol=1e-12)


@pytest.mark.parametrize("integrator", ["exact", "step"])
def test_each_crawler_is_the_single_crawler(integrator: str) -> None:
    """2500 steps of 4 crawlers, each with its own body, task and seed, through ends of both kinds."""
    bodies = [replace(body, integrator=integrator) for body in BODIES]
    envs, seeds = singles(bodies), [11, 5, 7, 5]
    vector = CrawlerVectorEnv(4, bodies, **SETTINGS)
    observation, infos = vector.reset(seed=seeds)
    for i, env in enumerate(envs):
        first, info = env.reset(seed=seeds[i])
        assert first == observation[i]
        assert_same_info(infos, i, info)
    rng, ends = np.random.default_rng(0), set()
    for step in range(2500):
        actions = half_at_random(rng, observation)
        observation, rewards, terminated, truncated, infos = vector.step(actions)
        assert not terminated.any()
        for i, env in enumerate(envs):
            seen, reward, _, ended, info = env.step(int(actions[i]))
            assert abs(rewards[i] - reward) <= 1e-12
            assert truncated[i] == ended
            if ended:
                ends.add(info["end"])
                assert infos["_final_obs"][i]
                assert infos["final_obs"][i] == seen
                assert_same_info(infos["final_info"], i, info)
                seen, info = env.reset()
            assert observation[i] == seen
            if ended or step % 50 == 0:
                assert_same_info(infos, i, info)
    assert ends == {"distance", "time"}


@pytest.mark.parametrize("num_envs", [1, 3, 8, 13])
def test_the_number_of_crawlers_changes_none_of_them(num_envs: int) -> None:
    body = CrawlerParameters(integrator="step")
    few, many = CrawlerVectorEnv(num_envs, body, noise=0.1), CrawlerVectorEnv(16, body, noise=0.1)
    one, all_ = few.reset(seed=3)[0], many.reset(seed=3)[0]
    for _ in range(200):
        one, all_ = few.step(one)[0], many.step(all_)[0]
        np.testing.assert_array_equal(one, all_[:num_envs])


def test_one_seed_stands_for_successive_ones() -> None:
    one, other = CrawlerVectorEnv(3), CrawlerVectorEnv(3)
    np.testing.assert_array_equal(one.reset(seed=8)[0], other.reset(seed=[8, 9, 10])[0])
    np.testing.assert_array_equal(one.reset()[0], other.reset(seed=[None, None, None])[0])
    assert [CrawlerEnv().reset(seed=8 + i)[0] for i in range(3)] == one.reset(seed=8)[0].tolist()


def test_without_a_seed_crawlers_differ() -> None:
    starts = [tuple(CrawlerVectorEnv(20).reset()[0]) for _ in range(3)]
    assert len(set(starts)) == 3


def test_gymnasium_makes_it() -> None:
    vector = gym.make_vec(crawler_bench.ENV_ID, num_envs=5, regularization=0.1, noise=[0.0] * 5)
    assert isinstance(vector.unwrapped, CrawlerVectorEnv)
    assert vector.metadata["autoreset_mode"] == AutoresetMode.SAME_STEP
    assert vector.single_action_space == gym.spaces.Discrete(10)
    observation, _ = vector.reset(seed=0)
    assert vector.observation_space.contains(observation)
    observation, rewards, _, truncated, _ = vector.step(vector.action_space.sample())
    assert vector.observation_space.contains(observation)
    assert (rewards.dtype, truncated.dtype) == (np.float64, np.bool_)


def test_results_are_the_callers_to_keep() -> None:
    vector = CrawlerVectorEnv(2)
    observation, infos = vector.reset(seed=0)
    observation, rewards, _, _, infos = vector.step(observation)
    kept = observation.copy(), rewards.copy(), infos["power"].copy(), infos["strain"].copy()
    for _ in range(20):
        vector.step([4, 7])
    for mine, copy in zip((observation, rewards, infos["power"], infos["strain"]), kept, strict=True):
        np.testing.assert_array_equal(mine, copy)


@pytest.mark.parametrize(
    "actions", [[0, 10], [-1, 0], [0], [[0, 1]], [0.5, 1.0], [np.nan, 0], [True, False], ["1", "2"], None, 3]
)
def test_impossible_actions_are_refused_in_one_line(actions: Any) -> None:
    vector = CrawlerVectorEnv(2)
    vector.reset(seed=0)
    before = vector.crawlers.memory.copy()
    with pytest.raises(ValueError, match=r"^actions are not possible: 2 whole numbers from 0 to 9 .*$"):
        vector.step(actions)
    np.testing.assert_array_equal(before, vector.crawlers.memory)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"num_envs": 0}, "num_envs = 0 is not possible"),
        ({"noise": [0.1]}, "noise has 1 values for 2 crawlers"),
        ({"noise": [0.1, -0.1]}, "noise = -0.1 is not possible"),
        ({"time_limit": 0.0}, "time_limit = 0.0 is not possible"),
        ({"parameters": [CrawlerParameters(), CrawlerParameters(n_segments=3)]}, "the same n_segments"),
        ({"render_mode": "human"}, "a vector of crawlers is not rendered"),
    ],
)
def test_impossible_arguments_are_refused(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        CrawlerVectorEnv(**({"num_envs": 2} | arguments))


def test_a_wrong_number_of_seeds_is_refused() -> None:
    with pytest.raises(ValueError, match="3 seeds for 2 crawlers"):
        CrawlerVectorEnv(2).reset(seed=[1, 2, 3])
