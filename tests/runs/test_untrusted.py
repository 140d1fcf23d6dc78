"""Other people's files: whatever they hold, nothing of it is run; each payload here would write a marker."""

import io
import pickle
import zipfile

import numpy as np
import pytest

from crawler_bench.benchmark.reproduce_cell import reproduce
from crawler_bench.config.files import load_experiment, load_tuning
from crawler_bench.config.schema import ConfigError, RunConfig, override, to_yaml
from crawler_bench.runs import store, training
from crawler_bench.runs.agent import agent_class
from crawler_bench.runs.evaluation import evaluate
from crawler_bench.runs.live import live
from crawler_bench.runs.long.running import read_unfinished
from crawler_bench.runs.policies.table import action_table
from crawler_bench.runs.untrusted import MOST_UNPACKED, agents_of, inside, require_bounded, require_trust
from tests.cli.command import complaint, crawler_bench
from tests.runs.malice import SHORT, Payload, poison, results_of, run_of

SETTINGS = {"ppo": {"n_steps": 32, "batch_size": 32, "n_epochs": 1}, "dqn": {"learning_starts": 8}}


def test_a_class_that_a_run_folder_names_is_not_imported_unasked(tmp_path, marker):
    folder = run_of("evil_agent:Evil", tmp_path / "run")
    with pytest.raises(ConfigError, match=r"config\.yaml names the agent 'evil_agent:Evil'.*--trust"):
        evaluate(folder)
    with pytest.raises(ConfigError, match="--trust"):
        live(folder, "deterministic", 0)
    assert not marker.exists()
    with pytest.raises(store.NotARunError):
        live(folder, "deterministic", 0, trust=True)
    with pytest.raises(store.NotARunError):  # it is no saved agent, but was imported
        evaluate(folder, trusted=["evil_agent:Evil"])
    assert marker.exists()


def test_neither_a_window_nor_going_on_imports_what_a_folder_names_unasked(tmp_path, marker):
    folder = run_of("evil_agent:Evil", tmp_path / "run")
    (tmp_path / "begun.unfinished").mkdir()
    run_of("evil_agent:Evil", tmp_path / "begun.unfinished" / "checkpoint")
    refused = pytest.raises(ConfigError, match=r"config\.yaml names the agent 'evil_agent:Evil'.*--trust")
    with refused:
        live(folder, "deterministic", 0)
    with refused:
        read_unfinished(tmp_path / "begun")
    assert not marker.exists()
    with pytest.raises(store.NotARunError, match="other sources"):
        read_unfinished(tmp_path / "begun", trust=True)
    with pytest.raises(store.NotARunError, match="cannot be loaded"):
        live(folder, "deterministic", 0, trust=True)
    assert marker.exists()


def test_training_imports_what_a_configuration_names_when_asked(tmp_path, marker):
    path = tmp_path / "theirs.yaml"
    path.write_text("agent: evil_agent:Evil\ndecisions: 0")
    words = ("train", "--config", path, "--out", tmp_path / "runs")
    code, said = complaint(*words)
    assert code == 2
    assert "theirs.yaml names the agent 'evil_agent:Evil'" in said
    assert not marker.exists()
    assert crawler_bench(*words, "--trust")[0] == 0
    assert marker.exists()


@pytest.mark.parametrize("agent", ["ppo", "dqn"])
def test_an_archive_is_read_without_pickle(tmp_path, marker, agent):
    changes = {f"settings.{key}": value for key, value in SETTINGS[agent].items()}
    config = override(RunConfig(), {"agent": agent, "crawlers": 2} | SHORT | changes, "test")
    folder = training.train(config, 0, tmp_path / "runs")
    learned, _ = training.learn(config, 0)
    path = folder / "agent.zip"
    poison(path, marker)
    read = training.load_agent(folder, config)
    assert not marker.exists()
    for mode in ("deterministic", "stochastic"):
        np.testing.assert_array_equal(action_table(read, 10, mode), action_table(learned, 10, mode))
    agent_class(agent).load(path)
    assert marker.exists()  # the payload works


def test_weights_that_are_a_pickle_are_refused(tmp_path, marker):
    config = override(RunConfig(), {"agent": "ppo"} | SHORT, "test")
    with zipfile.ZipFile(tmp_path / "agent.zip", "w") as archive:
        archive.writestr("data", "{}")
        archive.writestr("policy.pth", pickle.dumps(Payload(marker)))
    with pytest.raises(store.NotARunError, match=r"agent\.zip cannot be loaded: .*--trust"):
        training.load_agent(tmp_path, config)
    assert not marker.exists()


@pytest.mark.parametrize("text", ["agent: evil_agent:Evil", "grid: {agent: [random, 'evil_agent:Evil']}"])
def test_a_class_that_a_yaml_file_names_is_not_imported_unasked(tmp_path, marker, text):
    path = tmp_path / "entry.yaml"
    path.write_text(text)
    entry = load_experiment(path)
    with pytest.raises(ConfigError, match=r"entry\.yaml names the agent 'evil_agent:Evil'"):
        require_trust(agents_of(entry), path)
    require_trust(agents_of(entry), path, agents_of(entry))
    path.write_text("space: {agent: {start: random, values: ['evil_agent:Evil']}}")
    with pytest.raises(ConfigError, match="evil_agent"):
        require_trust(agents_of(load_tuning(path)), path)
    assert not marker.exists()


def test_names_that_are_ours_or_installed_need_no_trust(tmp_path):
    require_trust(["qlearning", "agents.deep:PPO"], tmp_path)
    with pytest.raises(ConfigError):
        require_trust(["subprocess:Popen"], tmp_path)


def test_reproducing_a_cell_reads_nothing_outside_the_results(tmp_path, marker):
    evil = to_yaml(RunConfig(agent="evil_agent:Evil", decisions=0))
    (tmp_path / "elsewhere.yaml").write_text(evil)
    for agent in ("../../elsewhere", str(tmp_path / "elsewhere")):
        folder = results_of(tmp_path / f"results{len(agent)}", agent, evil)
        with pytest.raises(ConfigError, match="which is outside of it"):
            reproduce(folder, "ab", jobs=1, quiet=True, trust=True)
    folder = results_of(tmp_path / "named", "evil", evil)
    with pytest.raises(ConfigError, match="'evil_agent:Evil', which is neither ours nor installed"):
        reproduce(folder, "ab", jobs=1, quiet=True)
    assert not marker.exists()


def test_a_name_with_dots_is_no_way_out(tmp_path):
    assert inside(tmp_path, "a..b.yaml").name == "a..b.yaml"
    assert inside(tmp_path, "b", "..", "a").name == "a"
    for name in ("..", "a/../../b", "/etc/hosts"):
        with pytest.raises(ConfigError, match="outside"):
            inside(tmp_path, name)


def test_no_archive_unpacks_beyond_a_bound(tmp_path):
    path = tmp_path / "bomb.zip"
    with (
        zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
        archive.open("zeros", "w") as file,
    ):
        for _ in range(MOST_UNPACKED // 2**24 + 1):
            file.write(bytes(2**24))
    assert path.stat().st_size < 2**21
    with pytest.raises(ValueError, match="unpacks to"):
        require_bounded(path)
    buffer = io.BytesIO()
    np.savez_compressed(buffer, small=np.zeros(5))
    path.write_bytes(buffer.getvalue())
    require_bounded(path)
