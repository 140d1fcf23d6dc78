"""Tables, and the generated blocks of the documentation, which must be what their generators give."""

import re
from pathlib import Path

import pytest

from crawler_bench.output.csv_files import write_csv
from crawler_bench.report import blocks
from tests.paper.frames import CLAIMS, RUNS

ROOT = Path(blocks.__file__).parents[2]
RESULTS = ROOT / "results" / "paper"
DOCUMENTS = [
    path
    for path in (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))
    if path.is_file() and "<!-- begin " in path.read_text()
]


@pytest.fixture
def results(tmp_path):
    write_csv(CLAIMS, tmp_path / "claims.csv")
    write_csv(RUNS, tmp_path / "runs.csv")
    return tmp_path


def test_a_policy_keeps_its_leading_zero_on_the_way_through_a_file(results):
    assert "| 0123456789 |" in blocks.blocks(results)["runs"]()


TEMPLATE = "# Title\n\n<!-- begin {0} -->\nold\n<!-- end {0} -->\n\nprose\n"


@pytest.mark.parametrize("name", ["claims", "verdicts", "not reproduced", "runs", "parameters"])
def test_a_block_is_filled_and_stays_as_it_is(results, name):
    filled = blocks.regenerate(TEMPLATE.format(name), results)
    content = blocks.blocks(results)[name]()
    assert filled == TEMPLATE.format(name).replace("old", content)
    assert blocks.regenerate(filled, results) == filled


def test_every_block_of_a_document_is_filled(results):
    document = TEMPLATE.format("claims") + TEMPLATE.format("verdicts") + TEMPLATE.format("claims")
    filled = blocks.regenerate(document, results)
    assert "old" not in filled
    assert filled.count("it crawls") == 2
    assert filled.count("prose") == 3


def test_a_document_without_blocks_needs_no_results(tmp_path):
    assert blocks.regenerate("# Title\n", tmp_path) == "# Title\n"


def test_an_unknown_block_is_an_error(results):
    with pytest.raises(ValueError, match="no generator is called 'claim'; there are claims, verdicts"):
        blocks.regenerate(TEMPLATE.format("claim"), results)


@pytest.mark.parametrize("broken", ["<!-- begin claims -->\n", "<!-- begin claims -->\n<!-- end runs -->\n"])
def test_a_block_without_its_end_is_an_error(results, broken):
    with pytest.raises(ValueError, match="claims"):
        blocks.regenerate(broken, results)


def test_a_changed_digit_in_a_block_is_undone(results):
    filled = blocks.regenerate(TEMPLATE.format("claims"), results)
    edited = filled.replace("0.00493", "0.00593")
    assert edited != filled
    assert blocks.regenerate(edited, results) == filled


def begins(text: str) -> int:
    return len(re.findall("<!-- begin ", text))


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: path.name)
def test_the_documentation_says_what_the_results_say(path):
    """If this fails: python -m crawler_bench.report.blocks README.md docs/*.md."""
    text = path.read_text()
    assert begins(text) == len(
        re.findall(r"<!-- begin (?P<name>[\w ]+) -->.*?<!-- end (?P=name) -->", text, re.S)
    )
    assert blocks.regenerate(text, RESULTS) == text


@pytest.mark.skipif(not DOCUMENTS, reason="no document has generated blocks")
def test_a_changed_digit_in_the_documentation_is_noticed():
    for path in DOCUMENTS:
        text = path.read_text()
        for block in re.finditer(r"<!-- begin (?P<name>[\w ]+) -->.*?<!-- end (?P=name) -->", text, re.S):
            digit = re.search(r"\d", block[0])
            if digit:
                place = block.start() + digit.start()
                edited = text[:place] + str((int(text[place]) + 1) % 10) + text[place + 1 :]
                assert blocks.regenerate(edited, RESULTS) != edited
