"""The hand-written learner against eq. 12: closed forms, and its two loops against each other."""

import json
import subprocess
import sys

import gymnasium as gym
import numpy as np
import pytest
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.vec_env import DummyVecEnv

import crawler_bench
from agents.loop import greedy, update
from agents.qlearning import QLearning
from crawler_bench.envs.crawler import CrawlerEnv
from crawler_bench.envs.randomness import live_state


class Chain(gym.Env[int, int]):
    """N states in a row; action 1 moves on, 0 stays; the step off the end pays 1 and ends the episode."""

    def __init__(self, n=4, truncate=False, first=0):
        self.observation_space = gym.spaces.Discrete(n, start=first)
        self.action_space = gym.spaces.Discrete(2, start=first)
        self.n, self.truncate, self.first, self.place = n, truncate, first, 0

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.place = 0
        return self.place + self.first, {}

    def step(self, action):
        self.place += action - self.first
        end = self.place == self.n
        place = min(self.place, self.n - 1) + self.first
        return place, float(end), end and not self.truncate, end and self.truncate, {}


HALVES = {"learning_rate": 0.5, "discount": 0.5, "initial_q": 3.0, "seed": 0}


def crawler(**arguments):
    return gym.make(crawler_bench.ENV_ID, **arguments)


def test_update_is_equation_12():
    Q = np.arange(6.0).reshape(2, 3)
    update(Q, 0, 1, 0.5 + 0.9 * Q[1].max(), 0.1)
    assert Q[0, 1] == pytest.approx(0.9 * 1.0 + 0.1 * (0.5 + 0.9 * 5.0))
    np.testing.assert_array_equal(Q[[0, 0, 1, 1, 1], [0, 2, 0, 1, 2]], [0.0, 2.0, 3.0, 4.0, 5.0])


def test_ties_are_broken_evenly():
    generator = np.random.default_rng(0)
    rng = live_state(generator)
    counts = np.bincount([greedy(np.array([1.0, 3.0, 3.0, 0.0, 3.0]), rng) for _ in range(6000)], minlength=5)
    assert counts[[0, 3]].sum() == 0
    assert counts[[1, 2, 4]].min() > 1850


@pytest.mark.parametrize("first", [0, 3])
def test_a_chain_converges_to_its_closed_form(first):
    """Q*(s, on) = gamma^(N - 1 - s): the last step terminates. Staying is tried until it disappoints."""
    agent = QLearning(Chain(first=first), learning_rate=0.5, discount=0.8, initial_q=1.5, seed=0)
    agent.learn(20_000)
    on = 0.8 ** np.arange(3, -1, -1)
    np.testing.assert_allclose(agent.q_table[:, 1], on, atol=1e-9)
    assert (agent.q_table[:, 0] < on).all()
    assert (agent.q_table[:, 0] >= 0.8 * on - 1e-12).all()
    assert agent.predict(np.array([first, first + 3]))[0].tolist() == [first + 1, first + 1]


def test_truncation_is_looked_through():
    """Truncated at the end, the last state is worth 1 + gamma max Q(last) = 1 / (1 - gamma)."""
    agent = QLearning(Chain(truncate=True), **HALVES).learn(20_000)
    assert agent.q_table[3, 1] == pytest.approx(2.0, abs=1e-9)
    assert agent.q_table[2, 1] == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("truncate", [False, True])
def test_every_end_is_terminal_on_request(truncate):
    """Then the last state is worth 1, however the episode ended, and the others what stands before it."""
    agent = QLearning(Chain(truncate=truncate), **HALVES, end_is_terminal=True).learn(20_000)
    np.testing.assert_allclose(agent.q_table[:, 1], [0.125, 0.25, 0.5, 1.0], atol=1e-9)


def test_high_initial_values_make_it_try_everything():
    """Where it has been often enough, a learner that expects much has tried every action, and only then."""
    optimist = QLearning(crawler(), initial_q=0.2, seed=0).learn(5000)
    assert (optimist.q_table != 0.2).all(axis=1).any()
    pessimist = QLearning(crawler(), initial_q=-1.0, seed=0).learn(5000)
    assert not (pessimist.q_table != -1.0).all(axis=1).any()


@pytest.mark.parametrize("end_is_terminal", [False, True])
@pytest.mark.parametrize("arguments", [
    {"regularization": 0.01}, {"regularization": 0.0, "noise": 0.1}, {"episode_distance": 0.05},
    {"time_limit": 9.0},
])  # fmt: skip
def test_the_compiled_loop_gives_the_same_table_to_the_bit(arguments, end_is_terminal):
    settings = {"seed": 7, "end_is_terminal": end_is_terminal}
    fast, plain = (QLearning(crawler(**arguments), **settings, compiled=yes) for yes in (True, False))
    np.testing.assert_array_equal(fast.learn(3000).q_table, plain.learn(3000).q_table)
    assert fast.env.unwrapped.get_state() == plain.env.unwrapped.get_state()


def test_an_unknown_wrapper_is_stepped_through():
    """A wrapper may change rewards; the compiled loop would go round it."""
    doubled = gym.wrappers.TransformReward(crawler(), lambda reward: 2.0 * float(reward))
    agent = QLearning(doubled, seed=7).learn(2000)
    plain = QLearning(crawler(), seed=7).learn(2000)
    assert np.abs(agent.q_table - plain.q_table).max() > 1e-6


@pytest.mark.parametrize("wrapped", [False, True])
def test_the_new_observation_is_bootstrapped_from(wrapped):
    """One decision by hand: the entry moves towards r + gamma max Q(o'), with o' the *new* observation."""
    env = CrawlerEnv() if wrapped else crawler()
    agent = QLearning(env, learning_rate=0.3, discount=0.9, initial_q=0.0, seed=3)
    twin, guide = CrawlerEnv(), QLearning(CrawlerEnv(), initial_q=0.0, seed=3)
    o, _ = twin.reset(seed=agent._env_seed)
    agent.q_table[:] = guide.q_table[:] = np.random.default_rng(0).random((10, 10))
    Q = agent.q_table.copy()
    for _ in range(50):
        a = int(Q[o].argmax())
        o_next, r, *_ = twin.step(a)
        Q[o, a] = 0.7 * Q[o, a] + 0.3 * (r + 0.9 * Q[o_next].max())
        o = o_next
    agent.learn(50)
    np.testing.assert_allclose(agent.q_table, Q, rtol=1e-14)


def test_learning_resumes_to_the_bit_in_mid_episode(tmp_path):
    whole = QLearning(crawler(noise=0.02), seed=11).learn(5000)
    part = QLearning(crawler(noise=0.02), seed=11).learn(2345)
    part.save(tmp_path / "agent.json")
    resumed = QLearning.load(tmp_path / "agent.json", crawler(noise=0.02)).learn(5000 - 2345)
    np.testing.assert_array_equal(resumed.q_table, whole.q_table)
    assert resumed.num_timesteps == whole.num_timesteps == 5000


def test_the_reading_of_an_end_is_saved(tmp_path):
    whole = QLearning(crawler(time_limit=9.0), seed=11, end_is_terminal=True).learn(2000)
    assert (whole.q_table != QLearning(crawler(time_limit=9.0), seed=11).learn(2000).q_table).any()
    QLearning(crawler(time_limit=9.0), seed=11, end_is_terminal=True).learn(700).save(tmp_path / "agent.json")
    resumed = QLearning.load(tmp_path / "agent.json", crawler(time_limit=9.0)).learn(1300)
    np.testing.assert_array_equal(resumed.q_table, whole.q_table)


def test_calls_of_learn_add_up_whatever_is_asked_between():
    whole = QLearning(crawler(), seed=2).learn(4000)
    parts = QLearning(crawler(), seed=2).learn(1)
    parts.predict(np.zeros(1000, dtype=int))  # breaks ties of its own
    parts.learn(1699).learn(2300)
    np.testing.assert_array_equal(whole.q_table, parts.q_table)


def test_only_the_first_reset_is_seeded():
    seeds = []

    class Watched(Chain):
        def reset(self, *, seed=None, options=None):
            seeds.append(seed)
            return super().reset(seed=seed)

    agent = QLearning(Watched(), seed=0).learn(5)
    agent.set_env(Watched())
    agent.learn(5)
    assert seeds[0] is not None
    assert len(seeds) > 1
    assert not any(seeds[1:])


def test_a_saved_agent_is_json(tmp_path):
    QLearning(crawler(), seed=0).learn(100).save(tmp_path / "agent.json")
    content = json.loads((tmp_path / "agent.json").read_text())
    assert np.shape(content["q_table"]) == (10, 10)
    assert len(content["policy"]) == 10


@pytest.mark.parametrize("text", ["", "{}", "[1]", '{"learning_rate": 1}', "\x00"])
def test_a_file_that_is_no_agent_is_refused(tmp_path, text):
    (tmp_path / "agent.json").write_text(text)
    with pytest.raises(ValueError, match=r"is not a saved Q-learning agent"):
        QLearning.load(tmp_path / "agent.json")


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("observation", 123456789), ("observation", -1), ("observation", 1.5), ("q_table", [[0.2] * 9] * 10),
        ("q_table", [[float("nan")] * 10] * 10), ("q_table", [[1.0]]), ("q_table", [[1.0], [1.0, 2.0]]),
        ("num_timesteps", "x"), ("generators", []), ("environment", 5), ("environment", {}),
        ("learning_rate", -1.0),
    ],
)  # fmt: skip
def test_an_edited_agent_is_refused(tmp_path, name, value):
    path = tmp_path / "agent.json"
    QLearning(crawler(), seed=0).learn(100).save(path)
    path.write_text(json.dumps(json.loads(path.read_text()) | {name: value}))
    with pytest.raises(ValueError, match=r"agent\.json is not a saved Q-learning agent: ") as caught:
        QLearning.load(path, crawler())
    assert "\n" not in str(caught.value)


CORRUPTED = """
import gymnasium as gym, numpy as np, crawler_bench
from agents.qlearning import QLearning
for name, value in (("observation", 99), ("observation", -10**9), ("q_table", np.zeros((3, 3)))):
    agent = QLearning(gym.make(crawler_bench.ENV_ID), seed=0).learn(10)
    setattr(agent, name, value)
    try:
        agent.learn(10_000)
    except ValueError as error:
        print(name)
"""


def test_what_would_corrupt_memory_is_refused():
    """In a process of its own, which the compiled loop may end."""
    done = subprocess.run([sys.executable, "-c", CORRUPTED], capture_output=True, text=True, check=False)
    assert done.stdout.split() == ["observation", "observation", "q_table"], (done.returncode, done.stderr)


def test_the_callback_is_called_and_can_stop():
    seen = []

    def stop_at_3000(local, _global):
        seen.append(local["self"].num_timesteps)
        return len(seen) < 3

    agent = QLearning(crawler(), seed=0).learn(10_000, callback=stop_at_3000)
    assert seen == [1000, 2000, 3000]
    assert agent.num_timesteps == 3000


def test_predict_takes_batches_of_any_shape():
    agent = QLearning(crawler(), seed=0)
    agent.q_table = np.eye(10)[[3, 1, 4, 1, 5, 9, 2, 6, 5, 3]]
    actions, state = agent.predict(np.array([[0, 5], [9, 2]]))
    assert actions.tolist() == [[3, 9], [3, 4]]
    assert state is None
    assert agent.predict(4)[0].shape == ()
    assert int(agent.predict(4)[0]) == 5


def test_stable_baselines_evaluates_it_as_it_is():
    agent = QLearning(crawler(), seed=0)
    agent.q_table = np.eye(10)
    env = DummyVecEnv([lambda: CrawlerEnv(time_limit=100.0, regularization=0.0)])
    env.seed(0)
    mean, _ = evaluate_policy(agent, env, n_eval_episodes=2, warn=False)
    assert 0.3 < float(mean) < 0.8


@pytest.mark.parametrize("settings", [
    {"learning_rate": 0.0}, {"learning_rate": 1.5}, {"discount": 1.0}, {"discount": -0.1},
    {"initial_q": np.inf}, {"end_is_terminal": "no"}, {"compiled": "x"},
])  # fmt: skip
def test_an_impossible_setting_is_refused(settings):
    (name, _value), *_ = settings.items()
    with pytest.raises(ValueError, match=rf"^{name} = .* is not possible: it must be"):
        QLearning(crawler(), **settings)


def test_spaces_that_are_not_discrete_are_refused():
    with pytest.raises(ValueError, match="a table needs Discrete spaces"):
        QLearning(gym.make("Pendulum-v1"))


def test_the_seed_decides_everything():
    one, same, other = (QLearning(crawler(), seed=seed).learn(2000).q_table for seed in (1, 1, 2))
    np.testing.assert_array_equal(one, same)
    assert (one != other).any()


@pytest.mark.slow
def test_the_regularized_learner_finds_nearest_neighbour_wiring():
    policies = [QLearning(crawler(), seed=seed).learn(800_000).policy for seed in range(1000, 1005)]
    assert sum((policy == np.arange(10)).all() for policy in policies) >= 3
