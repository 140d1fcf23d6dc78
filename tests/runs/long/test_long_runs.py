"""Long runs: a run that was interrupted and gone on with is the run that was not."""

import pickle
import shutil
import subprocess
import sys
import time
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from crawler_bench.config.schema import ConfigError, RunConfig, override
from crawler_bench.runs import store
from crawler_bench.runs.folders import checksums
from crawler_bench.runs.long import running
from crawler_bench.runs.long.running import UNFINISHED, Habits, finished, read_unfinished, train_long
from crawler_bench.runs.training import LearningRecorder, load_agent, train
from tests.runs.malice import Payload, poison

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


def killed(config: RunConfig, root: Path, habits: Habits, at: int = 400) -> Path:
    """What is left of a run that ends in the middle."""

    class Fragile(LearningRecorder):
        def __call__(self, local, _global):
            if local["self"].num_timesteps >= at:
                raise Killed
            return super().__call__(local, _global)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(running, "LearningRecorder", Fragile)
        with pytest.raises(Killed):
            train_long(config, 3, root, habits)
    (place,) = root.iterdir()
    assert place.name.endswith(UNFINISHED)
    return place


def go_on(folder: Path, habits: Habits, trust: bool = False) -> Path:
    """As `train --continue` does."""
    if (done := finished(folder)) is not None:
        return done
    config, seed, before = read_unfinished(folder, trust)
    kept = replace(habits, save_every=habits.save_every or before.save_every)
    return train_long(config, seed, folder.parent, kept)


@pytest.mark.parametrize("name", RUNS)
def test_a_killed_run_goes_on_as_if_nothing_had_been(name, tmp_path):
    config = override(RunConfig(decisions=640), RUNS[name], "test")
    whole = train(config, 3, tmp_path / "whole")
    place = killed(config, tmp_path / "parts", Habits(save_every=100))
    kept = load_decisions(place)
    assert 400 - 100 - 32 <= kept < 400  # at most `save_every` and a rollout are lost
    np.random.seed(1)  # noqa: NPY002 (whatever else was drawn meanwhile must not matter)
    folder = go_on(place, Habits())
    assert folder.name == whole.name
    assert not place.exists()
    np.testing.assert_array_equal(weights(folder, config), weights(whole, config))
    pd.testing.assert_frame_equal(pd.read_csv(folder / "learning.csv"), pd.read_csv(whole / "learning.csv"))


@pytest.fixture(scope="module", params=["ppo", "dqn, state"])
def unfinished(request, tmp_path_factory):
    """A run with a checkpoint, to copy, and its configuration."""
    config = override(RunConfig(decisions=640), RUNS[request.param] | {"time_limit": 4.0}, "test")
    root = tmp_path_factory.mktemp("unfinished")
    return killed(config, root, Habits(save_every=100, eval_every=100)), config


def copy_of(place: Path, root: Path) -> Path:
    return Path(shutil.copytree(place, root / place.name))


def test_a_kill_between_two_checkpoints_loses_neither(unfinished, tmp_path, monkeypatch):
    place = copy_of(unfinished[0], tmp_path)
    kept = load_decisions(place)
    (place / "checkpoint").rename(place / ".partial-checkpoint-old-abcd1234")
    (place / ".partial-checkpoint-efgh5678").mkdir()
    restore, found = running.restore, []

    def restored(saved, agent, *others):
        restore(saved, agent, *others)
        found.append(agent.num_timesteps)

    monkeypatch.setattr(running, "restore", restored)
    folder = go_on(place, Habits())
    assert found == [kept]
    assert [path.name for path in tmp_path.iterdir()] == [folder.name]
    assert go_on(place, Habits()) == folder


def test_what_was_evaluated_before_a_kill_is_kept(unfinished, tmp_path):
    folder = go_on(copy_of(unfinished[0], tmp_path), Habits(eval_every=100))
    with np.load(folder / "evaluations.npz") as found:
        assert found["timesteps"].tolist() == [100, 200, 300, 400, 500, 600]
        assert len(found["results"]) == 6


def damaged(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-20])


def test_a_damaged_checkpoint_is_said_in_one_line(unfinished, tmp_path):
    place, config = unfinished
    files = sorted(path.name for path in (place / "checkpoint").iterdir())
    assert {"agent.zip", "crawlers.npz", "position.npz", "evaluations.npz", "config.yaml"} < set(files)
    for name in files:
        copy = copy_of(place, tmp_path / name)
        damaged(copy / "checkpoint" / name)
        said = f"{name} (was changed|is damaged)"
        with pytest.raises(store.NotARunError, match=said) as caught:
            go_on(copy, Habits())
        assert "\n" not in str(caught.value)
        with pytest.raises(store.NotARunError, match=said):
            train_long(config, 3, copy.parent, Habits(save_every=100))
        if name not in ("manifest.json", "config.yaml", "learning.csv"):
            checksums.seal(copy / "checkpoint", "checkpoint")  # and by whoever did it
            with pytest.raises(store.NotARunError, match=r"cannot be (gone on from|read)") as caught:
                go_on(copy, Habits(eval_every=100))
            assert "\n" not in str(caught.value)


@pytest.mark.parametrize("unfinished", ["dqn, state"], indirect=True)
@pytest.mark.parametrize(
    ("file", "name", "value", "said"),
    [
        ("replay_buffer", "pos", np.array(10**9), "pos = 1000000000"),
        ("replay_buffer", "rewards", np.zeros((1, 2), np.float32), "rewards is not"),
        ("replay_buffer", "dones", np.zeros(2**18), "unpacks to"),
        ("crawlers", "memory", np.float64(0.0), "memory is not"),
        ("crawlers", "memory", np.array(["x"], dtype=object), "allow_pickle"),
        ("position", "_last_obs", np.full((2, 64), np.nan, np.float32), "_last_obs is not"),
    ],
)  # fmt: skip
def test_arrays_that_fit_nowhere_are_refused(unfinished, tmp_path, file, name, value, said):
    saved = copy_of(unfinished[0], tmp_path) / "checkpoint"
    path = saved / f"{file}.npz"
    with np.load(path) as arrays:
        changed = dict(arrays) | {name: value}
    np.savez_compressed(path, **changed)
    checksums.seal(saved, "checkpoint")
    with pytest.raises(store.NotARunError, match=said):
        go_on(saved.parent, Habits())


def test_a_checkpoint_of_somebody_else_runs_none_of_their_code(unfinished, tmp_path, marker):
    place, config = unfinished
    saved = copy_of(place, tmp_path / "data") / "checkpoint"
    poison(saved / "agent.zip", marker)
    checksums.seal(saved, "checkpoint")
    assert store.is_run(go_on(saved.parent, Habits()))

    saved = copy_of(place, tmp_path / "weights") / "checkpoint"
    with zipfile.ZipFile(saved / "agent.zip", "w") as archive:
        archive.writestr("data", "{}")
        archive.writestr("policy.pth", pickle.dumps(Payload(marker)))
    checksums.seal(saved, "checkpoint")
    with pytest.raises(store.NotARunError, match="cannot be gone on from"):
        go_on(saved.parent, Habits())

    evil = config.model_copy(update={"agent": "evil_agent:Evil"})
    theirs = store.run_folder(tmp_path, evil, 3)
    theirs = theirs.with_name(theirs.name + UNFINISHED)
    saved = Path(shutil.copytree(place, theirs)) / "checkpoint"
    store.write_config(saved, evil, 3)
    checksums.seal(saved, "checkpoint")
    with pytest.raises(ConfigError, match=r"names the agent 'evil_agent:Evil'.*--trust"):
        go_on(theirs, Habits())
    assert not marker.exists()
    with pytest.raises(ConfigError, match="no agent of Stable-Baselines3"):
        go_on(theirs, Habits(), trust=True)
    assert marker.exists()


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
        go_on(tmp_path / "nothing", Habits())
