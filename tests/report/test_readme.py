"""The code in README.md runs as it stands there."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
BLOCKS = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), flags=re.DOTALL)


def run(folder: Path, *words: str) -> str:
    done = subprocess.run(
        [sys.executable, *words], cwd=folder, env=None, capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture
def importable(monkeypatch, tmp_path):
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    return tmp_path


def test_the_environment_works_with_a_learner(importable):
    (example,) = [block for block in BLOCKS if "stable_baselines3" in block]
    assert len([line for line in example.splitlines() if line]) <= 6
    (importable / "example.py").write_text(example.replace("10_000", "2_048"))
    run(importable, "example.py")
