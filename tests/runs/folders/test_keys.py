"""What names a run: keys that change with all that decides it, compiled code that is never stale."""

import os
import shutil
import subprocess
import sys
from dataclasses import fields, replace
from pathlib import Path

import pytest

from crawler_bench.config.schema import EnvironmentConfig, EvaluationConfig, RunConfig
from crawler_bench.physics.parameters import CHOICES, CrawlerParameters
from crawler_bench.runs.folders import keys

ROOT = Path(keys.__file__).parents[3]
RUN = RunConfig(agent="random")


def other_parameters(name: str) -> CrawlerParameters:
    """The default crawler with another value of one constant."""
    value = getattr(CrawlerParameters(), name)
    if name in CHOICES:
        other = next(each for each in CHOICES[name] if each != value)
    else:
        other = value + 1 if name == "n_segments" else value / 2 if name == "dt" else 2 * value
    return replace(CrawlerParameters(), **{name: other})


CHANGES = [
    *({"parameters": other_parameters(each.name)} for each in fields(RUN.parameters)),
    *({"environment": EnvironmentConfig(**{name: "state" if name == "keyhole" else 7.5})}
      for name in EnvironmentConfig.model_fields),
    {"agent": "still"}, {"settings": {"learning_rate": 0.1}}, {"settings": {"learning_rate": 0.2}},
    {"decisions": 5}, {"crawlers": 2},
]  # fmt: skip
OTHERS = [RUN.model_copy(update=change) for change in CHANGES]


def test_every_field_that_decides_a_run_changes_its_key():
    found = [keys.training_key(RUN, 0), keys.training_key(RUN, 1)]
    found += [keys.training_key(other, 0) for other in OTHERS]
    assert len(set(found)) == len(found)
    assert found[0] == keys.training_key(RunConfig(agent=RUN.agent), 0)
    assert {len(key) for key in found} == {10}
    evaluated = RUN.model_copy(update={"evaluation": EvaluationConfig(starts=3, seed=1)})
    assert keys.training_key(evaluated, 0) == found[0]  # how a run is evaluated does not change it


def test_every_field_of_an_evaluation_changes_its_key():
    changes = {
        "starts": 3, "warm_up": 7, "duration": 300, "settle": 7, "gait": 8, "noise": (0, 1),
        "mode": "stochastic", "seed": 1,
    }  # fmt: skip
    assert set(changes) == set(EvaluationConfig.model_fields)
    found = [keys.evaluation_key(EvaluationConfig(**{name: value})) for name, value in changes.items()]
    assert len({*found, keys.evaluation_key(EvaluationConfig())}) == len(found) + 1


@pytest.fixture
def mine(tmp_path, monkeypatch):
    """A folder that agents are imported from."""
    monkeypatch.syspath_prepend(str(tmp_path))
    package = tmp_path / "mine_packed"
    (package / "deep").mkdir(parents=True)
    for name in ("__init__", "agent", "helper", "deep/__init__", "deep/agent"):
        (package / f"{name}.py").write_text("")
    (package / "agent.py").write_text("from mine_beside import Table\n")
    (tmp_path / "mine_alone.py").write_text("import numpy, mine_helper\nclass Agent: pass\n")
    (tmp_path / "mine_helper.py").write_text("def choose():\n    import mine_beside.tables as tables\n")
    (tmp_path / "mine_beside").mkdir()
    for name in ("mine_beside/__init__", "mine_beside/tables", "mine_stranger"):
        (tmp_path / f"{name}.py").write_text("")
    return tmp_path


@pytest.mark.parametrize(
    ("agent", "source", "changes"),
    [
        ("mine_alone:A", "mine_alone.py", True),
        ("mine_alone:A", "mine_helper.py", True),
        ("mine_alone:A", "mine_beside/tables.py", True),
        ("mine_alone:A", "mine_stranger.py", False),
        ("mine_packed.agent:A", "mine_packed/helper.py", True),
        ("mine_packed.agent:A", "mine_beside/__init__.py", True),
        ("mine_packed.deep.agent:A", "mine_packed/helper.py", True),
        ("mine_packed.agent:A", "mine_alone.py", False),
    ],
)
def test_the_sources_of_an_agent_and_its_helpers_change_its_key(mine, agent, source, changes):
    run = RUN.model_copy(update={"agent": agent})
    before = keys.training_key(run, 0)
    with (mine / source).open("a") as file:
        file.write("# edited\n")
    assert (keys.training_key(run, 0) != before) == changes
    assert "mine_packed" not in sys.modules  # nothing is imported to find out


@pytest.mark.parametrize("package", ["numpy", "numba", "gymnasium", "stable-baselines3", "torch"])
def test_the_versions_of_what_computes_change_the_keys(monkeypatch, package):
    before = keys.training_key(RUN, 0), keys.evaluation_key(EvaluationConfig())
    monkeypatch.setitem(keys.VERSIONS, package, "0.0.1")
    after = keys.training_key(RUN, 0), keys.evaluation_key(EvaluationConfig())
    assert not set(before) & set(after)


def test_the_sources_that_run_and_measure_change_the_keys(monkeypatch):
    measuring = {place.name for place in keys.EVALUATION_SOURCES if place.exists()}
    assert measuring == {"gait", "policies", "evaluation.py"}
    for name, key in (
        ("EVALUATION_HASH", lambda: keys.evaluation_key(EvaluationConfig())),
        ("TRAINING_HASH", lambda: keys.training_key(RUN, 0)),
        ("KERNEL_HASH", lambda: keys.training_key(RUN, 0)),
    ):
        before = key()
        monkeypatch.setattr(keys, name, "edited")
        assert key() != before


CRAWL = """
import crawler_bench.physics
from crawler_bench.config.schema import RunConfig
from crawler_bench.physics.coefficients import as_record, coefficients, stepping
from crawler_bench.physics.state import make_memory, nodes_of
from crawler_bench.physics.stepped import advance
from crawler_bench.runs.folders.keys import training_key
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
