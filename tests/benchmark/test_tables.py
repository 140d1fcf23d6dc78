"""The tables of a benchmark: one set of cells in three formats, and the blocks of the documentation."""

import csv
import re
import subprocess
import sys

import pandas as pd
import pytest

from crawler_bench.benchmark import tables
from crawler_bench.benchmark.pairwise import compare
from crawler_bench.benchmark.summary import summarize_benchmark
from crawler_bench.output.csv_files import read_csv, write_csv
from crawler_bench.output.latex import latex
from crawler_bench.report import blocks
from tests.benchmark.frames import NAN, evaluated, runs_of

FAST = [0.0061, 0.0062, 0.0064, 0.0065, 0.0069]
SLOW = [0.0051, 0.0053, 0.0052, 0.0058, 0.0047]
ROWS = [
    row
    for level in (0.0, 0.01)
    for row in (
        *runs_of("wave", "speed", [0.00565] * 5, regularization=level, reward=0.002),
        *runs_of("my_agent", "speed", FAST, regularization=level, mode="stochastic", reward=0.003,
                 policy="**********"),
        *runs_of("dqn", "speed", SLOW, regularization=level, reward=0.001, cycle_duration=NAN),
    )
]  # fmt: skip
POLICIES = ["0123456789", "0123456789", "0023456789", "0123456789", "9123456789"]
for row in ROWS:
    if row["agent"] == "dqn":
        row["policy"] = POLICIES[row["seed"]]
RUNS = pd.DataFrame(ROWS)
CURVES = {
    "wave": {0.0: 0.00565, 0.2: 0.006, 0.4: 0.007},
    "my_agent": {0.0: 0.0064, 0.2: 0.006, 0.4: 0.002},
    "dqn": {0.0: 0.0052, 0.2: 0.0061, 0.4: 0.0063},
}


@pytest.fixture(scope="module")
def summary():
    return summarize_benchmark(
        RUNS, evaluated(ROWS, CURVES), pd.DataFrame(), lambda *key: f"{abs(sum(map(ord, str(key)))):06x}"
    )


@pytest.fixture(scope="module")
def pairs():
    return compare(RUNS, evaluated(ROWS, CURVES))


@pytest.fixture(scope="module")
def results(summary, pairs, tmp_path_factory):
    """A folder as the benchmark leaves it, read back through its CSVs."""
    folder = tmp_path_factory.mktemp("results") / "benchmark"
    folder.mkdir()
    for name, frame in {"summary": summary, "pairs": pairs, "runs": RUNS}.items():
        write_csv(frame, folder / f"{name}.csv")
    read = (read_csv(folder / f"{name}.csv") for name in ("summary", "pairs", "runs"))
    tables.write_tables(*read, folder / "tables")
    return folder


def markdown_rows(text):
    lines = [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines()]
    return [lines[0], *lines[2:]]


def latex_rows(text):
    r"""Cells between the last head and \bottomrule, as plain text."""
    unescaped = re.sub(r"\\([%_#&])", r"\1", re.sub(r"\$([<>-])\$", r"\1", text))
    unescaped = unescaped.replace(r"$L/\tau$", "L/tau").replace(r"$\tau$", "tau")
    lines = [line.removesuffix(r" \\") for line in unescaped.splitlines() if line.endswith(r"\\")]
    rows = [line.split(" & ") for line in lines if " & " in line]
    return [row for i, row in enumerate(rows) if row not in rows[:i] or i > 1]


@pytest.mark.parametrize("name", ["comparison", "noise", "pairs"])
def test_three_formats_have_the_same_cells(results, name):
    shown = markdown_rows((results / "tables" / f"{name}.md").read_text())
    with (results / "tables" / f"{name}.csv").open(newline="") as file:
        assert list(csv.reader(file)) == shown
    source = (results / "tables" / f"{name}.tex").read_text()
    table = re.sub(r"^%.*\n", "", source, flags=re.M)
    plain = [[re.sub(r" #\S+$", "", cell) for cell in row] for row in shown]
    assert latex_rows(table) == plain
    hashes = [cell.partition(" #")[2] for row in shown[1:] for cell in row if " #" in cell]
    assert re.findall(r"^% .*: .*: #(\S+)$", source, flags=re.M) == hashes
    assert bool(hashes) == (name != "pairs")


@pytest.mark.parametrize("name", ["comparison", "noise", "pairs"])
def test_latex_is_balanced_and_has_booktabs(results, name):
    source = (results / "tables" / f"{name}.tex").read_text()
    table = re.sub(r"(?m)^%.*\n", "", source)
    bare = re.sub(r"\\[{}%$_#&\\]", "", table)
    assert bare.count("{") == bare.count("}")
    assert bare.count("$") % 2 == 0
    environments = re.findall(r"\\(begin|end)\{(\w+)\}", table)
    open_ = []
    for word, environment in environments:
        if word == "begin":
            open_.append(environment)
        else:
            assert open_.pop() == environment
    assert not open_
    assert not re.search(r"[_#&%]", re.sub(r" & |%$|\{tab:\w+\}", "", bare, flags=re.M))
    assert "<" not in bare.replace("$<$", "")
    assert ">" not in bare.replace("$>$", "")
    for rule in ("toprule", "midrule", "bottomrule"):
        assert f"\\{rule}" in table
    widths = {line.count(" & ") for line in table.splitlines() if " & " in line}
    assert len(widths) == 1
    columns = re.search(r"\\begin\{(?:tabular|longtable)\}\{(l+)\}", table)
    assert columns is not None
    assert len(columns[1]) == widths.pop() + 1


def test_minus_signs_and_exponents_in_latex():
    frame = pd.DataFrame({"agent": ["a-tuned"], "x": ["-4e-05 [-0.1, 0.2] (10)"], "seeds": ["> 1000"]})
    assert r"a-tuned & $-$4e-05 [$-$0.1, 0.2] (10) & $>$ 1000 \\" in latex(frame, "A.", "tab:a")


def test_the_comparison_has_full_cells(summary):
    shown = tables.comparison(summary).set_index(["agent", "regularization"])
    assert len(shown) == 6
    assert shown.columns.tolist() == [
        "mode", "speed (L/tau)", "score: random 0, best table 1", "regret to the best table (L)",
        "regret to the best stochastic table (L)", "regret to the best policy on the whole state (L)",
        "cycle duration (tau)", "speed averaged over noise (L/tau)", "starts that stall",
        "distance from the diagonal", "decisions learned from", "decisions to 90 % of the final speed",
        "gradient updates",
    ]  # fmt: skip
    wave, dqn = shown.loc[("wave", "0.01")], shown.loc[("dqn", "0")]
    assert re.fullmatch(r"0\.00565 \[no spread\] \(5\) #\w+", wave["speed (L/tau)"])
    assert re.fullmatch(r"0\.0052 \[0\.00\d+, 0\.00\d+\] \(5\) #\w+", dqn["speed (L/tau)"])
    assert re.fullmatch(r"- \(0\) #\w+", dqn["cycle duration (tau)"])


def test_the_hash_of_a_cell_is_that_of_its_row(summary):
    shown = tables.comparison(summary.assign(hash=[f"h{i}" for i in range(len(summary))]))
    for row in shown.to_dict("records"):
        number = int(row["speed (L/tau)"].partition("#h")[2])
        source = summary.iloc[number]
        assert (source["agent"], source["mode"], source["metric"]) == (row["agent"], row["mode"], "speed")
        assert f"{source['regularization']:g}" == row["regularization"]


def test_the_noise_table_has_a_column_an_amplitude(summary):
    shown = tables.noise(summary)
    assert shown.columns.tolist()[3:] == [f"speed at s = {s} (L/tau)" for s in (0, 0.2, 0.4)]
    assert shown[shown["agent"] == "wave"].iloc[0, -1].startswith("0.007 [no spread] (5) #")


def test_the_pairs_say_which_is_which(pairs):
    shown = tables.pairs_table(pairs)
    assert len(shown) == len(pairs)
    row = shown[(shown["first"] == "my_agent, stochastic, 0") & (shown["second"] == "dqn, deterministic, 0")]
    speed = row[row["metric"] == "speed (L/tau)"].iloc[0]
    assert re.fullmatch(r"0\.00\d+ \[0\.00\d+, 0\.00\d+\] \(5\)", speed["first minus second"])
    assert (speed["P(first > second)"], speed["p"]) == ("1", "0.0625")
    assert speed["p, Holm"] == "0.188 (3)"
    noisy = row[row["metric"].str.startswith("speed averaged")].iloc[0]
    assert re.fullmatch(r"0\.18\d \[no spread\], second overtakes", noisy["curves cross at s"])
    wave = shown[
        (shown["first"] == "wave, deterministic, 0") & (shown["second"] == "wave, deterministic, 0.01")
    ]
    assert wave.iloc[0]["first minus second"] == "0 [no spread] (5)"
    assert wave.iloc[0]["seeds for 10 %"] == "no spread"


def test_the_matrix_reads_from_row_to_column(pairs):
    loud = pairs.assign(p_holm=0.2, p_fdr=0.2)
    loud.loc[(loud["first_agent"] == "wave") & (loud["second_agent"] == "dqn"), "p_holm"] = 0.01
    loud.loc[(loud["first_agent"] == "wave") & (loud["second_agent"] == "my_agent"), "p_fdr"] = 0.01
    shown = tables.matrix(loud, 0.0).set_index("regularization 0")
    assert shown.loc["wave, deterministic", "dqn, deterministic"] == "1 **"
    assert shown.loc["dqn, deterministic", "wave, deterministic"] == "0 **"
    assert shown.loc["wave, deterministic", "my_agent, stochastic"] == "0 *"
    assert shown.loc["my_agent, stochastic", "dqn, deterministic"] == "1"
    assert shown.loc["dqn, deterministic", "dqn, deterministic"] == ""


def test_what_agents_learned(results):
    shown = markdown_rows((results / "tables" / "learned.md").read_text())
    assert shown[0] == [
        "regularization", "agent", "mode", "most common policy", "runs", "share", "different policies",
    ]  # fmt: skip
    assert ["0.01", "dqn", "deterministic", "`0123456789`", "3 of 5", "0.6", "3"] in shown
    assert ["0", "my_agent", "stochastic", "`**********`", "5 of 5", "1", "1"] in shown
    assert [row[0] for row in shown[1:]] == ["0"] * 3 + ["0.01"] * 3


TEMPLATE = "<!-- begin {0} -->\n<!-- end {0} -->\n"


@pytest.mark.parametrize("name", ["benchmark", "benchmark pairs", "agents learned"])
def test_a_block_is_filled(results, name):
    filled = blocks.regenerate(TEMPLATE.format(name), results.parent / "paper")
    assert len(filled.splitlines()) > 7
    assert blocks.regenerate(filled, results.parent / "paper") == filled


def test_the_block_of_the_readme(results):
    head, *body = markdown_rows(tables.blocks(results)["benchmark"]())
    assert head[:6] == ["regularization", "agent", "mode", "n", "speed (L/tau)", "95 % interval"]
    assert body[0][:7] == ["0", "wave", "deterministic", "5", "0.00565", "no spread", "40"]
    assert [row[0] for row in body] == ["0"] * 3 + ["0.01"] * 3


def test_a_number_that_fewer_runs_have_says_so():
    rows = runs_of("a", "cycle_duration", [40.0, 40.0, NAN])
    found = summarize_benchmark(pd.DataFrame(rows), evaluated(rows), pd.DataFrame(), lambda *key: "x")
    assert tables.compact(found)["cycle duration (tau)"].item() == "40 (2)"


def test_the_block_of_pairs_says_how_small_p_can_get(results):
    text = tables.blocks(results)["benchmark pairs"]()
    assert "With 5 paired seeds p is at least 0.0625, and Holm's over 3 pairs at least 0.188." in text
    assert "excess (%)" in text


def test_missing_results_are_one_line(tmp_path):
    document = tmp_path / "README.md"
    document.write_text(TEMPLATE.format("benchmark"))
    done = subprocess.run(
        [sys.executable, "-m", "crawler_bench.report.blocks", "README.md"],
        cwd=tmp_path, capture_output=True, text=True, timeout=300,
    )  # fmt: skip
    assert done.returncode == 1
    assert done.stderr.splitlines() == [
        "README.md: results/benchmark/summary.csv is missing; `crawler-bench benchmark` writes it"
    ]
    assert document.read_text() == TEMPLATE.format("benchmark")
