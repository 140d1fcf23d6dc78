"""The wheel in an empty environment, away from the repository: what a user has after `pip install`."""

import os
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).parents[2]
SHORT = [
    "--set=evaluation.starts=2", "--set=evaluation.noise=[0]", "--set=evaluation.duration=200",
    "--set=evaluation.gait=60",
]  # fmt: skip
pytestmark = pytest.mark.slow

GOOD = """
import gymnasium as gym
from agents.qlearning import QLearning
from crawler_bench.envs.crawler import CrawlerEnv
from crawler_bench.envs.vector import CrawlerVectorEnv
from crawler_bench.physics import CrawlerParameters

env = CrawlerEnv(CrawlerParameters(damping=2.0), noise=0.1)
table: list[list[float]] = QLearning(env, seed=0).learn(100).q_table.tolist()
stuck: gym.vector.VectorEnv = CrawlerVectorEnv(4, time_limit=[1.0, 2.0, 3.0, 4.0])
"""
BAD = GOOD + "wrong: str = QLearning(env).num_timesteps\nCrawlerEnv(noise='much')\n"


def run(*command: str | Path, folder: Path, status: int = 0) -> str:
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run(
        [*map(str, command)], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == status, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    pip = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", folder]
    run(*pip, REPOSITORY, folder=folder)
    return next(folder.glob("crawler_bench-*.whl"))


@pytest.fixture(scope="module")
def commands(wheel: Path) -> Path:
    """Where the commands of an environment are that has the wheel and mypy, and nothing of the repository."""
    venv = wheel.parent / "venv"
    run(sys.executable, "-m", "venv", venv, folder=wheel.parent)
    pip = [venv / "bin" / "python", "-m", "pip", "install", "--quiet", "-c", REPOSITORY / "constraints.txt"]
    run(*pip, wheel, "mypy", folder=wheel.parent)
    return venv / "bin"


def test_a_run_is_trained_measured_and_filmed(commands: Path, tmp_path: Path) -> None:
    crawler_bench = commands / "crawler-bench"
    assert "qlearning" in run(crawler_bench, "list", folder=tmp_path)
    trained = run(
        crawler_bench, "train", "qlearning", "--set=decisions=5000", *SHORT, "--out", "runs", folder=tmp_path
    )
    trained = trained.split()[-1]
    assert "speed" in run(crawler_bench, "evaluate", trained, *SHORT, folder=tmp_path)
    run(crawler_bench, "render", trained, *SHORT, "--out", "film", folder=tmp_path)
    assert {path.suffix for path in (tmp_path / "film").iterdir()} >= {".gif", ".mp4", ".png", ".svg"}


def test_a_policy_that_ships_is_filmed_by_its_name(commands: Path, tmp_path: Path) -> None:
    """What a new user types first."""
    run(commands / "crawler-bench", "render", "regularized", *SHORT, folder=tmp_path)
    film = tmp_path / "results" / "rendered" / "regularized" / "gait.mp4"
    assert film.stat().st_size > 10_000


def test_a_users_file_is_checked_against_our_types(commands: Path, tmp_path: Path) -> None:
    mypy = [commands / "python", "-m", "mypy", "--strict"]
    (tmp_path / "good.py").write_text(GOOD)
    (tmp_path / "bad.py").write_text(BAD)
    run(*mypy, "good.py", folder=tmp_path)
    complaints = run(*mypy, "bad.py", folder=tmp_path, status=1)
    assert re.findall(r"bad.py:(\d+): error: .*\[(.*)\]", complaints) == [
        ("11", "assignment"), ("12", "arg-type"),
    ]  # fmt: skip


def test_a_package_index_can_show_the_readme(wheel: Path) -> None:
    """No link in it is relative: there is no repository around it there."""
    with zipfile.ZipFile(wheel) as archive:
        name = next(name for name in archive.namelist() if name.endswith(".dist-info/METADATA"))
        metadata = archive.read(name).decode()
    links = re.findall(r"\]\(([^)]+)\)", metadata)
    assert len(links) > 20
    assert [link for link in links if not link.startswith(("https://", "http://", "#"))] == []
    assert "Project-URL: Changelog, " in metadata
