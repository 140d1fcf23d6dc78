"""The command line: help, training, errors in one line, and the reproduction from end to end."""

import json
import os
import shlex
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path

import pandas as pd
import pytest

from crawler_bench import cli
from crawler_bench.output import animation, style
from crawler_bench.runs import training

ROOT = Path(cli.__file__).parents[2]
COMMANDS = (
    "reproduce readings train evaluate render tune benchmark report reproduce-cell list doctor warmup".split()
)
SHORT = ("starts=2", "warm_up=5", "duration=40", "settle=10")
SETTINGS = tuple(word for value in SHORT for word in ("--set", value))
SMOKE = ("--preset", "smoke", "--seeds", "2", "--jobs", "1", "--quiet", *SETTINGS)


def crawler_bench(*words) -> tuple[int, str, str]:
    """Run a command in this process; its exit code, standard output and standard error."""
    out, err = StringIO(), StringIO()
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(out), redirect_stderr(err):
        patch.setattr(sys, "argv", ["crawler-bench", *map(str, words)])
        patch.delenv("CRAWLER_BENCH_DEBUG", raising=False)
        with pytest.raises(SystemExit) as ended:
            cli.main()
    return int(ended.value.code or 0), out.getvalue(), err.getvalue()


def python(code: str, cwd: Path, *path: Path) -> subprocess.CompletedProcess[str]:
    """Run code in another process, with these folders before the project's on the path."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(map(str, (*path, ROOT)))}
    return subprocess.run(
        [sys.executable, "-c", code], cwd=cwd, env=environment, capture_output=True, text=True, check=False
    )


def complaint(*words) -> str:
    """What a command that must fail says, in one line."""
    code, out, err = crawler_bench(*words)
    assert code != 0
    assert out == ""
    assert len(err.splitlines()) == 1, err
    assert err.startswith("crawler-bench: ")
    return err


@pytest.fixture(scope="module")
def trained(tmp_path_factory) -> Path:
    words = ("--seed", 3, "--out", tmp_path_factory.mktemp("runs"), "--set", "decisions=2000", *SETTINGS)
    code, out, err = crawler_bench("train", "qlearning", *words)
    assert code == 0, err
    return Path(out.strip())


HELP = """
import sys
from crawler_bench.cli import main
for words in ([], *([command] for command in {commands})):
    sys.argv = ["crawler-bench", *words, "--help"]
    try:
        main()
    except SystemExit as ended:
        assert not ended.code
heavy = [name for name in ("numba", "torch", "matplotlib", "scipy.stats") if name in sys.modules]
assert not heavy, heavy
"""


def test_help_on_every_level_imports_nothing_heavy(tmp_path):
    done = python(HELP.format(commands=COMMANDS), tmp_path)
    assert done.returncode == 0, done.stderr
    top, *levels = done.stdout.split("Usage: ")[1:]
    for command, level in zip(COMMANDS, levels, strict=True):
        assert f" {command} " in top
        assert level.startswith(f"crawler-bench {command} ")


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


def test_train_from_a_file_over_several_seeds(tmp_path):
    (tmp_path / "mine.yaml").write_text("decisions: 500\nenvironment: {regularization: 0.5}\n")
    words = ("--config", tmp_path / "mine.yaml", "--seeds", "4-5", "--set", "decisions=0")
    code, out, _ = crawler_bench("train", "random", *words, "--out", tmp_path / "runs")
    assert code == 0
    names = [Path(line).name.rpartition("-")[0] for line in out.splitlines()]
    assert names == ["random-eps0.5-seed04", "random-eps0.5-seed05"]


def test_evaluate_prints_and_writes(trained, tmp_path):
    words = ("--set", "evaluation.noise=[0, 0.3]", "--out", tmp_path / "out")
    code, out, err = crawler_bench("evaluate", trained, *words)
    assert code == 0, err
    runs = pd.read_csv(tmp_path / "out" / "runs.csv", dtype={"policy": str})
    assert runs["run"].tolist() == [trained.name]
    assert all(text in out for text in ("s = 0.3", runs["policy"][0]))
    assert len(pd.read_csv(tmp_path / "out" / "evaluations.csv")) == 4


def test_render_films_and_draws(trained, tmp_path):
    code, _, err = crawler_bench("render", trained, "--out", tmp_path / "films", "--quiet")
    assert (code, err) == (0, "")
    found = {path.name for path in (tmp_path / "films").iterdir() if path.stat().st_size > 1000}
    assert found == {"gait.gif", "gait.mp4", "gait.png", "gait.svg"}


BAD_COMMANDS = """
train nope | no agent is called 'nope'; there are qlearning
train nowhere:Agent | 'nowhere:Agent' cannot be imported
train json:dumps | an agent is a class
train qlearning --set crawlers=4 | qlearning learns from one crawler
train qlearning --set decisions=1e30 | decisions
train qlearning --set regularisation=1 | did you mean 'regularization'?
train qlearning --set regularization=.nan | finite number
train qlearning --set n_segments=1 | a whole number of at least 2
train qlearning --config nowhere.yaml | nowhere.yaml
train qlearning --seeds 9-3 | seeds are a number of them
train qlearning --seed 1 --seeds 3 | exclude each other
train qlearning --set settings.temperature=1 | knows no 'temperature'
train qlearning --set settings.discount=3 | discount = 3
train qlearning --set settings.discount=x | discount
train qlearning --set settings.compiled=x | compiled
evaluate nowhere | nowhere does not exist
evaluate other | other is not a finished run
evaluate nowhere.json | nowhere.json does not exist
render other | other is not a finished run
reproduce --preset smoke --out other | other is not empty
reproduce --claim nope | no claim is called 'nope'; there are wave
reproduce --preset smoke --set nope=1 | unknown key 'nope'
readings --only head_muscle=ext | did you mean 'head_muscle=external'
readings --check 2 --out other | `crawler-bench readings` makes one
readings --out other | other is not empty
benchmark --out other/thesis.tex | is a file
"""


@pytest.mark.parametrize("line", BAD_COMMANDS.strip().splitlines())
def test_a_bad_command_is_answered_in_one_line(line, tmp_path, monkeypatch):
    words, _, said = line.partition(" | ")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "thesis.tex").write_text("precious")
    assert said in complaint(*words.split())
    assert {path.name for path in tmp_path.rglob("*.*")} == {"thesis.tex"}


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
