"""The tables of the reproduction."""

from crawler_bench.config.schema import EnvironmentConfig, EvaluationConfig
from crawler_bench.paper.tables import (
    claims_table,
    not_reproduced,
    parameters_table,
    runs_table,
    verdict_counts,
)
from crawler_bench.physics.parameters import CrawlerParameters
from tests.paper.frames import CLAIMS, RUNS


def rows(markdown: str) -> list[list[str]]:
    """Cells of a Markdown table, without its ruler."""
    lines = [[cell.strip() for cell in line.strip("|").split("|")] for line in markdown.splitlines()]
    return [lines[0], *lines[2:]]


def test_the_table_of_claims():
    head, *body = rows(claims_table(CLAIMS))
    assert head == ["claim", "source", "paper", "ours", "95 % interval", "n", "verdict"]
    assert body == [
        ["it crawls", "Fig. 1", "yes", "1", "0.7 .. 1", "10", "✔ reproduced"],
        ["it is fast", "Fig. 2", "0.0056", "0.00493", "0.0045 .. 0.0052", "10", "◐ partly"],
        ["it is slow", "Fig. 3", "> 0", "-0.5", "no spread", "1", "✘ not reproduced"],
        ["it sings", "Fig. 4", "33", "-", "-", "0", "no data"],
        ["it is quiet", "Fig. 5", "not given", "123", "120 .. 131", "10", "no number given"],
    ]


def test_counts_and_failures():
    assert verdict_counts(CLAIMS) == (
        "5 claims: 1 reproduced, 1 partly, 1 not reproduced, 1 no number given, 1 no data."
    )
    listed = not_reproduced(CLAIMS).splitlines()
    assert [line.split(":")[0] for line in listed] == ["* ◐ **partly**", "* ✘ **not reproduced**"]
    assert "it is fast: paper 0.0056, ours 0.00493 (0.0045 .. 0.0052)." in listed[0]
    assert not_reproduced(CLAIMS[:1]) == "Everything is reproduced."


def test_the_table_of_runs_has_the_trained_ones():
    head, *body = rows(runs_table(RUNS))
    assert head[:3] == ["experiment", "seed", "policy"]
    assert [row[0] for row in body] == ["regularized", "unregularized"]
    assert [row[2] for row in body] == ["0123456789", "7207345679"]
    assert body[1][4] == "-"


def test_the_table_of_parameters_is_complete():
    listed = {(where, name): default for where, name, default in rows(parameters_table())[1:]}
    assert listed["CrawlerParameters", "friction_backward"] == "9.0"
    assert listed["EnvironmentConfig", "regularization"] == "0.01"
    wanted = len(CrawlerParameters.__dataclass_fields__) + len(EnvironmentConfig.model_fields)
    schedule = {name for where, name in listed if where == "configs/paper"}
    assert schedule == {"learning_rate", "discount", "initial_q", "decisions", "seeds"}
    assert len(listed) == wanted + len(EvaluationConfig.model_fields) + len(schedule)
