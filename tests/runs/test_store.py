"""Run folders: published whole or not at all, made once however many ask, read as written."""

import errno
import json
import os
import shutil
import time
from pathlib import Path

import pytest

from crawler_bench.config.schema import RunConfig, override
from crawler_bench.runs import store
from crawler_bench.runs.folders import checksums, claims
from crawler_bench.runs.folders.keys import training_key

RUN = RunConfig(agent="random")


def test_folder_names_are_readable():
    folder = store.run_folder(Path("runs"), RUN, 3)
    assert folder == Path("runs") / f"random-eps0.01-seed03-{training_key(RUN, 3)}"


def test_publishing_is_all_or_nothing(tmp_path):
    folder = tmp_path / "deep" / "run"
    with store.publish(folder) as draft:
        (draft / "file").write_text("whole")
        same = draft.stat().st_ino
        assert not folder.exists()
    assert folder.stat().st_ino == same  # renamed, not copied
    assert [path.name for path in folder.parent.iterdir()] == ["run"]
    assert (folder / "file").read_text() == "whole"
    assert folder.stat().st_mode & 0o777 == 0o755


def test_a_folder_that_cannot_be_replaced_stays_as_it_was(tmp_path, monkeypatch):
    folder = tmp_path / "results"
    folder.mkdir()
    (folder / "file").write_text("old")
    with pytest.raises(FileNotFoundError), store.replace(folder) as draft:
        shutil.rmtree(draft)
    assert (folder / "file").read_text() == "old"

    def rename(path, target):
        if path.name.startswith(".partial-results-") and "-old-" not in path.name:
            raise OSError(errno.ENOSPC, "full", str(path))
        return os.rename(path, target)

    with monkeypatch.context() as patch:
        patch.setattr(Path, "rename", rename)
        with pytest.raises(OSError, match="full"), store.replace(folder) as draft:
            (draft / "file").write_text("new")
    assert (folder / "file").read_text() == "old"
    assert list(tmp_path.iterdir()) == [folder]
    with store.replace(folder) as draft:
        (draft / "file").write_text("new")
    assert (folder / "file").read_text() == "new"
    assert list(tmp_path.iterdir()) == [folder]


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt])
def test_a_failed_draft_leaves_nothing(tmp_path, error):
    def write():
        with store.publish(tmp_path / "run") as draft:
            (draft / "file").write_text("half")
            raise error

    with pytest.raises(error):
        write()
    assert not list(tmp_path.iterdir())


def test_the_second_publisher_of_a_folder_leaves_the_first_ones(tmp_path):
    folder = tmp_path / "run"
    with store.publish(folder) as slow:
        (slow / "file").write_text("second")
        (slow / store.MANIFEST).write_text("{}")
        with store.publish(folder) as quick:
            (quick / "file").write_text("first")
            (quick / store.MANIFEST).write_text("{}")
    assert (folder / "file").read_text() == "first"
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


def test_a_folder_without_a_manifest_is_replaced(tmp_path):
    folder = tmp_path / "run"
    folder.mkdir()
    (folder / "file").write_text("broken")
    with store.publish(folder) as draft:
        (draft / "file").write_text("whole")
        (draft / store.MANIFEST).write_text("{}")
    assert (folder / "file").read_text() == "whole"


def test_a_run_is_read_as_written(tmp_path):
    run = override(RUN, {"settings.learning_rate": 1e-7, "regularization": 7.5}, "test")
    assert not store.is_run(tmp_path)
    store.write_config(tmp_path, run, 5)
    assert not store.is_run(tmp_path)
    store.write_manifest(tmp_path, time.monotonic())
    assert store.is_run(tmp_path)
    with pytest.raises(store.NotARunError, match="holds no checksums"):
        store.read_run(tmp_path)
    checksums.seal(tmp_path, "run")
    assert store.read_run(tmp_path) == (run, 5)


def test_a_clock_that_is_set_back_does_not_change_what_a_run_took(tmp_path, monkeypatch):
    started = time.monotonic()
    monkeypatch.setattr(time, "time", lambda: 0.0)
    store.write_manifest(tmp_path, started)
    assert 0 <= json.loads((tmp_path / store.MANIFEST).read_text())["wall_clock_seconds"] < 60


BROKEN = ["seed: 1\nrun: {decision: 5}\n", "seed: x\nrun: {}\n", "5", "[", "seed: 1"]


@pytest.mark.parametrize("content", BROKEN)
def test_a_broken_configuration_is_said_in_one_line(tmp_path, content):
    (tmp_path / store.CONFIG).write_text(content)
    checksums.seal(tmp_path, "run")
    with pytest.raises(store.NotARunError, match="does not describe a run") as caught:
        store.read_run(tmp_path)
    assert "\n" not in str(caught.value)


def test_what_is_not_a_run(tmp_path):
    for folder, reason in ((tmp_path, "is not a finished run"), (tmp_path / "no", "does not exist")):
        with pytest.raises(store.NotARunError, match=reason) as caught:
            store.read_run(folder)
        assert "\n" not in str(caught.value)


def write_number(draft: Path) -> None:
    (draft / "number").write_text("1")


def test_a_folder_is_made_once_and_again_if_it_is_damaged(tmp_path):
    folder, said = tmp_path / "run", []
    for _ in range(2):
        store.make(folder, write_number, say=said.append)
        made = folder.stat().st_ino
    assert not said
    store.make(folder, lambda _: pytest.fail("made again"))
    (folder / "number").write_text("2")
    store.make(folder, write_number, say=said.append)
    assert (folder / "number").read_text() == "1"
    assert folder.stat().st_ino != made
    assert said == [f"{folder / 'number'} was changed after it was written; it is made again"]
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


def test_what_another_process_makes_is_not_made_twice(tmp_path):
    folder = tmp_path / "run"
    with claims.claim(folder), pytest.raises(claims.Busy):
        store.make(folder, write_number, wait=False)
    store.make(folder, write_number, wait=False)


def test_who_died_after_the_folder_was_there_leaves_no_claim_for_long(tmp_path):
    folder = tmp_path / "run"
    store.make(folder, write_number)
    (tmp_path / ".claim-run").touch()  # what a killed process leaves
    store.make(folder, write_number)
    assert [path.name for path in tmp_path.iterdir()] == ["run"]
    with claims.claim(folder):  # of a living one: for example because it thinks the folder damaged
        store.make(folder, write_number)
        assert (tmp_path / ".claim-run").is_file()


def test_a_name_from_elsewhere_stays_in_its_folder():
    run = RUN.model_copy(update={"agent": "still"})
    for name in ("../../elsewhere", "a/b", "a\nb"):
        agents = {"still": "agents.reference:Still", name: "agents.reference:Still"}
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr("crawler_bench.config.files.AGENTS", agents)
            folder = store.run_folder(Path("runs"), run.model_copy(update={"agent": name}), 0)
        assert folder.parent == Path("runs")
        assert "\n" not in folder.name
