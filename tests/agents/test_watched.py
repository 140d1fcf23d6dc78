"""The learner under Stable-Baselines3's callbacks, loggers and vector environments."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pandas as pd
import pytest
from stable_baselines3.common.callbacks import (
    BaseCallback,
    CheckpointCallback,
    EvalCallback,
    EveryNTimesteps,
    LogEveryNTimesteps,
    StopTrainingOnMaxEpisodes,
    StopTrainingOnNoModelImprovement,
    StopTrainingOnRewardThreshold,
)
from stable_baselines3.common.logger import configure
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import DummyVecEnv, VecEnv, VecNormalize

import crawler_bench
from agents.qlearning import QLearning
from crawler_bench.envs.crawler import CrawlerEnv
from crawler_bench.envs.sb3 import CrawlerVecEnv
from crawler_bench.physics import CrawlerParameters

SHORT: dict[str, Any] = {  # episodes of 20 decisions
    "parameters": CrawlerParameters(decision_interval=0.2), "time_limit": 4.0, "episode_distance": 2.0,
}  # fmt: skip


def crawler(**arguments: Any) -> gym.Env[Any, Any]:
    return gym.make(crawler_bench.ENV_ID, **SHORT | arguments)


class Witness(BaseCallback):
    """Keeps what a callback can see."""

    def __init__(self) -> None:
        super().__init__()
        self.seen: list[dict[str, Any]] = []
        self.calls: list[str] = []

    def _on_training_start(self) -> None:
        self.calls.append("start")

    def _on_step(self) -> bool:
        names = ("new_obs", "rewards", "dones", "infos", "actions")
        self.seen.append({name: self.locals[name] for name in names} | {"at": self.num_timesteps})
        return True

    def _on_training_end(self) -> None:
        self.calls.append("end")


def test_a_callback_sees_every_decision_and_changes_none() -> None:
    witness = Witness()
    watched = QLearning(crawler(), seed=3).learn(1005, callback=witness)
    np.testing.assert_array_equal(watched.q_table, QLearning(crawler(), seed=3).learn(1005).q_table)
    assert witness.calls == ["start", "end"]
    assert [each["at"] for each in witness.seen] == list(range(1, 1006))
    assert witness.model is watched  # type: ignore[comparison-overlap]
    assert isinstance(witness.training_env, VecEnv)
    ends = [each["infos"][0] for each in witness.seen if each["dones"][0]]
    assert len(ends) == 50
    assert all(info["TimeLimit.truncated"] and info["episode"]["l"] == 20 for info in ends)
    total = sum(each["rewards"][0] for each in witness.seen[:20])
    assert ends[0]["episode"]["r"] == pytest.approx(total, abs=1e-6)


def test_an_episode_that_was_not_watched_whole_is_not_reported() -> None:
    agent, witness = QLearning(crawler(), seed=3).learn(13), Witness()
    agent.learn(40, callback=witness)
    reports = [each["infos"][0].get("episode") for each in witness.seen if each["dones"][0]]
    assert len(reports) == 2
    assert reports[0] is None
    assert reports[1]["l"] == 20


def test_stable_baselines_callbacks_do_their_work(tmp_path: Path) -> None:
    """Best agent and checkpoints are saved and can be loaded; evaluations are kept."""
    judge = Monitor(CrawlerEnv(**SHORT))
    evaluation = EvalCallback(
        judge, n_eval_episodes=2, eval_freq=50, best_model_save_path=str(tmp_path), log_path=str(tmp_path),
        callback_after_eval=StopTrainingOnNoModelImprovement(max_no_improvement_evals=1000), warn=False,
        verbose=0,
    )  # fmt: skip
    checkpoints = CheckpointCallback(save_freq=100, save_path=str(tmp_path), name_prefix="table")
    event = CheckpointCallback(save_freq=1, save_path=str(tmp_path), name_prefix="event")
    agent = QLearning(crawler(), seed=0)
    agent.learn(200, callback=[evaluation, checkpoints, EveryNTimesteps(150, event), LogEveryNTimesteps(64)])
    saved = QLearning.load(tmp_path / "table_100_steps.zip")
    np.testing.assert_array_equal(saved.q_table, QLearning(crawler(), seed=0).learn(100).q_table)
    assert QLearning.load(tmp_path / "best_model").q_table.shape == (10, 10)
    assert (tmp_path / "event_150_steps.zip").exists()
    assert np.load(tmp_path / "evaluations.npz")["timesteps"].tolist() == [50, 100, 150, 200]


@pytest.mark.parametrize(
    ("stop", "at"),
    [
        (lambda: StopTrainingOnMaxEpisodes(3), 60),
        (
            lambda: EvalCallback(
                Monitor(CrawlerEnv(**SHORT)), StopTrainingOnRewardThreshold(-1e3, 0), eval_freq=7, verbose=0,
                n_eval_episodes=1, warn=False,
            ),
            7,
        ),
    ],
)  # fmt: skip
def test_a_callback_stops_the_learning(stop: Callable[[], BaseCallback], at: int) -> None:
    agent = QLearning(crawler(), seed=0)
    assert agent.learn(500, callback=stop()).num_timesteps == at


def test_a_function_is_called_as_often_when_learning_is_watched() -> None:
    seen: list[int] = []

    def stop_at_2000(local: dict[str, Any], _: dict[str, Any]) -> bool:
        seen.append(local["self"].num_timesteps)
        return seen[-1] < 2000

    agent = QLearning(crawler(), seed=0)
    agent.set_logger(configure(None, []))
    agent.learn(1500, callback=stop_at_2000).learn(9000, callback=stop_at_2000)
    assert seen == [1000, 1500, 2000]


def test_the_log_has_a_point_every_few_episodes(tmp_path: Path) -> None:
    agent = QLearning(crawler(), seed=0)
    agent.set_logger(configure(str(tmp_path), ["csv"]))
    agent.learn(205, log_interval=5)
    agent.logger.close()
    log = pd.read_csv(tmp_path / "progress.csv")
    assert log["time/total_timesteps"].tolist() == [100, 200]
    assert log["time/episodes"].tolist() == [5, 10]
    assert log["rollout/ep_len_mean"].tolist() == [20, 20]
    returns = [episode["r"] for episode in agent.ep_info_buffer]
    assert log["rollout/ep_rew_mean"].tolist() == pytest.approx([np.mean(returns[:5]), np.mean(returns)])


def test_the_log_goes_to_the_screen_on_request(capsys: pytest.CaptureFixture[str]) -> None:
    QLearning(crawler(), seed=0, verbose=1).learn(100)
    assert "ep_rew_mean" in capsys.readouterr().out
    QLearning(crawler(), seed=0).learn(100)
    assert capsys.readouterr().out == ""


def test_counting_from_0_again_keeps_the_table() -> None:
    agent = QLearning(crawler(), seed=0).learn(130)
    assert agent.learn(10).num_timesteps == 140
    table = agent.q_table.copy()
    agent.learn(0, reset_num_timesteps=True)
    assert agent.num_timesteps == 0
    assert agent.env is not None
    assert agent.env.unwrapped.get_state()["odometer"][0] == 0  # type: ignore[union-attr]
    np.testing.assert_array_equal(agent.q_table, table)


@pytest.mark.parametrize("vec_env", [
    lambda: DummyVecEnv([lambda: CrawlerEnv(**SHORT)]), lambda: CrawlerVecEnv(1, **SHORT),
    lambda: VecNormalize(CrawlerVecEnv(1, **SHORT), training=False, norm_obs=False, norm_reward=False),
])  # fmt: skip
@pytest.mark.parametrize("end_is_terminal", [False, True])
def test_a_vector_of_one_is_learned_from_as_the_one(
    vec_env: Callable[[], VecEnv], end_is_terminal: bool
) -> None:
    """Up to rewards, which Stable-Baselines3 rounds to single precision."""
    settings: dict[str, Any] = {"seed": 4, "end_is_terminal": end_is_terminal}
    agent, single = QLearning(vec_env(), **settings), QLearning(CrawlerEnv(**SHORT), **settings)
    tables = agent.learn(400).q_table, single.learn(400).q_table
    np.testing.assert_allclose(*tables, rtol=0, atol=1e-8)
    assert isinstance(agent.get_env(), VecEnv)
    assert (agent.get_vec_normalize_env() is None) != isinstance(agent.get_env(), VecNormalize)


def test_several_environments_are_refused() -> None:
    with pytest.raises(ValueError, match="one environment at a time, not from 2"):
        QLearning(CrawlerVecEnv(2))


def test_learning_in_a_vector_of_one_resumes_in_mid_episode(tmp_path: Path) -> None:
    def vector() -> DummyVecEnv:
        return DummyVecEnv([lambda: CrawlerEnv(**SHORT)])

    whole = QLearning(vector(), seed=1).learn(300)
    QLearning(vector(), seed=1).learn(137).save(tmp_path / "agent.json")
    resumed = QLearning.load(tmp_path / "agent.json", vector()).learn(163)
    np.testing.assert_array_equal(resumed.q_table, whole.q_table)


def test_spaces_are_those_of_the_environment(tmp_path: Path) -> None:
    agent = QLearning(crawler(), seed=0)
    assert agent.observation_space == agent.action_space == gym.spaces.Discrete(10)
    agent.save(tmp_path / "agent.json")
    alone = QLearning.load(tmp_path / "agent.json")
    assert alone.observation_space == alone.action_space == gym.spaces.Discrete(10)
    assert alone.get_env() is None
