"""The command `crawler-bench readings`, as a user meets it."""

import pytest
from typer.testing import CliRunner

from crawler_bench.cli import app
from crawler_bench.cli.options import require_ours
from crawler_bench.readings.results import read_readings


def test_help_names_what_it_does():
    shown = CliRunner().invoke(app, ["readings", "--help"], terminal_width=200)
    assert shown.exit_code == 0
    assert all(word in shown.output for word in ("--only", "--check", "--preset"))


def test_an_unknown_reading_is_refused_before_anything_runs(tmp_path):
    words = [
        "readings",
        "--only",
        "head_muscle=ext",
        "--runs",
        str(tmp_path / "runs"),
        "--out",
        str(tmp_path),
    ]
    done = CliRunner().invoke(app, words)
    assert isinstance(done.exception, ValueError)
    assert "did you mean 'head_muscle=external'" in str(done.exception)
    assert not (tmp_path / "runs").exists()


def test_rows_cannot_be_checked_without_a_table(tmp_path):
    done = CliRunner().invoke(app, ["readings", "--check", "2", "--out", str(tmp_path)])
    assert isinstance(done.exception, ValueError)
    assert "crawler-bench readings" in str(done.exception)
    assert read_readings(tmp_path) == ()


def test_a_folder_of_something_else_is_left_alone(tmp_path):
    require_ours(tmp_path / "new", "readings", "readings.csv")
    (tmp_path / "thesis.tex").write_text("years of work")
    with pytest.raises(ValueError, match="was not written by"):
        require_ours(tmp_path, "readings", "readings.csv")
