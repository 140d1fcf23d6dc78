"""Tables, and the generated blocks of the documentation, which must be what their generators give."""

import re
from pathlib import Path

import pandas as pd
import pytest

from crawler_bench.config.schema import EnvironmentConfig, EvaluationConfig
from crawler_bench.output.csv_files import write_csv
from crawler_bench.physics.parameters import CrawlerParameters
from crawler_bench.report import blocks

ROOT = Path(blocks.__file__).parents[2]
RESULTS = ROOT / "results" / "paper"
DOCUMENTS = [
    path
    for path in (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))
    if path.is_file() and "<!-- begin " in path.read_text()
]
CLAIMS = pd.DataFrame({
    "claim": ["it crawls", "it is fast", "it is slow", "it sings", "it is quiet"],
    "source": ["Fig. 1", "Fig. 2", "Fig. 3", "Fig. 4", "Fig. 5"],
    "paper": ["yes", 0.0056, "> 0", 33, "not given"],
    "ours": [1.0, 0.0049321, -0.5, float("nan"), 123.4],
    "low": [0.7, 0.0045, -0.5, float("nan"), 120.2],
    "high": [1.0, 0.0052, -0.5, float("nan"), 130.7],
    "n": [10, 10, 1, 0, 10],
    "verdict": ["reproduced", "partly", "not reproduced", "no data", "no number given"],
})  # fmt: skip
RUNS = pd.DataFrame({
    "experiment": ["regularized", "unregularized", "untrained"],
    "seed": [0, 1, 2],
    "policy": ["0123456789", "7207345679", "**********"],
    "speed": [0.0054321, 0.0061234, 0.001],
    "speed_moving": [0.0054321, float("nan"), 0.001],
    "stall_share": [0.0, 0.25, 0.0],
    "cycle_duration": [38.25, 26.0, float("nan")],
    "run": ["a", "b", "c"],
})  # fmt: skip


@pytest.fixture
def results(tmp_path):
    write_csv(CLAIMS, tmp_path / "claims.csv")
    write_csv(RUNS, tmp_path / "runs.csv")
    return tmp_path


def rows(markdown: str) -> list[list[str]]:
    """Cells of a Markdown table, without its ruler."""
    lines = [[cell.strip() for cell in line.strip("|").split("|")] for line in markdown.splitlines()]
    return [lines[0], *lines[2:]]


def test_csv_has_nine_digits(tmp_path):
    write_csv(pd.DataFrame({"x": [1 / 3, 1e-12], "n": [1, 2]}), tmp_path / "x.csv")
    assert (tmp_path / "x.csv").read_text() == "x,n\n0.333333333,1\n1e-12,2\n"


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0056, "0.0056"), (0.0049321, "0.00493"), (38.25, "38.2"), (123.4, "123"), (-123.6, "-124"),
     (0, "0"), (float("nan"), "-"), ("> 0", "> 0"), ("0.026", "0.026"), ("not given", "not given")],
)  # fmt: skip
def test_short_numbers(value, text):
    assert blocks.short(value) == text


def test_the_table_of_claims():
    head, *body = rows(blocks.claims_table(CLAIMS))
    assert head == ["claim", "source", "paper", "ours", "95 % interval", "n", "verdict"]
    assert body == [
        ["it crawls", "Fig. 1", "yes", "1", "0.7 .. 1", "10", "✔ reproduced"],
        ["it is fast", "Fig. 2", "0.0056", "0.00493", "0.0045 .. 0.0052", "10", "◐ partly"],
        ["it is slow", "Fig. 3", "> 0", "-0.5", "no spread", "1", "✘ not reproduced"],
        ["it sings", "Fig. 4", "33", "-", "-", "0", "no data"],
        ["it is quiet", "Fig. 5", "not given", "123", "120 .. 131", "10", "no number given"],
    ]


def test_counts_and_failures():
    assert blocks.verdict_counts(CLAIMS) == (
        "5 claims: 1 reproduced, 1 partly, 1 not reproduced, 1 no number given, 1 no data."
    )
    listed = blocks.not_reproduced(CLAIMS).splitlines()
    assert [line.split(":")[0] for line in listed] == ["* ◐ **partly**", "* ✘ **not reproduced**"]
    assert "it is fast: paper 0.0056, ours 0.00493 (0.0045 .. 0.0052)." in listed[0]
    assert blocks.not_reproduced(CLAIMS[:1]) == "Everything is reproduced."


def test_the_table_of_runs_has_the_trained_ones():
    head, *body = rows(blocks.runs_table(RUNS))
    assert head[:3] == ["experiment", "seed", "policy"]
    assert [row[0] for row in body] == ["regularized", "unregularized"]
    assert [row[2] for row in body] == ["0123456789", "7207345679"]
    assert body[1][4] == "-"


def test_a_policy_keeps_its_leading_zero_on_the_way_through_a_file(results):
    assert "| 0123456789 |" in blocks.blocks(results)["runs"]()


def test_the_table_of_parameters_is_complete():
    listed = {(where, name): default for where, name, default in rows(blocks.parameters_table())[1:]}
    assert listed["CrawlerParameters", "friction_backward"] == "9.0"
    assert listed["EnvironmentConfig", "regularization"] == "0.01"
    wanted = len(CrawlerParameters.__dataclass_fields__) + len(EnvironmentConfig.model_fields)
    schedule = {name for where, name in listed if where == "configs/paper"}
    assert schedule == {"learning_rate", "discount", "initial_q", "decisions", "seeds"}
    assert len(listed) == wanted + len(EvaluationConfig.model_fields) + len(schedule)


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
