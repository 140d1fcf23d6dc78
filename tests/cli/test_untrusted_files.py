"""Other people's files, through the commands: none runs what they hold, each says what it refuses."""

import shutil
import time

import pytest

from crawler_bench.config.schema import RunConfig, override, to_yaml
from crawler_bench.output import animation
from crawler_bench.runs import store
from crawler_bench.runs.folders import checksums
from crawler_bench.runs.long.running import UNFINISHED
from crawler_bench.runs.training import train
from tests.cli.command import complaint, crawler_bench
from tests.runs.malice import SHORT, poison, results_of, run_of

EVIL = "evil_agent:Evil"
PPO = {"agent": "ppo", "settings.n_steps": 32, "settings.batch_size": 32, "settings.n_epochs": 1} | SHORT


@pytest.fixture
def archive(tmp_path, marker):
    """A run of PPO whose archive holds a pickle."""
    folder = train(override(RunConfig(), PPO, "test"), 0, tmp_path / "runs")
    poison(folder / "agent.zip", marker)
    checksums.seal(folder, folder.name)
    return folder


def test_an_archive_with_a_pickle_is_measured_and_drawn_without_it(archive, marker, tmp_path, monkeypatch):
    monkeypatch.setattr(animation, "animate", lambda record, path, *_: path.touch())  # takes long
    assert crawler_bench("evaluate", archive, "--quiet")[0] == 0
    words = ("--out", tmp_path / "drawn", "--quiet")
    assert crawler_bench("render", archive, *words)[0] == 0
    assert (tmp_path / "drawn" / "gait.gif").is_file()
    assert not marker.exists()


def unfinished(folder, root):
    """A run that claims to be one of an agent of somebody's, in the middle."""
    config, seed = store.read_run(folder)
    place = store.run_folder(root, config, seed)
    saved = place.with_name(place.name + UNFINISHED) / "checkpoint"
    shutil.copytree(folder, saved)
    store.write_manifest(saved, time.monotonic(), save_every=5, gradient_updates=0)
    checksums.seal(saved, saved.name)
    return saved.parent


def test_a_class_that_a_file_names_is_imported_by_no_command(marker, tmp_path):
    run = run_of(EVIL, tmp_path / "run")
    entry = tmp_path / "entry.yaml"
    entry.write_text(to_yaml(override(RunConfig(), {"agent": EVIL} | SHORT, "test")))
    search = tmp_path / "search.yaml"
    search.write_text(f"agent: '{EVIL}'\nspace: {{settings.n_steps: {{start: 32, values: [32, 64]}}}}\n")
    results = results_of(tmp_path / "results", "evil", entry.read_text())
    commands = (
        ("evaluate", run),
        ("render", run, "--out", tmp_path / "drawn"),
        ("watch", run, "--seconds", "0.1"),
        ("train", "--continue", unfinished(run, tmp_path / "theirs")),
        ("train", "--config", entry, "--out", tmp_path / "trained"),
        ("tune", search, "--out", tmp_path / "tuned"),
        ("benchmark", "--agent", entry, "--out", tmp_path / "compared"),
        ("reproduce-cell", "ab", "--results", results),
    )
    for words in commands:
        code, said = complaint(*words)
        assert (words, code) == (words, 2)
        assert "neither ours nor installed" in said
    code, _, _ = crawler_bench("report", results, "--out", tmp_path / "page.html", "--quiet")
    assert code == 0
    assert EVIL not in (tmp_path / "page.html").read_text()
    assert not marker.exists()
    crawler_bench("train", "--config", entry, "--out", tmp_path / "trained", "--trust", "--quiet")
    assert marker.exists()
