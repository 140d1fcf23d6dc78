"""Long runs: a run that was interrupted and gone on with is the run that was not."""

import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from crawler_bench.config.schema import ConfigError, RunConfig, override
from crawler_bench.runs import checkpoints, store
from crawler_bench.runs.checkpoints import UNFINISHED, Habits, read_unfinished, train_long
from crawler_bench.runs.training import LearningRecorder, load_agent, train

ON = {"settings.n_steps": 16, "settings.batch_size": 16, "settings.n_epochs": 1}
OFF = {"settings.learning_starts": 16, "settings.buffer_size": 200, "settings.train_freq": 4}
RUNS = {
    "ppo": {"agent": "ppo", "crawlers": 2, **ON}, "recurrent": {"agent": "recurrent-ppo", **ON},
    "dqn": {"agent": "dqn", **OFF}, "dqn, state": {"agent": "dqn", "keyhole": "state", "crawlers": 2, **OFF},
}  # fmt: skip


class Killed(Exception):
    """What ends a run in the middle."""


def weights(folder: Path, config: RunConfig) -> np.ndarray:
    agent = load_agent(folder, config)
    return np.concatenate([each.detach().numpy().ravel() for each in agent.policy.parameters()])


@pytest.mark.parametrize("name", RUNS)
def test_a_killed_run_goes_on_as_if_nothing_had_been(name, tmp_path, monkeypatch):
    config = override(RunConfig(decisions=640), RUNS[name], "test")
    whole = train(config, 3, tmp_path / "whole")

    def killing(self, local, _global):
        if local["self"].num_timesteps >= 400:
            raise Killed
        return LearningRecorder.__call__(self, local, _global)

    class Fragile(LearningRecorder):
        __call__ = killing

    with monkeypatch.context() as patch:
        patch.setattr(checkpoints, "LearningRecorder", Fragile)
        with pytest.raises(Killed):
            train_long(config, 3, tmp_path / "parts", Habits(save_every=100))
    (place,) = (tmp_path / "parts").iterdir()
    assert place.name.endswith(UNFINISHED)
    kept = load_decisions(place)
    assert 400 - 100 - 32 <= kept < 400  # at most `save_every` and a rollout are lost
    np.random.seed(1)  # noqa: NPY002 (whatever else was drawn meanwhile must not matter)
    found, seed, habits = read_unfinished(place)
    assert (found, seed, habits) == (config, 3, Habits(save_every=100))
    folder = train_long(found, seed, place.parent, habits)
    assert folder.name == whole.name
    assert not place.exists()
    np.testing.assert_array_equal(weights(folder, config), weights(whole, config))
    pd.testing.assert_frame_equal(pd.read_csv(folder / "learning.csv"), pd.read_csv(whole / "learning.csv"))


def load_decisions(place: Path) -> int:
    import json
    from zipfile import ZipFile

    with ZipFile(place / "checkpoint" / "agent.zip") as archive:
        return int(json.loads(archive.read("data"))["num_timesteps"])


@pytest.mark.slow
def test_a_kill_loses_no_more_than_it_says(tmp_path):
    words = "train dqn --set decisions=30000 --save-every 1000 --quiet --out".split()
    command = [sys.executable, "-m", "crawler_bench.cli", *words, str(tmp_path)]
    running = subprocess.Popen(command)
    deadline = time.monotonic() + 300
    while not list(tmp_path.glob("*.unfinished/checkpoint/agent.zip")) and time.monotonic() < deadline:
        time.sleep(0.2)
    running.kill()
    running.wait()
    (place,) = tmp_path.glob("*.unfinished")
    assert load_decisions(place) >= 1000
    done = subprocess.run(
        [*command[:4], "--continue", str(place)], capture_output=True, text=True, timeout=600, check=True
    )
    assert store.is_run(Path(done.stdout.strip()))


def test_evaluations_and_events_are_left_where_one_looks_for_them(tmp_path):
    pytest.importorskip("tensorboard")
    config = override(RunConfig(decisions=128), RUNS["ppo"] | {"time_limit": 4.0}, "test")
    folder = train_long(config, 0, tmp_path / "runs", Habits(eval_every=64, tensorboard=tmp_path / "events"))
    with np.load(folder / "evaluations.npz") as found:
        assert found["timesteps"].tolist() == [64, 128]
        assert np.isfinite(found["results"]).all()
    assert list((tmp_path / "events").rglob("events.out.tfevents*"))
    np.testing.assert_array_equal(
        weights(folder, config), weights(train(config, 0, tmp_path / "plain"), config)
    )


def test_what_cannot_go_on_is_refused_in_one_line(tmp_path):
    with pytest.raises(ConfigError, match="only those save, evaluate and log on the way"):
        train_long(RunConfig(agent="qlearning", decisions=10), 0, tmp_path, Habits(save_every=5))
    with pytest.raises(ConfigError, match="no checkpoint to go on from"):
        read_unfinished(tmp_path / "nothing")
