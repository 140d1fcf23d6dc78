"""What users of the packages get beside the code."""

from importlib import resources

import pytest


@pytest.mark.parametrize("package", ["crawler_bench", "agents"])
def test_type_checkers_are_told_to_look(package: str) -> None:
    assert (resources.files(package) / "py.typed").is_file()
