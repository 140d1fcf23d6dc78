"""What users of the packages get beside the code."""

import tomllib
from importlib import resources
from pathlib import Path

import pytest
from packaging.version import Version


@pytest.mark.parametrize("package", ["crawler_bench", "agents"])
def test_type_checkers_are_told_to_look(package: str) -> None:
    assert (resources.files(package) / "py.typed").is_file()


def test_every_oldest_release_that_is_allowed_is_one_that_is_tested() -> None:
    """`make test-minimum` installs constraints-minimum.txt; what pyproject.toml allows must be no older."""
    root = Path(__file__).parents[2]
    allowed = tomllib.loads((root / "pyproject.toml").read_text())["project"]["dependencies"]
    lines = (root / "constraints-minimum.txt").read_text().splitlines()
    tested = dict(line.split("==") for line in lines if not line.startswith("#"))
    assert {name: Version(version) for name, version in tested.items()} == {
        name: Version(version) for name, version in (each.split(">=") for each in allowed)
    }
