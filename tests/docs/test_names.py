"""Files and names that the documents mention exist."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
DOCUMENTS = [ROOT / name for name in ("README.md", "CONTRIBUTING.md", "docs/architecture.md")]
PLACES = (
    r"`((?!crawler_bench/Crawler)(?:crawler_bench|agents|speed|tests|configs|docs)/[\w./-]*)(?::([\w.]+))?`"
)
MENTIONED = [
    pytest.param(place, name, id=f"{document.stem}-{place}{':' + name if name else ''}")
    for document in DOCUMENTS
    for place, name in sorted(set(re.findall(PLACES, document.read_text())))
]
TARGETS = re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), flags=re.MULTILINE)


def definitions(tree: ast.AST) -> set[str]:
    """Names that a module or a class defines, of a class also its own as `Class.name`."""
    found = set()
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            found.add(node.name)
        if isinstance(node, ast.ClassDef):
            found |= {f"{node.name}.{name}" for name in definitions(node)}
        if isinstance(node, ast.Assign):
            found |= {target.id for target in node.targets if isinstance(target, ast.Name)}
    return found


@pytest.mark.parametrize(("place", "name"), MENTIONED)
def test_what_is_mentioned_is_there(place: str, name: str) -> None:
    path = ROOT / place
    assert path.exists()
    if name:
        assert name in definitions(ast.parse(path.read_text()))


def test_enough_is_mentioned() -> None:
    """The pattern above still finds what it is meant for."""
    assert sum(bool(param.values[1]) for param in MENTIONED) > 40


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_links_lead_somewhere(document: Path) -> None:
    for link in re.findall(r"\]\((?!https?:)([^)#]+)[^)]*\)", document.read_text()):
        assert (document.parent / link).exists(), link


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_make_has_the_targets_that_are_named(document: Path) -> None:
    named = re.findall(r"(?:^ {4}|`)make ([a-z-]+)", document.read_text(), flags=re.MULTILINE)
    assert set(named) <= set(TARGETS)
