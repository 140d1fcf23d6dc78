"""docs/physics.md names functions and tolerances; both have to be those of the code."""

import ast
import re
from pathlib import Path

import pytest

from crawler_bench.physics import as_printed, tolerances

PAGE = (Path(__file__).parents[2] / "docs" / "physics.md").read_text(encoding="utf-8")
SOURCES = {path.stem: path for path in Path(as_printed.__file__).parent.rglob("*.py")}
QUALIFIED = sorted(set(re.findall(r"`(?:exact/)?([a-z_]{2,})\.([a-z_]{3,})`", PAGE)))


def functions_in(module: str) -> set[str]:
    tree = ast.parse(SOURCES[module].read_text(encoding="utf-8"))
    return {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}


def column_three(heading: str) -> list[str]:
    """The functions in the third column of the table below a heading."""
    section = PAGE.split(f"## {heading}\n")[1].split("\n## ")[0]
    cells = [row.split("|")[3] for row in section.splitlines() if re.match(r"\| \d", row)]
    return [name for cell in cells for name in re.findall(r"`(\w+)`", cell)]


@pytest.mark.parametrize(("module", "name"), QUALIFIED)
def test_functions_named_with_their_module_exist(module: str, name: str) -> None:
    assert name in functions_in(module)


def test_the_printed_equations_are_named() -> None:
    named = column_three("Where each equation is")
    assert len(named) == 9
    assert set(named) <= functions_in("as_printed")


def test_the_steps_of_a_decision_are_named() -> None:
    named = column_three("One decision of the exact integrator")
    assert len(named) > 8
    exact = ("spikes", "slip_events", "trajectory")
    assert set(named) <= {name for module in exact for name in functions_in(module)}


def test_the_tolerances_are_those_of_the_code() -> None:
    rows = dict(re.findall(r"^\| `([A-Z_]+)` \| ([^|]*) \|", PAGE, re.M))
    values = {name: value for name, value in vars(tolerances).items() if name.isupper()}
    assert {name: sum(map(float, value.split("+"))) for name, value in rows.items()} == values
