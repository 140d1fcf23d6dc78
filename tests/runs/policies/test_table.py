"""Policies as tables: what an agent's table says is what the agent does."""

import subprocess
import sys

import numpy as np
import pytest

from agents.deep import DQN, PPO
from agents.qlearning import QLearning
from agents.reference import Random, Wave
from crawler_bench.config.schema import ConfigError, RunConfig, override
from crawler_bench.envs.crawler import CrawlerEnv
from crawler_bench.envs.sb3 import CrawlerVecEnv
from crawler_bench.gait.metrics import speed
from crawler_bench.gait.rollout import rollout
from crawler_bench.physics.parameters import CrawlerParameters
from crawler_bench.runs.policies.files import Policy, read_policy, write_policy
from crawler_bench.runs.policies.table import DRAWS, action_table, greedy_policy
from crawler_bench.runs.store import NotARunError

N = 10


@pytest.fixture(scope="module")
def ppo():
    return PPO(CrawlerVecEnv(4), seed=0, n_steps=64, batch_size=64).learn(1024)


@pytest.fixture(scope="module")
def dqn():
    return DQN(CrawlerVecEnv(4), seed=0, learning_starts=64, exploration_fraction=0.5).learn(1024)


def test_a_deterministic_table_is_the_network(ppo, dqn):
    for agent in (ppo, dqn):
        table = action_table(agent, N)
        assert set(np.unique(table)) == {0, 1}
        for observation in range(N):
            assert table[observation].argmax() == agent.predict(observation, deterministic=True)[0]


def test_a_stochastic_table_holds_the_network_s_probabilities(ppo):
    table = action_table(ppo, N, "stochastic")
    np.testing.assert_allclose(table.sum(axis=1), 1)
    drawn = ppo.predict(np.repeat(np.arange(N), 4000), deterministic=False)[0].reshape(N, 4000)
    counted = np.array([np.bincount(row, minlength=N) for row in drawn]) / 4000
    # Five standard deviations of a share of 4000 draws.
    assert np.abs(counted - table).max() < 5 * 0.5 / np.sqrt(4000)


def test_a_value_network_explores_at_its_last_rate(dqn):
    table = action_table(dqn, N, "stochastic")
    assert dqn.exploration_rate == pytest.approx(0.05)
    np.testing.assert_allclose(table, 0.95 * action_table(dqn, N) + 0.005)


def test_crawling_by_the_table_is_crawling_by_the_network(ppo):
    """The compiled rollout of the table against the network asked at every step of the environment."""
    parameters = CrawlerParameters()
    record = rollout(parameters, action_table(ppo, N), warm_up=0, duration=95, noise=0, start=(3, 4))
    env = CrawlerEnv(parameters, episode_distance=1e9, time_limit=1e9)
    observation, _ = env.reset(seed=0)
    centroids, asked = [0.0], 0
    for action, strain in zip(record.action, record.strain, strict=False):
        if np.ptp(strain) > 0:  # the undeformed body leaves its observation to chance
            assert ppo.predict(observation, deterministic=True)[0] == action
            asked += 1
        observation, _, _, _, info = env.step(int(action))
        centroids.append(info["centroid"])
    assert asked > 400
    np.testing.assert_allclose(centroids, record.centroid, rtol=0, atol=1e-12)
    assert speed(record) == pytest.approx(centroids[-1] / 95)


def test_a_crawler_at_rest_is_observed_by_chance():
    """Not as if its first segment were the most contracted one."""
    table = np.eye(N)
    first = {
        int(rollout(CrawlerParameters(), table, warm_up=0, duration=0.2, noise=0, start=(k,)).action[0])
        for k in range(30)
    }
    assert len(first) > 5


def test_tables_of_our_agents():
    q = QLearning(CrawlerEnv(), seed=0)
    q.q_table[:] = np.random.default_rng(0).random((N, N))  # no ties, which predict breaks by chance
    np.testing.assert_array_equal(action_table(q, N), np.eye(N)[q.policy])
    np.testing.assert_array_equal(action_table(q, N, "stochastic"), np.eye(N)[q.policy])
    np.testing.assert_array_equal(action_table(Wave(CrawlerEnv()), N, "stochastic"), np.eye(N))
    np.testing.assert_allclose(action_table(Random(CrawlerEnv()), N), 1 / N)


class Coin:
    """Tells nothing of its probabilities: action 0 or 1, at observation 0 always 1."""

    def __init__(self):
        self.rng = np.random.default_rng(0)

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        seen = np.asarray(observation)
        return np.where(seen == 0, 1, 0 if deterministic else self.rng.integers(2, size=seen.shape)), state


def test_a_secretive_policy_is_counted():
    table = action_table(Coin(), 3, "stochastic")
    np.testing.assert_array_equal(table[0], [0, 1, 0])
    np.testing.assert_allclose(table[1:, :2], 0.5, atol=5 * 0.5 / np.sqrt(DRAWS))
    np.testing.assert_array_equal(action_table(Coin(), 3), np.eye(3)[[1, 0, 0]])


class Wrong:
    """Answers as it is told to."""

    def __init__(self, answer):
        self.answer = answer

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return self.answer(observation), state


@pytest.mark.parametrize(
    "answer",
    [
        lambda seen: seen - 1,
        lambda seen: seen + 1,
        lambda seen: seen * 0.9,
        lambda seen: seen[:, None],
        lambda seen: 3,
        lambda seen: int(seen),
    ],
    ids=["negative", "too large", "no whole numbers", "two axes", "one for all", "one at a time"],
)
def test_an_answer_that_is_no_action_is_refused(answer):
    with pytest.raises(ConfigError, match=r"Wrong\.predict"):
        action_table(Wrong(answer), N)


@pytest.mark.parametrize("told", [lambda: None, np.ones((3, 3)), np.eye(4), np.full((3, 3), np.nan)])
def test_probabilities_that_are_none_are_refused(told):
    agent = Coin()
    agent.action_probabilities = told
    with pytest.raises(ConfigError, match=r"Coin\.action_probabilities: a policy is 3 rows of 3"):
        action_table(agent, 3)


BAD_ROWS = {
    "infinite": [np.inf, 0, 0], "huge": [1e308] * 3, "zero": [0, 0, 0], "tiny": [5e-324, 0, 0],
    "negative": [2, -1, 0], "not a number": [np.nan, 0, 1], "two": [1, 1, 0], "nearly": [1 - 1e-5, 0, 0],
}  # fmt: skip


@pytest.mark.parametrize("row", BAD_ROWS.values(), ids=BAD_ROWS)
def test_a_policy_file_is_checked_wholly(row, tmp_path):
    run = override(RunConfig(), {"n_segments": 3}, "test")
    write_policy(Policy(run, 0, {"deterministic": np.eye(3)}), tmp_path / "good.json")
    assert read_policy(tmp_path / "good.json").tables["deterministic"].tolist() == np.eye(3).tolist()
    table = np.eye(3)
    table[1] = row
    write_policy(Policy(run, 0, {"deterministic": table}), tmp_path / "bad.json")
    with pytest.raises(NotARunError, match=r"bad\.json is not a policy: a policy is 3 rows of 3"):
        read_policy(tmp_path / "bad.json")


ANY_TABLE = """
import numpy as np
from crawler_bench.gait.rollout import rollout
from crawler_bench.physics.parameters import CrawlerParameters
crawl = dict(warm_up=0, duration=200, noise=0, start=(0,))
for row in {rows}:
    record = rollout(CrawlerParameters(n_segments=3), np.tile(row, (3, 1)), **crawl)
    assert 0 <= record.action.min() <= record.action.max() < 3, row
print("done")
"""


def test_no_table_leads_a_rollout_out_of_its_row():
    """In a process of its own, which an index beyond the table may end."""
    code = "from numpy import inf, nan\n" + ANY_TABLE.format(rows=list(BAD_ROWS.values()))
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", code], capture_output=True, text=True, check=False
    )
    assert done.stdout == "done\n", (done.returncode, done.stderr)
    with pytest.raises(ValueError, match="a table of 10 x 10"):
        rollout(CrawlerParameters(), np.eye(3), warm_up=0, duration=1, noise=0, start=(0,))


def test_asking_for_the_policy_does_not_disturb_the_learning(ppo):
    assert greedy_policy(Coin(), 3) is None
    np.testing.assert_array_equal(greedy_policy(ppo, N), action_table(ppo, N))
    q = QLearning(CrawlerEnv(), seed=0).learn(100)
    state = q.rng.bit_generator.state
    assert greedy_policy(q, N) is not None
    assert q.rng.bit_generator.state == state
