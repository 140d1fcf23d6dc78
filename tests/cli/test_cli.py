"""The command line: training, measuring, filming, and the reproduction from end to end."""

import json
import shlex
from pathlib import Path

import pandas as pd
import pytest

from crawler_bench import cli
from crawler_bench.output import animation, style
from crawler_bench.runs import training
from tests.cli.command import crawler_bench, python

SHORT = ("starts=2", "warm_up=5", "duration=40", "settle=10")
SETTINGS = tuple(word for value in SHORT for word in ("--set", value))
SMOKE = ("--preset", "smoke", "--seeds", "2", "--jobs", "1", "--quiet", *SETTINGS)


@pytest.fixture(scope="module")
def trained(tmp_path_factory) -> Path:
    words = ("--seed", 3, "--out", tmp_path_factory.mktemp("runs"), "--set", "decisions=2000", *SETTINGS)
    code, out, err = crawler_bench("train", "qlearning", *words)
    assert code == 0, err
    return Path(out.strip())


def test_list_names_what_there_is():
    out = crawler_bench("list")[1]
    for name in ("agents.qlearning:QLearning", "Crawler-v0", "paper/regularized", "nearest_neighbour"):
        assert name in out


def test_doctor_finds_nothing_wrong_here():
    code, out, _ = crawler_bench("doctor")
    assert code == 0, out
    assert "PROBLEM" not in out
    assert "crawler_bench/Crawler-v0 steps" in out


def test_doctor_finds_another_package_called_agents(tmp_path):
    (tmp_path / "agents.py").write_text("")
    done = python(
        "import sys; sys.argv[1:] = ['doctor']; import crawler_bench.cli.__main__", tmp_path, tmp_path
    )
    assert done.returncode == 1
    (problem,) = [line for line in done.stdout.splitlines() if line.startswith("PROBLEM")]
    assert "openai-agents" in problem


def test_warmup_compiles_what_a_first_run_needs():
    code, out, _ = crawler_bench("warmup")
    assert (code, out.startswith("ready to step")) == (0, True)


def test_train_makes_a_run_and_finds_it_again(trained):
    assert trained.name.startswith("qlearning-eps0.01-seed03-")
    assert json.loads((trained / "agent.json").read_text())["num_timesteps"] == 2000
    before = (trained / "manifest.json").stat().st_mtime_ns
    words = ("--seeds", "3,", "--out", trained.parent, "--set", "decisions=2000", *SETTINGS)
    code, out, _ = crawler_bench("train", "qlearning", *words)
    assert (code, Path(out.strip())) == (0, trained)
    assert (trained / "manifest.json").stat().st_mtime_ns == before


def test_evaluate_prints_and_writes(trained, tmp_path):
    words = ("--set", "evaluation.noise=[0, 0.3]", "--out", tmp_path / "out")
    code, out, err = crawler_bench("evaluate", trained, *words)
    assert code == 0, err
    runs = pd.read_csv(tmp_path / "out" / "runs.csv", dtype={"policy": str})
    assert runs["run"].tolist() == [trained.name]
    assert all(text in out for text in ("s = 0.3", runs["policy"][0]))
    assert len(pd.read_csv(tmp_path / "out" / "evaluations.csv")) == 4


def test_render_films_and_draws(trained, tmp_path):
    code, _, err = crawler_bench("render", trained, "--out", tmp_path / "films")
    assert code == 0, err
    said = [
        f"filming {trained}",
        f"measuring 1/1 ({trained.name})",
        "drawing",
        "filming gait.gif",
        "filming gait.mp4",
    ]
    assert [line.startswith(words) for line, words in zip(err.splitlines(), said, strict=True)] == [True] * 5
    found = {path.name for path in (tmp_path / "films").iterdir() if path.stat().st_size > 1000}
    assert found == {"gait.gif", "gait.mp4", "gait.png", "gait.svg"}


@pytest.fixture(scope="module")
def reproduced(tmp_path_factory) -> Path:
    """Everything that `reproduce` writes, in out/, with its runs in runs/."""
    root = tmp_path_factory.mktemp("reproduced")
    code, _, err = crawler_bench("reproduce", *SMOKE, "--out", root / "out", "--runs", root / "runs")
    assert code == 0, err
    return root


def test_reproduce_writes_what_it_promises(reproduced):
    wanted = {f"{table}.csv" for table in ("claims", "runs", "evaluations", "cycles")}
    wanted |= {"claims.md", "manifest.json", "command.txt"}
    names = ("1a", "2a", "2b", "2c", "3a", "3b", "3c", "s1", "learning")
    wanted |= {f"fig_{name}.{suffix}" for name in names for suffix in ("png", "svg")}
    gaits = ("regularized", "unregularized")
    wanted |= {f"{gait}.{suffix}" for gait in gaits for suffix in ("gif", "mp4")}
    wanted |= {f"policies/{gait}-seed{seed:02d}.json" for gait in gaits for seed in (0, 1)}
    out = reproduced / "out"
    assert wanted == {str(path.relative_to(out)) for path in out.rglob("*.*") if path.stat().st_size}


def ages(root: Path) -> dict[Path, int]:
    return {path: path.stat().st_mtime_ns for path in (root / "runs").rglob("manifest.json")}


def test_reproduce_again_trains_nothing_and_gives_the_same_bytes(reproduced, monkeypatch):
    """Without the pictures, which take most of the time and are the same by their own tests."""
    monkeypatch.setattr(training, "make_agent", None)
    monkeypatch.setattr(style, "save", lambda *arguments: None)
    monkeypatch.setattr(animation, "animate", lambda *arguments: None)
    words = ("--out", reproduced / "again", "--runs", reproduced / "runs")
    assert crawler_bench("reproduce", *SMOKE, *words)[0] == 0
    for path in (reproduced / "out").glob("*.csv"):
        assert path.read_bytes() == (reproduced / "again" / path.name).read_bytes()


def test_the_command_of_a_claim_remakes_it(reproduced, monkeypatch):
    monkeypatch.chdir(reproduced)
    before = ages(reproduced)
    claims = pd.read_csv(reproduced / "out" / "claims.csv")
    speed = claims[claims["claim"].str.startswith("speed of the regularized")].iloc[0]
    program, *words = shlex.split(speed["command"])
    code, out, err = crawler_bench(*words, "--runs", "runs", "--jobs", 1, "--quiet")
    assert (program, code) == ("crawler-bench", 0), err
    assert f"{speed['ours']:.3g}" in out
    assert speed["verdict"] in out
    assert ages(reproduced) == before
    assert not (reproduced / "results").exists()


def test_the_command_of_a_claim_is_quoted_for_a_shell(reproduced, monkeypatch):
    seen = []
    monkeypatch.setattr(cli.paper, "print_claims", seen.append)
    words = ("--claim", "speed", "--runs", reproduced / "runs", "--set", "evaluation.noise=[0, 0.2]")
    assert crawler_bench("reproduce", *SMOKE, *words)[0] == 0
    assert words[-1] in shlex.split(seen[0]["command"].iloc[0])
