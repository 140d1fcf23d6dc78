"""Others' learners: an environment that records itself, and what the tables make of it."""

import gymnasium as gym
import numpy as np
import pandas as pd
import pytest
from stable_baselines3 import A2C
from stable_baselines3.common.monitor import Monitor

import crawler_bench
from crawler_bench.benchmark.benchmark import run_benchmark
from crawler_bench.benchmark.keys import select
from crawler_bench.benchmark.recorded import ACTED, LEARNING, find, unknown, with_recorded
from crawler_bench.benchmark.results import write_benchmark
from crawler_bench.config.schema import ConfigError, Experiment, RunConfig, override
from crawler_bench.output.csv_files import read_csv
from crawler_bench.runs.evaluation import measure

TIMES = {"starts": 2, "warm_up": 5, "duration": 40, "settle": 20, "gait": 60, "evaluation.noise": [0, 0.1]}
RUN = override(RunConfig(agent="agents.reference:Wave", decisions=0), TIMES, "test")
CHOSEN = np.arange(10)


def crawl(env, decisions: int, chosen=CHOSEN) -> None:
    """A loop that knows nothing of ours: random for the first half, then the wave."""
    rng = np.random.default_rng(0)
    seen, _ = env.reset(seed=0)
    for t in range(decisions):
        index = int(np.argmax(seen)) if np.ndim(seen) else int(seen)
        action = rng.integers(10) if t < decisions // 2 else chosen[index]
        seen, _, _, truncated, _ = env.step(action)
        if truncated:
            seen, _ = env.reset()
    env.close()


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    root = tmp_path_factory.mktemp("recorded")
    for seed in (0, 1):
        env = gym.make(crawler_bench.KEYHOLE_IDS["one-hot"], regularization=0.01)
        crawl(
            crawler_bench.record(gym.wrappers.RecordEpisodeStatistics(env), root / f"theirs-{seed}"), 12_500
        )
    return root


def test_what_was_done_last_is_the_table(recorded):
    one, other = find(recorded, RUN)
    assert (one.agent, one.seed, other.agent, other.seed) == ("theirs", 0, "theirs", 1)
    assert one.config.environment.keyhole == "one-hot"
    assert one.config.environment.regularization == 0.01
    assert one.learning["decisions"].iloc[-1] == 12_500
    assert one.table is not None
    seen = one.table.max(axis=1) > 0.11
    np.testing.assert_array_equal(one.table[seen].argmax(axis=1), CHOSEN[seen])
    assert (one.table[seen].max(axis=1) == 1).all()
    assert seen.sum() >= 5
    assert unknown(one) == ""


def test_distance_time_and_reward_are_the_crawler_s(tmp_path):
    """Two environments of one run, counted together, against sums by hand."""
    total, ended_in_all = dict.fromkeys(("time", "distance", "reward"), 0.0), 0
    for _ in range(2):
        env = crawler_bench.record(
            gym.make(crawler_bench.ENV_ID, time_limit=50), tmp_path, agent="pair", seed=4
        )
        env.reset(seed=0)
        for t in range(700):
            _, reward, _, ended, _ = env.step(t % 10)
            total["reward"] += reward
            if ended:
                ended_in_all += 1
                env.reset()
        assert ended_in_all
        time, distance = env.unwrapped.lifetime
        total["time"] += time
        total["distance"] += distance
        env.close()
    (found,) = find(tmp_path, RUN)
    assert (found.agent, found.seed) == ("pair", 4)
    last = found.learning.iloc[-1]
    assert last["decisions"] == 1400
    assert last["episodes"] == ended_in_all
    for name, value in total.items():
        assert last[name] == pytest.approx(value, rel=1e-9), name


def test_a_vector_of_crawlers_records_itself(tmp_path):
    env = crawler_bench.record(gym.make_vec(crawler_bench.ENV_ID, num_envs=3), tmp_path / "vector-7")
    seen, _ = env.reset(seed=0)
    for _ in range(500):
        seen, *_ = env.step(CHOSEN[seen])
    env.close()
    (found,) = find(tmp_path, RUN)
    assert (found.agent, found.seed, found.learning["decisions"].iloc[-1]) == ("vector", 7, 1500)
    assert found.table is not None
    np.testing.assert_array_equal(found.table[[2, 5, 7]].argmax(axis=1), CHOSEN[[2, 5, 7]])


@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
def test_a_step_that_resets_is_no_decision(tmp_path, mode):
    """Where an episode ended, the next step of Gymnasium's default mode ignores its action."""
    env = gym.make_vec(crawler_bench.ENV_ID, num_envs=2, time_limit=4.0, autoreset_mode=mode)
    env = crawler_bench.record(env, tmp_path)
    env.reset(seed=0)
    ends = sum(env.step(np.array([3, 4]))[3].sum() for _ in range(100))
    assert ends >= 8
    env.close()
    (found,) = find(tmp_path, RUN)
    last = found.learning.iloc[-1]
    assert last["decisions"] == 200 - (ends if mode == "NextStep" else 0)
    assert last["episodes"] == ends
    assert last["time"] == pytest.approx(last["decisions"] * RUN.parameters.decision_interval)


def test_recording_changes_nothing(tmp_path):
    one, other = gym.make(crawler_bench.ENV_ID, noise=0.1), gym.make(crawler_bench.ENV_ID, noise=0.1)
    one = crawler_bench.record(one, tmp_path)
    assert one.reset(seed=3)[0] == other.reset(seed=3)[0]
    for action in np.random.default_rng(0).integers(10, size=200):
        assert one.step(action)[:4] == other.step(action)[:4]


def test_a_recorded_run_stands_in_the_tables(recorded, tmp_path):
    wave = Experiment(name="wave", run=RUN, seeds=(0, 1), grid={"environment.regularization": (0.0, 0.01)})
    found = run_benchmark([wave], tmp_path / "runs", jobs=1, quiet=True)
    others = find(recorded, RUN)
    together = with_recorded(found, others, RUN)
    write_benchmark(together, [wave], tmp_path / "out", say=lambda text: None, others=others)
    rows = select(read_csv(tmp_path / "out" / "runs.csv"), agent="theirs")
    assert rows["mode"].tolist() == [ACTED] * 2
    config = override(RUN, {"regularization": 0.01}, "test")
    starts = measure(config, 0, others[0].table, RUN.evaluation).starts
    assert rows["speed"].iloc[0] == pytest.approx(starts[starts["noise"] == 0]["speed"].mean(), rel=1e-8)
    assert rows["decisions"].tolist() == [12_500] * 2
    assert "theirs" in (tmp_path / "out" / "tables" / "comparison.md").read_text()
    pairs = read_csv(tmp_path / "out" / "pairs.csv")
    assert ((pairs["first_agent"] == "theirs") | (pairs["second_agent"] == "theirs")).any()
    assert set(read_csv(tmp_path / "out" / "curves.csv")["agent"]) == {"theirs"}


def test_monitor_files_say_what_they_can_and_what_is_unknown(tmp_path):
    folder = tmp_path / "monitored-3"
    folder.mkdir()
    env = Monitor(gym.make(crawler_bench.ENV_ID, time_limit=20), str(folder / "0"))
    A2C("MlpPolicy", env, seed=0).learn(1000)
    env.close()
    (found,) = find(tmp_path, RUN)
    assert (found.agent, found.seed, found.table) == ("monitored", 3, None)
    assert "unknown are distance and time, and its frozen policy" in unknown(found)
    wave = Experiment(name="wave", run=RUN, seeds=(0, 1))
    row = select(
        with_recorded(run_benchmark([wave], tmp_path / "runs", jobs=1, quiet=True), [found], RUN).runs,
        agent="monitored",
    ).iloc[0]
    episodes = pd.read_csv(next(folder.glob("*monitor.csv")), skiprows=1)
    assert row["mode"] == LEARNING
    ends = episodes["l"].cumsum()
    last = episodes[ends > ends[int(0.9 * (len(episodes) + 1)) - 2]]  # those of the last tenth
    assert len(last) <= 2
    assert row["reward"] == pytest.approx(last["r"].sum() / last["l"].sum())
    assert np.isnan(row["speed_learning_end"])
    assert row["decisions"] == episodes["l"].sum()


def test_another_body_and_a_broken_recording_are_refused_in_one_line(recorded, tmp_path):
    with pytest.raises(ConfigError, match="theirs-0 was recorded on another body"):
        find(recorded, override(RUN, {"damping": 2.0}, "test"))
    (tmp_path / "recorded.json").write_text("{}")
    with pytest.raises(ConfigError, match="is no recording"):
        find(tmp_path, RUN)
    with pytest.raises(TypeError, match="record needs a crawler of ours"):
        crawler_bench.record(gym.make("CartPole-v1"), tmp_path / "cart")
