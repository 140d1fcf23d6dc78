"""The same body through other keyholes: the laws of environments, and what each keyhole shows."""

import warnings

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env, data_equivalence
from stable_baselines3.common.env_checker import check_env as check_env_sb3
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.vec_env import DummyVecEnv

import crawler_bench
from crawler_bench.envs.crawler import CrawlerEnv
from crawler_bench.envs.keyhole_envs import KeyholeEnv, KeyholeVectorEnv
from crawler_bench.envs.keyhole_sb3 import KeyholeVecEnv
from crawler_bench.envs.keyholes import BOUND, KEYHOLES, body_state
from crawler_bench.physics.parameters import CrawlerParameters
from crawler_bench.physics.state import STATE

THROUGH = pytest.mark.parametrize("keyhole", KEYHOLES[1:])
TASK = {"noise": 0.1, "time_limit": 30.0, "episode_distance": 0.05}


def actions_of(rng, count):
    return rng.integers(10, size=count)


@THROUGH
def test_the_checkers_find_nothing(keyhole):
    env = gym.make(crawler_bench.KEYHOLE_IDS[keyhole], noise=0.1)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped, skip_render_check=True)
        check_env_sb3(env.unwrapped)


@THROUGH
def test_physics_and_reward_are_the_crawler_s(keyhole):
    seen, plain = KeyholeEnv(keyhole=keyhole, **TASK), CrawlerEnv(**TASK)
    seen.reset(seed=3)
    plain.reset(seed=3)
    for action in actions_of(np.random.default_rng(0), 300):
        one, other = seen.step(action), plain.step(action)
        assert one[1:4] == other[1:4]
        assert data_equivalence(one[4], other[4], exact=True)
        if one[3]:
            seen.reset()
            plain.reset()


@THROUGH
def test_single_vector_and_sb3_forms_show_the_same(keyhole):
    single = [KeyholeEnv(keyhole=keyhole, **TASK) for _ in range(3)]
    vector, vec = KeyholeVectorEnv(3, keyhole=keyhole, **TASK), KeyholeVecEnv(3, keyhole=keyhole, **TASK)
    vec.seed(5)
    first = [env.reset(seed=5 + i)[0] for i, env in enumerate(single)]
    np.testing.assert_array_equal(vec.reset(), first)
    np.testing.assert_array_equal(vector.reset(seed=5)[0], first)
    rng, ended = np.random.default_rng(1), 0
    for _ in range(250):
        chosen = actions_of(rng, 3)
        stepped = [env.step(action) for env, action in zip(single, chosen, strict=True)]
        shown, _, dones, infos = vec.step(chosen)
        for i, (seen, _, _, truncated, _) in enumerate(stepped):
            assert dones[i] == truncated
            ended += truncated
            if truncated:
                np.testing.assert_array_equal(infos[i]["terminal_observation"], seen)
                seen = single[i].reset()[0]
            np.testing.assert_array_equal(shown[i], seen)
        assert shown.dtype == np.float32
        assert vec.observation_space.contains(shown[0])
    assert ended > 3
    assert vector.observation_space.shape == (3, *vec.observation_space.shape)


@THROUGH
def test_it_is_what_make_vec_env_makes_of_single_crawlers(keyhole):
    steps = []
    for vec_env_cls in (DummyVecEnv, KeyholeVecEnv):
        vec = make_vec_env(
            crawler_bench.KEYHOLE_IDS[keyhole], 3, seed=5, vec_env_cls=vec_env_cls, env_kwargs=TASK
        )
        rng, seen = np.random.default_rng(1), [vec.reset()]
        for _ in range(200):
            observation, rewards, dones, infos = vec.step(actions_of(rng, 3))
            seen += [observation, rewards, dones]
            seen += [np.append(i["terminal_observation"], i["episode"]["l"]) for i in infos if "episode" in i]
        steps.append(seen)
    assert len(steps[0]) > 601  # some episodes ended
    assert data_equivalence(*steps)
    again = gym.make(vec.get_attr("spec")[2]).unwrapped
    assert (again.keyhole, again.settings) == (keyhole, (0.01, 0.1, 0.05, 30.0))


def test_crawlers_that_are_stepped_together_are_seen_through_one_keyhole():
    with pytest.raises(ValueError, match=r"through one keyhole, not \['one-hot', 'strain'\]"):
        KeyholeVecEnv([KeyholeEnv, lambda: KeyholeEnv(keyhole="strain")])
    with pytest.raises(ValueError, match="use DummyVecEnv"):
        KeyholeVecEnv([CrawlerEnv])


@THROUGH
def test_a_vector_shows_what_single_crawlers_show(keyhole):
    """Until an episode ends; how a vector then goes on is the vector's own."""
    endless = {"noise": 0.1, "time_limit": 1e9, "episode_distance": 1e9}
    single, vector = KeyholeEnv(keyhole=keyhole, **endless), KeyholeVectorEnv(2, keyhole=keyhole, **endless)
    single.reset(seed=1)
    vector.reset(seed=0)
    for action in actions_of(np.random.default_rng(2), 100):
        seen = single.step(action)
        shown = vector.step(np.array([0, action]))
        np.testing.assert_array_equal(shown[0][1], seen[0])
        assert vector.observation_space.contains(shown[0])


@pytest.mark.parametrize("body", [{}, {"decide_on": "change"}], ids=["interval", "change"])
@pytest.mark.parametrize("noise", [0.0, 0.2])
def test_the_index_is_made_of_the_very_strains_that_are_shown(noise, body):
    parameters = CrawlerParameters(**body)
    strain = KeyholeEnv(parameters, keyhole="strain", noise=noise)
    hot, index = KeyholeEnv(parameters, keyhole="one-hot", noise=noise), CrawlerEnv(parameters, noise=noise)
    envs = (strain, hot, index)
    for env in envs:
        env.reset(seed=0)
    furthest = 0.0
    for action in actions_of(np.random.default_rng(0), 300):
        sensed, shown, seen = (env.step(action)[0] for env in envs)
        assert sensed[seen] == sensed.max()  # the undeformed body ties
        np.testing.assert_array_equal(shown, np.eye(10)[seen])
        error = np.abs(sensed - strain.nodes["strain"][:-1]).max()
        assert error <= noise + 1e-6
        furthest = max(furthest, float(error))
    assert furthest >= 0.9 * noise


def test_the_state_decides_the_future():
    """A body that is put together from what the keyhole shows goes on as the one that was seen."""
    env, twin = KeyholeEnv(keyhole="state"), CrawlerEnv(episode_distance=1e9, time_limit=1e9)
    env.reset(seed=0)
    twin.reset(seed=0)
    rng = np.random.default_rng(0)
    for action in actions_of(rng, 200):
        env.step(action)
    n = env.parameters.n_segments
    seen = body_state(env.nodes[None])[0]
    strains, (slip, sine, cosine, drive, velocity, force) = seen[:n], np.split(seen[n:], 6)
    values = {
        "displacement": 0.3 - np.concatenate([[0.0], -np.cumsum(strains)]), "slip": slip,
        "neuron": np.tan(np.arctan2(sine, cosine) / 2), "drive": drive, "velocity": velocity, "force": force,
    }  # fmt: skip
    snapshot = twin.get_state() | {"state": [values[name].tolist() for name in STATE], "layout": []}
    twin.set_state(snapshot)
    distance = twin.odometer["lifetime_distance"]
    for action in actions_of(rng, 100):
        one, other = env.step(action), twin.step(action)
        assert other[1] == pytest.approx(one[1], abs=1e-7)
        np.testing.assert_allclose(other[4]["strain"], one[4]["strain"], atol=1e-7)
    assert twin.odometer["lifetime_distance"] - distance != 0


def test_nothing_comes_near_the_bound():
    """So that clipping, which the spaces need, hides nothing."""
    largest = 0.0
    for spike_gain in (1.0, 2.0, 10.0):
        env = KeyholeEnv(CrawlerParameters(spike_gain=spike_gain), keyhole="state")
        env.reset(seed=0)
        for action in np.repeat(actions_of(np.random.default_rng(0), 100), 4):
            largest = max(largest, float(np.abs(env.step(action)[0]).max()))
    assert largest > 1
    assert largest < BOUND / 2


def test_another_keyhole_is_refused():
    with pytest.raises(ValueError, match="keyhole = 'key' is not possible: it must be one of one-hot"):
        KeyholeEnv(keyhole="key")
