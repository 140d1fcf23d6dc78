"""`crawler-bench report`: its numbers are those of the CSVs, and it takes what there is."""

import json
import re
import shutil
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from crawler_bench.output.cells import format_number
from crawler_bench.output.csv_files import read_csv, write_csv
from crawler_bench.report.figures import FIGURES
from crawler_bench.report.page import charts
from crawler_bench.report.page.folders import find_folders
from crawler_bench.report.page.write import write_report
from tests.benchmark import frames as samples
from tests.cli.command import complaint, crawler_bench
from tests.report.test_blocks import ROOT

MEGABYTE = 1_000_000
VOID = {"meta", "link", "img", "input", "br", "rect"}
NASTY = "<script>alert(1)</script>&'\""


class Reader(HTMLParser):
    """Everything a page shows, with the CSV that it says it is from."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.open: list[tuple[str, dict[str, str | None]]] = []
        self.numbers: list[tuple[str, str, str, bool]] = []  # CSV, value, text, derived
        self.texts: list[str] = []
        self.counts: list[int] = []
        self.scripts: list[tuple[str | None, str]] = []
        self.feed(page)

    def handle_starttag(self, tag, attributes):
        if tag not in VOID:
            self.open.append((tag, dict(attributes)))

    def handle_endtag(self, tag):
        if tag not in VOID:
            assert self.open.pop()[0] == tag

    def handle_data(self, text):
        tag, attributes = self.open[-1] if self.open else ("", {})
        if tag == "script":
            self.scripts.append((attributes.get("type"), text))
        elif tag == "data":
            source = [each for _, each in self.open if "data-source" in each]
            csv = source[-1]["data-source"] if source else ""
            self.numbers.append(
                (csv, attributes["value"], text, bool(source) and "data-derived" in source[-1])
            )
        elif attributes.get("class") == "count":
            self.counts.append(int(text))
        elif tag != "style":
            self.texts.append(text)


@pytest.fixture(scope="module")
def read(report):
    return Reader(report.read_text())


def values_of(path: Path) -> set[str]:
    """Every number of a CSV, as a page writes it."""
    frame = pd.read_csv(path, dtype=str, keep_default_na=False)
    numbers = pd.to_numeric(frame.stack(), errors="coerce").dropna()
    return {f"{value:.9g}" for value in numbers}


def test_every_number_is_in_the_csv_that_the_page_names(read):
    copied = [each for each in read.numbers if not each[3] and each[0]]
    known = {csv: values_of(Path(csv)) for csv in {csv for csv, *_ in copied}}
    assert len(copied) > 1000
    assert len(known) >= 5
    for csv, value, text, _ in copied:
        assert value in known[csv], (csv, value)
        assert text == format_number(float(value))


def test_every_other_number_was_read_from_results_or_is_in_the_template(read):
    """Names, policies, hashes, commands, manifests; averages of boards."""
    results = [
        path for name in ("paper", "benchmark", "readings") for path in (ROOT / "results" / name).iterdir()
    ]
    words = "\n".join(path.read_text() for path in results if path.suffix in (".csv", ".json", ".txt"))
    own = "\n".join(path.read_text() for path in (ROOT / "crawler_bench/report").rglob("*.html"))
    own += "".join(each.title + each.shows for each in FIGURES.values())
    own += (ROOT / "crawler_bench/report/page/studies.py").read_text()
    known = set(re.findall(r"[\w.+-]*\d[\w.+-]*", words + own + str(ROOT)))
    known |= {f"{float(each):g}" for each in known if re.fullmatch(r"-?\d+\.\d+", each)}
    runs = read_csv(ROOT / "results/paper/runs.csv")
    known |= {str(count) for count in runs.groupby("experiment")["policy"].value_counts()}
    known |= {str(count) for count in runs["experiment"].value_counts()}
    shown = re.findall(r"[\w.+-]*\d[\w.+-]*", " ".join(read.texts))
    assert len(shown) > 500
    assert [each for each in shown if each.strip(".") not in known and each not in known] == []


def test_counts_are_those_of_the_claims(read):
    claims = pd.read_csv(ROOT / "results/paper/claims.csv")
    expected = [len(claims), *sorted(claims["verdict"].value_counts())]
    readings = read_csv(ROOT / "results/readings/readings.csv")
    at_a_glance, buttons = read.counts[: len(expected)], read.counts[len(expected) + 2 :]
    assert [at_a_glance[0], *sorted(at_a_glance[1:])] == expected
    assert read.counts[len(expected) :][:2] == [len(readings), readings["within"].sum()]
    assert [buttons[0], *sorted(buttons[1 : len(expected)])] == expected


def test_the_fastest_agent_is_named_at_a_glance(read):
    summary = read_csv(ROOT / "results/benchmark/summary.csv")
    speeds = summary[(summary["metric"] == "speed") & (summary["regularization"] == 0)].set_index("agent")[
        "value"
    ]
    first, *_ = [value for csv, value, _, _ in read.numbers if csv.endswith("summary.csv")]
    assert float(first) == pytest.approx(speeds.max())
    assert any(f"fastest: {speeds.idxmax()}," in text for text in read.texts)


def test_curves_are_the_means_of_the_csv(read):
    """Noise in the paper: mean over starts, then over runs, computed again; the page draws thousandths."""
    evaluations = read_csv(ROOT / "results/paper/evaluations.csv")
    by_run = evaluations.groupby(["experiment", "noise", "seed"])["speed"].mean()
    expected = by_run.groupby(["experiment", "noise"]).mean()
    first = json.loads(next(text for kind, text in read.scripts if kind == "application/json"))
    drawn = {trace["name"]: trace for trace in first["data"] if trace.get("showlegend") is not False}
    assert set(drawn) == {"regularized", "unregularized", "random action"}
    for name, trace in drawn.items():
        speeds = expected["untrained" if name == "random action" else name]
        assert trace["x"] == speeds.index.tolist()
        assert trace["y"] == pytest.approx(1000 * speeds.to_numpy())
    derived = np.array([float(value) for _, value, _, derived in read.numbers if derived])
    for speed in expected[list(charts.EXPERIMENT_COLOURS)]:
        assert np.isclose(derived, speed, rtol=2e-8, atol=0).any()


def test_nothing_is_left_outside_the_file(report):
    page = report.read_text()
    assert (
        re.findall(
            r"""(?:src|href)=(?!["'](?:#|data:)).{20}""", re.sub(r"<script.*?</script>", "", page, flags=re.S)
        )
        == []
    )
    assert report.stat().st_size <= 12 * MEGABYTE


@pytest.fixture
def planted(tmp_path):
    """A benchmark in which an agent has a nasty name."""
    folder = tmp_path / "results" / "small"
    folder.mkdir(parents=True)
    runs = [
        samples.run(agent, seed=seed, diagonal_distance=0, hash="0a0a0a0a")
        for agent in (NASTY, "b")
        for seed in (0, 1)
    ]
    summary = pd.DataFrame([
        {"agent": agent, "mode": "deterministic", "regularization": 0.0, "metric": name, "value": 0.0054321,
         "low": 0.005, "high": 0.006, "n": 2, "hash": "12345678"}
        for agent in (NASTY, "b") for name in ("speed", "off_diagonal", "speed_noise_0", "speed_noise_0.1")
    ])  # fmt: skip
    pairs = pd.read_csv(ROOT / "results/benchmark/pairs.csv").head(1).assign(first_agent=NASTY)
    learned = pd.concat([samples.curve(NASTY, seed=seed) for seed in (0, 1)])
    policies = samples.tables(**{NASTY: {"deterministic": np.eye(10)}, "b": {"deterministic": np.eye(10)}})
    named = {
        "runs": pd.DataFrame(runs),
        "summary": summary,
        "pairs": pairs,
        "curves": learned,
        "policy_tables": policies,
    }
    for name, frame in named.items():
        write_csv(frame, folder / f"{name}.csv")
    return folder


def test_names_are_escaped(planted, tmp_path):
    (planted / "manifest.json").write_text(json.dumps({"crawler_bench": NASTY}))
    (planted / "command.txt").write_text(NASTY)
    write_report(find_folders([planted]), tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text()
    assert "<script>alert" not in page
    assert "&lt;script&gt;alert(1)&lt;/script&gt;&amp;" in page
    assert page.count("<script") == page.count("</script>") == 4  # two charts, Plotly, and ours


def test_other_folders_are_found_inside_one_and_shown_as_they_are(planted, tmp_path):
    tuning = planted.parent / "tuning"
    tuning.mkdir()
    write_csv(pd.DataFrame({"trial": [0, 1], "reward": [0.125, np.nan]}), tuning / "mine.csv")
    write_csv(pd.DataFrame({"x": range(1000)}), tuning / "long.csv")
    (planted.parent / "runs" / "a").mkdir(parents=True)
    code, out, _ = crawler_bench("report", planted.parent, "--out", tmp_path / "a" / "page.html")
    assert code == 0
    assert "MB in" in out
    read = Reader((tmp_path / "a" / "page.html").read_text())
    assert ("0.125", "0.125") in [(value, text) for _, value, text, _ in read.numbers]
    assert 1000 in read.counts
    assert (tmp_path / "a").is_dir()
    assert [path.name for path in (tmp_path / "a").iterdir()] == ["page.html"]


def test_what_cannot_be_shown_is_said_in_one_line(tmp_path, planted):
    assert "is not a folder" in complaint("report", tmp_path / "nowhere")[1]
    (tmp_path / "empty").mkdir()
    assert "holds no results" in complaint("report", tmp_path / "empty")[1]
    assert "name a file with --out" in complaint("report", planted, "--out", tmp_path)[1]
    shutil.copy(ROOT / "results/paper/runs.csv", planted / "summary.csv")
    _, said = complaint("report", "--quiet", planted, "--out", tmp_path / "x.html")
    assert "written by an older version" in said


def test_every_committed_figure_has_its_words():
    for path in (ROOT / "results").glob("*/*.png"):
        kind = path.parent.name
        assert f"{kind}/{path.stem}" in FIGURES, f"describe {path.name} in crawler_bench/report/figures.py"
