"""A kernel that counts references must not be given a view by one that does not."""

import ast
from pathlib import Path

import pytest

import crawler_bench

PACKAGE = Path(crawler_bench.__file__).parent
SOURCES = [*PACKAGE.rglob("*.py"), *PACKAGE.with_name("agents").rglob("*.py")]


def takers(source: str, giver: str) -> list[str]:
    """Names of compiled functions that call `giver` and count references."""
    return [
        function.name
        for function in ast.walk(ast.parse(source))
        if isinstance(function, ast.FunctionDef)
        and any(isinstance(each, ast.Name) and each.id == "kernel" for each in function.decorator_list)
        and any(isinstance(each, ast.Name) and each.id == giver for each in ast.walk(function))
    ]


@pytest.mark.parametrize("source", SOURCES, ids=lambda path: "/".join(path.parts[-2:]))
def test_only_inner_kernels_take_views(source):
    assert takers(source.read_text(), "parts") == []


def test_a_kernel_that_takes_views_is_found():
    assert takers("@kernel\ndef f(m):\n    return parts(m)[0]\n", "parts") == ["f"]
