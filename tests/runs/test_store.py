"""Run folders: keys that change with what decides a run, publishing, compiled code that is never stale."""

import os
import shutil
import subprocess
import sys
import time
from dataclasses import fields, replace
from pathlib import Path

import pytest

from crawler_bench.config.schema import EnvironmentConfig, EvaluationConfig, RunConfig
from crawler_bench.physics.parameters import CHOICES, CrawlerParameters
from crawler_bench.runs import store

ROOT = Path(store.__file__).parents[2]
RUN = RunConfig(agent="random")


def other_parameters(name: str) -> CrawlerParameters:
    """The default crawler with another value of one constant."""
    value = getattr(CrawlerParameters(), name)
    other = CHOICES[name][-1] if name in CHOICES else value + 1 if name == "n_segments" else 2 * value
    other = value / 2 if name == "dt" else other
    return replace(CrawlerParameters(), **{name: other})


CHANGES = [
    *({"parameters": other_parameters(each.name)} for each in fields(RUN.parameters)),
    *({"environment": EnvironmentConfig(**{name: 7.5})} for name in EnvironmentConfig.model_fields),
    {"agent": "still"}, {"settings": {"learning_rate": 0.1}}, {"settings": {"learning_rate": 0.2}},
    {"decisions": 5}, {"crawlers": 2},
]  # fmt: skip
OTHERS = [RUN.model_copy(update=change) for change in CHANGES]


def test_every_field_that_decides_a_run_changes_its_key():
    keys = [store.training_key(RUN, 0), store.training_key(RUN, 1)]
    keys += [store.training_key(other, 0) for other in OTHERS]
    assert len(set(keys)) == len(keys)
    assert keys[0] == store.training_key(RunConfig(agent=RUN.agent), 0)
    assert {len(key) for key in keys} == {10}
    evaluated = RUN.model_copy(update={"evaluation": EvaluationConfig(starts=3, seed=1)})
    assert store.training_key(evaluated, 0) == keys[0]  # how a run is evaluated does not change it


def test_every_field_of_an_evaluation_changes_its_key():
    changes = {
        "starts": 3, "warm_up": 7, "duration": 300, "settle": 7, "gait": 8, "noise": (0, 1),
        "mode": "stochastic", "seed": 1,
    }  # fmt: skip
    assert set(changes) == set(EvaluationConfig.model_fields)
    keys = [store.evaluation_key(EvaluationConfig(**{name: value})) for name, value in changes.items()]
    assert len({*keys, store.evaluation_key(EvaluationConfig())}) == len(keys) + 1


def test_the_sources_of_an_agent_change_its_key(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(tmp_path))
    (tmp_path / "mine_alone.py").write_text("class Agent: pass\n")
    package = tmp_path / "mine_packed"
    package.mkdir()
    for name in ("__init__", "agent", "helper"):
        (package / f"{name}.py").write_text("")
    sources = {"mine_alone:A": "mine_alone.py", "mine_packed.agent:A": "mine_packed/helper.py"}
    for agent, source in sources.items():
        run = RUN.model_copy(update={"agent": agent})
        before = store.training_key(run, 0)
        (tmp_path / source).write_text("# edited\n")
        assert store.training_key(run, 0) != before


def test_the_sources_that_run_and_measure_change_the_keys(monkeypatch):
    measuring = {place.name for place in store.EVALUATION_SOURCES if place.exists()}
    assert measuring == {"gait", "evaluation.py", "policy_table.py"}
    for name, key in (
        ("EVALUATION_HASH", lambda: store.evaluation_key(EvaluationConfig())),
        ("TRAINING_HASH", lambda: store.training_key(RUN, 0)),
        ("KERNEL_HASH", lambda: store.training_key(RUN, 0)),
    ):
        before = key()
        monkeypatch.setattr(store, name, "edited")
        assert key() != before


def test_folder_names_are_readable():
    folder = store.run_folder(Path("runs"), RUN, 3)
    assert folder == Path("runs") / f"random-eps0.01-seed03-{store.training_key(RUN, 3)}"


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


def test_a_folder_that_cannot_be_replaced_stays_as_it_was(tmp_path):
    folder = tmp_path / "results"
    folder.mkdir()
    (folder / "file").write_text("old")
    with pytest.raises(FileNotFoundError), store.replace(folder) as draft:
        shutil.rmtree(draft)
    assert (folder / "file").read_text() == "old"
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


def test_drafts_of_killed_processes_are_swept(tmp_path):
    old, new, finished = (tmp_path / "run" / name for name in (".partial-old", ".partial-new", "evaluation"))
    for folder in (old, new, finished):
        folder.mkdir(parents=True)
        (folder / "file").write_text("")
    long_ago = time.time() - 5000
    os.utime(old, (long_ago, long_ago))
    os.utime(finished, (long_ago, long_ago))
    store.sweep_drafts(tmp_path)
    assert not old.exists()
    assert new.exists()
    assert finished.exists()
    store.sweep_drafts(tmp_path / "nowhere")


def test_a_draft_that_is_published_meanwhile_is_not_missed(tmp_path, monkeypatch):
    monkeypatch.setattr(Path, "glob", lambda self, pattern: iter([self / ".partial-gone"]))
    store.sweep_drafts(tmp_path)


def test_a_run_is_read_as_written(tmp_path):
    run = OTHERS[0].model_copy(update={"settings": {"learning_rate": 1e-7}})
    assert not store.is_run(tmp_path)
    store.write_config(tmp_path, run, 5)
    assert not store.is_run(tmp_path)
    store.write_manifest(tmp_path, time.time())
    assert store.is_run(tmp_path)
    assert store.read_run(tmp_path) == (run, 5)


BROKEN = ["seed: 1\nrun: {decision: 5}\n", "seed: x\nrun: {}\n", "5", "[", "seed: 1"]


@pytest.mark.parametrize("content", BROKEN)
def test_a_broken_configuration_is_said_in_one_line(tmp_path, content):
    store.write_manifest(tmp_path, time.time())
    (tmp_path / store.CONFIG).write_text(content)
    with pytest.raises(store.NotARunError, match="does not describe a run") as caught:
        store.read_run(tmp_path)
    assert "\n" not in str(caught.value)


def test_what_is_not_a_run(tmp_path):
    for folder, reason in ((tmp_path, "is not a finished run"), (tmp_path / "no", "does not exist")):
        with pytest.raises(store.NotARunError, match=reason) as caught:
            store.read_run(folder)
        assert "\n" not in str(caught.value)


CRAWL = """
import crawler_bench.physics
from crawler_bench.config.schema import RunConfig
from crawler_bench.physics.coefficients import as_record, coefficients, stepping
from crawler_bench.physics.state import make_memory, nodes_of
from crawler_bench.physics.stepped import advance
from crawler_bench.runs.store import training_key
parameters = crawler_bench.physics.CrawlerParameters(n_segments=4)
nodes = nodes_of(make_memory(4))
advance(nodes, 2, 2000, as_record(coefficients(parameters)), as_record(stepping(parameters)))
print(crawler_bench.__file__, training_key(RunConfig(), 0), repr(nodes["displacement"].sum()))
"""


def test_an_edit_in_a_file_that_is_called_changes_the_result_and_the_key(tmp_path):
    """The step that is called is cached by its own, unchanged, file; the friction is in another."""
    for package in ("crawler_bench", "agents"):
        shutil.copytree(ROOT / package, tmp_path / package, ignore=shutil.ignore_patterns("__pycache__"))
    environment = os.environ | {"PYTHONPATH": str(tmp_path), "CRAWLER_BENCH_CACHE": str(tmp_path / "cache")}

    def crawl() -> list[str]:
        words = [sys.executable, "-c", CRAWL]
        return subprocess.check_output(words, cwd=tmp_path, env=environment, text=True).split()

    before = crawl()
    assert Path(before[0]).is_relative_to(tmp_path)
    assert len(list((tmp_path / "cache").iterdir())) == 1
    body = tmp_path / "crawler_bench" / "physics" / "body.py"
    text = body.read_text()
    friction = "return k.forward if slip == FORWARD else -k.backward"
    assert text.count(friction) == 1
    body.write_text(text.replace(friction, "return 0.5 * k.forward if slip == FORWARD else -k.backward"))
    after = crawl()
    assert after[0] == before[0]
    assert after[1] != before[1]
    assert after[2] != before[2]
