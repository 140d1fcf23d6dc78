"""The vector environment of Stable-Baselines3: the same crawlers, and agents learn on it."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch
from pandas.testing import assert_frame_equal
from stable_baselines3 import DQN, PPO
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.monitor import Monitor, load_results
from stable_baselines3.common.vec_env import DummyVecEnv, VecEnvWrapper, VecMonitor

import crawler_bench
from agents.qlearning import QLearning
from crawler_bench.envs.crawler import CrawlerEnv
from crawler_bench.envs.sb3 import CrawlerVecEnv
from crawler_bench.envs.transition import DISTANCE, TIME
from crawler_bench.physics import CrawlerParameters
from tests.bodies import former

TICKS = CrawlerParameters(decision_interval=0.2)
SETTINGS: dict[str, Any] = {
    "noise": [0.0, 0.1, 0.2], "time_limit": [20.0, 35.0, 50.0], "episode_distance": [2.0, 0.02, 0.05],
}  # fmt: skip


def test_each_crawler_is_the_single_crawler() -> None:
    bodies = [CrawlerParameters(damping=damping) for damping in (3.5, 2.0, 1.0)]
    vec = CrawlerVecEnv(3, bodies, **SETTINGS)
    vec.seed(4)
    observation, ends = vec.reset(), set()
    envs = [
        CrawlerEnv(body, **{name: values[i] for name, values in SETTINGS.items()})
        for i, body in enumerate(bodies)
    ]
    assert observation.tolist() == [env.reset(seed=4 + i)[0] for i, env in enumerate(envs)]
    for _ in range(400):
        actions = observation
        observation, rewards, dones, infos = vec.step(actions)
        assert rewards.dtype == np.float32
        for i, env in enumerate(envs):
            seen, reward, _, truncated, info = env.step(int(actions[i]))
            assert rewards[i] == np.float32(reward)
            assert dones[i] == truncated
            if truncated:
                ends.add(info["end"])
                expected = {"terminal_observation": seen, "TimeLimit.truncated": True}
                assert infos[i] == expected | {key: info[key] for key in ("end", "time", "centroid")}
                seen, _ = env.reset()
            else:
                assert infos[i] == {}
            assert observation[i] == seen
    assert ends == {DISTANCE, TIME}


def test_a_seed_holds_for_one_reset_and_without_one_crawlers_differ() -> None:
    vec = CrawlerVecEnv(20)
    vec.seed(1)
    first, second = vec.reset(), vec.reset()
    vec.seed(1)
    np.testing.assert_array_equal(first, vec.reset())
    assert (first != second).any()
    assert (CrawlerVecEnv(20).reset() != CrawlerVecEnv(20).reset()).any()


def test_attributes_are_those_of_each_crawler() -> None:
    vec = CrawlerVecEnv(3, regularization=[0.0, 0.1, 0.2])
    assert vec.get_attr("regularization") == [0.0, 0.1, 0.2]
    assert vec.get_attr("parameters", 1) == [CrawlerParameters()]
    vec.set_attr("regularization", 0.5, [0, 2])
    vec.set_attr("mark", "x")
    assert vec.get_attr("regularization") == [0.5, 0.1, 0.5]
    assert vec.has_attr("mark")
    assert not vec.has_attr("other")
    assert vec.env_is_wrapped(Monitor, [0, 2]) == [False, False]
    with pytest.raises(AttributeError, match="no attribute 'other'"):
        vec.get_attr("other")
    with pytest.raises(AttributeError, match="parameters of a crawler cannot change"):
        vec.set_attr("parameters", CrawlerParameters())
    with pytest.raises(AttributeError, match="no method 'render'"):
        vec.env_method("render")


def test_attributes_are_reached_as_through_the_wrappers_of_gymnasium() -> None:
    ours, theirs = CrawlerVecEnv(3), DummyVecEnv([lambda: gym.make(crawler_bench.ENV_ID)] * 3)
    for vec in (ours, theirs):
        assert vec.env_method("set_wrapper_attr", "mark", 7) == [True] * 3
        assert vec.env_method("set_wrapper_attr", "mark", 8, indices=[0, -1]) == [True] * 2
        assert vec.env_method("get_wrapper_attr", "mark") == vec.get_attr("mark") == [8, 7, 8]
        assert vec.env_method("has_wrapper_attr", "mark", indices=1) == [True]
        assert vec.env_method("has_wrapper_attr", "nothing") == [False] * 3


def test_a_setting_that_is_set_holds_from_the_next_step_on() -> None:
    vec, twin = CrawlerVecEnv(2), CrawlerVecEnv(2, regularization=0.3)
    for each in (vec, twin):
        each.seed(0)
        each.reset()
    vec.set_attr("regularization", 0.3)
    for _ in range(5):
        np.testing.assert_array_equal(vec.step(np.array([3, 4]))[1], twin.step(np.array([3, 4]))[1])


def test_a_setting_of_one_crawler_is_not_that_of_its_neighbours() -> None:
    settings = [[0.0] * 4, [0.0, 0.3, 0.3, 0.0]]
    twins = [CrawlerVecEnv(4, regularization=each) for each in settings]
    vec = CrawlerVecEnv(4, regularization=0.0)
    for each in (vec, *twins):
        each.seed(0)
        each.reset()
    for indices, value, twin in (([1, 2], 0.3, 2), ([1], 0.3, 2), ([1, 2], 0.0, 1)):
        vec.set_attr("regularization", value, indices)
        for action in range(10):
            rewards = [each.step(np.full(4, action))[1] for each in (vec, *twins)]
            np.testing.assert_array_equal(rewards[0], rewards[twin])
    assert (rewards[1] != rewards[2]).tolist() == [False, True, True, False]


def test_an_impossible_setting_is_refused_and_changes_nothing() -> None:
    vec = CrawlerVecEnv(2)
    with pytest.raises(ValueError, match=r"noise = -1.0 is not possible"):
        vec.set_attr("noise", -1)
    assert vec.get_attr("noise") == [0.0, 0.0]


@pytest.mark.parametrize("actions", [[0, 10], [0], [0.5, 1.5]])
def test_impossible_actions_are_refused(actions: list[float]) -> None:
    vec = CrawlerVecEnv(2)
    vec.reset()
    with pytest.raises(ValueError, match="actions are not possible: 2 whole numbers from 0 to 9"):
        vec.step(np.array(actions))


def test_a_monitor_counts_its_episodes() -> None:
    vec = VecMonitor(CrawlerVecEnv(2, TICKS, time_limit=[1.0, 2.0]))
    vec.reset()
    lengths: list[list[int]] = [[], []]
    for _ in range(20):
        _, _, dones, infos = vec.step(np.array([0, 0]))
        for i in dones.nonzero()[0]:
            lengths[i].append(infos[i]["episode"]["l"])
    assert lengths == [[5, 5, 5, 5], [10, 10]]


def test_it_is_what_make_vec_env_makes_of_single_crawlers(tmp_path: Path) -> None:
    """The same numbers, reports of the monitors and files as with Stable-Baselines3's own class."""
    made = {}
    for vec_env_cls in (CrawlerVecEnv, DummyVecEnv):
        vec = make_vec_env(
            crawler_bench.ENV_ID, 3, seed=5, vec_env_cls=vec_env_cls,  # type: ignore[arg-type]
            env_kwargs={"time_limit": 3.0, "noise": 0.1, "parameters": TICKS},
            monitor_dir=str(tmp_path / vec_env_cls.__name__),
            monitor_kwargs={"info_keywords": ("end", "centroid")},
        )  # fmt: skip
        steps, observation = [], vec.reset()
        for _ in range(40):
            observation, rewards, dones, infos = vec.step(observation)
            episodes = [info.get("episode", {}) for info in infos]
            kept = [{key: value for key, value in each.items() if key != "t"} for each in episodes]
            steps.append((observation.tolist(), rewards.tolist(), dones.tolist(), kept))
        assert (
            evaluate_policy(QLearning(CrawlerEnv(), seed=0), vec, 3)[0] != 0
        )  # without a warning that there is no monitor
        assert vec.get_attr("spec")[0].max_episode_steps == 15
        assert isinstance(vec, vec_env_cls)
        vec.close()
        made[vec_env_cls] = steps, load_results(str(tmp_path / vec_env_cls.__name__))
    ours, theirs = made[CrawlerVecEnv], made[DummyVecEnv]
    assert ours[0] == theirs[0]
    columns = ["r", "l", "end", "centroid"]
    assert len(ours[1]) >= 6
    assert_frame_equal(*(each[columns].sort_values(columns, ignore_index=True) for _, each in (ours, theirs)))


def test_functions_that_make_something_else_are_refused() -> None:
    clipped = [lambda: gym.wrappers.ClipReward(CrawlerEnv(), 0.0, 1.0)]
    for makers in (clipped, [lambda: gym.make("CartPole-v1")]):
        with pytest.raises(ValueError, match=r"crawlers are stepped together without <.*: use DummyVecEnv"):
            CrawlerVecEnv(makers)
    one = CrawlerEnv()
    with pytest.raises(ValueError, match="a crawler of its own"):
        CrawlerVecEnv([lambda: one, lambda: one])
    with pytest.raises(ValueError, match="every crawler is monitored"):
        CrawlerVecEnv([CrawlerEnv, lambda: Monitor(CrawlerEnv())])


def test_a_monitor_may_want_episodes_to_end() -> None:
    vec = CrawlerVecEnv([lambda: Monitor(CrawlerEnv(), allow_early_resets=False)])
    vec.reset()
    vec.step(np.array([0]))
    with pytest.raises(RuntimeError, match="allow_early_resets"):
        vec.reset()


def test_crawlers_are_drawn_on_one_picture() -> None:
    vec, single = CrawlerVecEnv(4, render_mode="rgb_array"), CrawlerEnv(render_mode="rgb_array")
    vec.seed(0)
    vec.reset()
    single.reset(seed=3)
    for action in [*range(9, -1, -1)] * 5:
        vec.step(np.array([0, 0, 0, action]))
        single.step(action)
    images, picture, alone = vec.get_images(), vec.render(), single.render()
    assert picture is not None
    assert alone is not None
    np.testing.assert_array_equal(images[3], alone)
    assert (images[2] != alone).any()
    np.testing.assert_array_equal(picture[alone.shape[0] :, alone.shape[1] :], alone)


def test_the_specification_makes_the_same_crawler() -> None:
    vec = CrawlerVecEnv(2, TICKS, time_limit=[4.0, 2.0], noise=0.1)
    vec.set_attr("regularization", 0.7, [1])
    spec = vec.get_attr("spec", 1)[0]
    assert spec.max_episode_steps == 10
    assert gym.make(spec).unwrapped.settings == (0.7, 0.1, vec.get_attr("episode_distance")[1], 2.0)  # type: ignore[attr-defined]


def test_a_step_before_a_reset_is_refused() -> None:
    with pytest.raises(gym.error.ResetNeeded, match="call reset"):
        CrawlerVecEnv(2).step(np.array([0, 0]))


# With two segments the neuron of head and tail pays most, three times as much as acting at random.
BODY = former(n_segments=2)
EASY: dict[str, Any] = {"time_limit": 4.0, "regularization": 0.0}


@pytest.fixture
def one_thread() -> Iterator[None]:
    """Two threads of PyTorch wait for each other where a core is busy, ten times longer than they work."""
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(threads)


class Generous(VecEnvWrapper):
    """Rewards of order 1: those of a crawler are smaller than the values that a fresh network gives."""

    def reset(self) -> Any:
        return self.venv.reset()

    def step_wait(self) -> Any:
        observation, rewards, dones, infos = self.venv.step_wait()
        return observation, 100 * rewards, dones, infos


@pytest.mark.parametrize("algorithm", ["PPO", "DQN"])
def test_agents_learn(algorithm: str, one_thread: None) -> None:
    vec = VecMonitor(Generous(CrawlerVecEnv(8, BODY, **EASY)))
    if algorithm == "PPO":
        agent: Any = PPO("MlpPolicy", vec, n_steps=64, batch_size=128, learning_rate=3e-3, seed=0)
    else:
        agent = DQN("MlpPolicy", vec, learning_rate=3e-3, gamma=0.8, train_freq=1, seed=0)
        agent.target_update_interval = 50
    agent.learn(3000 if algorithm == "DQN" else 2048)
    judge = CrawlerVecEnv(32, BODY, **EASY)
    judge.seed(100)
    returns, _ = evaluate_policy(agent, VecMonitor(judge), n_eval_episodes=64)
    assert float(np.mean(returns)) > 0.12
