"""Policies that are no tables, measured as they act; Stable-Baselines3's evaluate_policy is the judge."""

from typing import Any

import gymnasium as gym
import numpy as np
import pandas as pd
import pytest
import torch
from sb3_contrib import RecurrentPPO
from stable_baselines3 import A2C, DQN
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.vec_env import DummyVecEnv

import crawler_bench
from crawler_bench.config.schema import ConfigError, RunConfig, override
from crawler_bench.envs.crawler import CrawlerEnv
from crawler_bench.envs.keyhole_envs import KeyholeEnv
from crawler_bench.gait.rollout import begin_crawl, rollout
from crawler_bench.gait.stepwise import crawl
from crawler_bench.physics.parameters import CrawlerParameters
from crawler_bench.runs.evaluation import evaluate, measure, read_evaluation
from crawler_bench.runs.policies.acting import Acting, policy_of, remembers
from crawler_bench.runs.policies.table import action_table
from crawler_bench.runs.results import summarize
from crawler_bench.runs.training import train

N = 10
WARM_UP, DURATION = 20.0, 60.0
TIMES = {
    "starts": 4,
    "warm_up": WARM_UP,
    "duration": DURATION,
    "settle": 0,
    "gait": DURATION,
    "evaluation.noise": [0, 0.1],
}
RUN = override(RunConfig(), TIMES, "test")
SHORT = {"n_steps": 32, "batch_size": 32, "n_epochs": 1}


class Clock:
    """Turns the neurons ON in turn, whatever it senses: crawls, and no table can tell how."""

    def __init__(self, env: Any = None, seed: int | None = None) -> None:
        self.env = env

    def learn(self, total_timesteps, *, callback=None, progress_bar=False):
        return self

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        ticks = np.zeros(len(observation), dtype=np.int64) if state is None else state[0]
        ticks = np.where(episode_start, 0, ticks) if episode_start is not None else ticks
        return (-(ticks // 20)) % N, (ticks + 1,)

    def save(self, path):
        path.write_text("tick")

    @classmethod
    def load(cls, path, env):
        return cls(env)


class Started(gym.Wrapper):
    """Begins every episode where the warm-up of a start ends, and ends it after the duration of a crawl."""

    def __init__(self, env: CrawlerEnv, start: int) -> None:
        super().__init__(env)
        self.start = start

    def reset(self, **_: Any) -> tuple[Any, Any]:
        _, info = self.env.reset(seed=0)
        crawler: Any = self.env.unwrapped
        begun = begin_crawl(crawler.parameters, WARM_UP, (RUN.evaluation.seed, self.start))
        crawler.memory[:] = begun.memory
        crawler.odometer.episode_intervals = 0.0
        if isinstance(crawler, KeyholeEnv):
            return crawler._look(begun.observation, crawler.generator_state.copy(), 0.0), info
        return np.int64(begun.observation), info


def by_stable_baselines(
    agent: Any, keyhole: str = "index", episodes: int = 4, deterministic: bool = True
) -> np.ndarray:
    """Reward per decision of every episode, start by start."""
    kind, more = (CrawlerEnv, {}) if keyhole == "index" else (KeyholeEnv, {"keyhole": keyhole})
    limit = WARM_UP + DURATION  # the odometer of an episode has counted the warm-up, too

    def make(start: int) -> gym.Env:
        task = {"time_limit": DURATION, "episode_distance": 1e9, "regularization": 0.01}
        return Started(kind(CrawlerParameters(), **task, **more), start)

    assert limit > DURATION
    envs = DummyVecEnv([lambda start=start: make(start) for start in range(4)])
    returns, lengths = evaluate_policy(
        agent,
        envs,
        n_eval_episodes=episodes,
        deterministic=deterministic,
        return_episode_rewards=True,
        warn=False,
    )
    return np.array(returns) / np.array(lengths)


def ours(agent: Any, keyhole: str = "index", mode: str = "deterministic", seed: int = 0) -> np.ndarray:
    policy = policy_of(agent, keyhole, mode, N, seed)
    run = override(RUN, {"keyhole": keyhole, "regularization": 0.01}, "test")
    starts = measure(run, seed, policy, run.evaluation).starts
    return starts[starts["noise"] == 0]["reward"].to_numpy()


@pytest.fixture(scope="module")
def recurrent():
    torch.set_num_threads(1)
    return RecurrentPPO(
        "MlpLstmPolicy", gym.make(crawler_bench.ENV_ID), seed=0, learning_rate=0.01, **SHORT
    ).learn(128)


def test_a_clock_gets_what_stable_baselines_gives_it():
    assert remembers(Clock(), N)
    rewards = ours(Clock())
    np.testing.assert_allclose(np.sort(rewards), np.sort(by_stable_baselines(Clock())), rtol=1e-4)
    frozen = measure(
        RUN, 0, np.eye(N)[[0] * N], RUN.evaluation
    ).starts  # what is seen of it without its state
    assert rewards.mean() > frozen["reward"].max()


def test_a_recurrent_agent_gets_what_stable_baselines_gives_it(recurrent):
    np.testing.assert_allclose(
        np.sort(ours(recurrent)), np.sort(by_stable_baselines(recurrent)), rtol=1e-4, atol=1e-7
    )


def test_a_recurrent_agent_that_draws_gets_it_to_the_standard_error(recurrent):
    """Starts paired, draws independent: the difference of the means within four of its standard errors."""
    mine = np.concatenate([ours(recurrent, mode="stochastic", seed=seed) for seed in range(4)])
    recurrent.set_random_seed(99)
    theirs = by_stable_baselines(recurrent, episodes=16, deterministic=False)
    error = np.hypot(mine.std(ddof=1), theirs.std(ddof=1)) / np.sqrt(16)
    assert error > 0
    assert abs(mine.mean() - theirs.mean()) < 4 * error


@pytest.mark.parametrize("keyhole", ["one-hot", "strain", "state"])
def test_an_agent_at_another_keyhole_gets_what_stable_baselines_gives_it(keyhole):
    agent = A2C("MlpPolicy", gym.make(crawler_bench.KEYHOLE_IDS[keyhole]), seed=0).learn(50)
    np.testing.assert_allclose(
        np.sort(ours(agent, keyhole)), np.sort(by_stable_baselines(agent, keyhole)), rtol=1e-4, atol=1e-7
    )


@pytest.mark.parametrize(
    "body", [{}, {"decide_on": "change", "longest_hold": 0.6}], ids=["interval", "change"]
)
def test_asked_step_by_step_a_table_crawls_as_in_the_compiled_loop(body):
    """To the last bit, with noise."""
    parameters = CrawlerParameters(**body)
    chosen = np.array([0, 1, 2, 3, 5, 4, 6, 7, 9, 8])
    times = {"warm_up": 20.0, "duration": 60.0}
    starts, noise = [(1, 0), (1, 1), (1, 1)], [0.0, 0.0, 0.2]
    found = crawl(
        parameters,
        lambda seen, state, begins: (chosen[seen], state),
        "index",
        noise=noise,
        starts=starts,
        **times,
    )
    for record, start, level in zip(found, starts, noise, strict=True):
        expected = rollout(parameters, np.eye(N)[chosen], noise=level, start=start, **times)
        for name, values in vars(expected).items():
            np.testing.assert_array_equal(vars(record)[name], values, err_msg=name)
    assert (found[1].action != found[2].action).any()


def test_the_index_and_its_one_hot_are_one_policy():
    """A greedy network on zeros and ones meets the starts and the noise that its table meets on the index."""
    chosen = np.array([0, 1, 2, 3, 4, 5, 6, 8, 7, 9])
    times = {"warm_up": 20.0, "duration": 60.0, "noise": [0.1], "starts": [(1, 0)]}
    index = crawl(CrawlerParameters(), lambda seen, state, _: (chosen[seen], state), "index", **times)
    hot = crawl(
        CrawlerParameters(), lambda seen, state, _: (chosen[seen.argmax(axis=1)], state), "one-hot", **times
    )
    np.testing.assert_array_equal(index[0].displacement, hot[0].displacement)


def test_exploration_is_the_table_s(recurrent):
    """A value network explores in every crawl by itself, as often as it last did while learning."""
    agent = DQN("MlpPolicy", gym.make(crawler_bench.ENV_ID), seed=0, exploration_final_eps=0.3)
    agent.exploration_rate = 0.3
    acting = Acting(agent, "stochastic", N, 0)
    seen = np.repeat(np.arange(N), 3000)
    drawn = acting(seen, None, np.ones(seen.size, dtype=bool))[0].reshape(N, -1)
    counted = np.array([np.bincount(row, minlength=N) for row in drawn]) / 3000
    assert np.abs(counted - action_table(agent, N, "stochastic")).max() < 5 * 0.5 / np.sqrt(3000)


@pytest.mark.parametrize("mode", ["deterministic", "stochastic"])
def test_a_run_of_an_agent_with_a_memory_has_no_digits(tmp_path, mode, monkeypatch):
    settings = {f"settings.{name}": value for name, value in SHORT.items()}
    run = override(
        RUN,
        {
            "agent": "sb3_contrib:RecurrentPPO",
            "decisions": 64,
            "settings.policy": "MlpLstmPolicy",
            "mode": mode,
        }
        | settings,
        "test",
    )
    folder = train(run, 0, tmp_path)
    found = read_evaluation(evaluate(folder, trusted=[run.agent]))
    assert found.table.shape == (0, N)
    row = summarize(found, pd.read_csv(folder / "learning.csv"))
    assert row["policy"] == ""
    assert np.isnan(row["off_diagonal"])
    assert row["gradient_updates"] == 2
    assert np.isfinite(row["speed"])
    again = measure(run, 0, policy_of(*_loaded(folder, run), 0), run.evaluation)
    assert again.starts.equals(found.starts)  # draws are seeded


def _loaded(folder, run):
    from crawler_bench.runs.training import load_agent

    return load_agent(folder, run, [run.agent]), "index", run.evaluation.mode, N


class Hidden(Clock):
    """Remembers and does not tell."""

    tick = 0

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        self.tick += 1
        return np.full(len(observation), self.tick % N), None


class Stubborn(Clock):
    """Returns a state and takes none."""

    def predict(self, observation, deterministic=True):
        return np.zeros(len(observation), dtype=np.int64), (1,)


class Alone(Clock):
    """Cannot answer for several crawlers, and remembers."""

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.int64(3), (1,)


@pytest.mark.parametrize(
    ("agent", "said"),
    [
        (Hidden(), r"Hidden\.predict, asked again for its deterministic actions, gives others and no state"),
        (Stubborn(), r"Stubborn\.predict returns a state but takes no state"),
        (Alone(), r"Alone\.predict, asked for 10 observations, must return 10 whole numbers"),
    ],
    ids=["hidden", "stubborn", "alone"],
)
def test_what_cannot_be_measured_is_refused_in_one_line(agent, said):
    with pytest.raises(ConfigError, match=said) as caught:
        policy_of(agent, "index", "deterministic", N, 0)
    assert "\n" not in str(caught.value)


def test_a_table_still_goes_the_compiled_way(recurrent):
    agent = A2C("MlpPolicy", gym.make(crawler_bench.ENV_ID), seed=0)
    assert isinstance(policy_of(agent, "index", "stochastic", N, 0), np.ndarray)
    assert isinstance(policy_of(recurrent, "index", "stochastic", N, 0), Acting)
