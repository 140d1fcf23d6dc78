"""The sections of the report that have a form of their own: paper, benchmark and readings."""

from collections.abc import Callable

import pandas as pd

from crawler_bench.benchmark.figures.looks import modes_of, regularizations
from crawler_bench.benchmark.keys import action_columns, select
from crawler_bench.benchmark.summary import metric
from crawler_bench.report.page import charts, media
from crawler_bench.report.page.cells import Cell, Table, cell, plain_table
from crawler_bench.report.page.claims import claims
from crawler_bench.report.page.folders import Folder
from crawler_bench.report.page.sections import Board, Fact, Section, counts, films, other, section

_GAITS = ("regularized", "unregularized")


def paper(folder: Folder, identity: str) -> Section:
    """Claims, films, the curve of Fig. 3C, policies and runs."""
    runs = folder.frame("runs")
    noise = charts.paper_noise(folder.frame("evaluations"))
    names = ["experiment", "seed", "policy", "speed", "stall_share", "cycle_duration", "diagonal_distance"]
    rows = [[cell(row[name], code=name == "policy") for name in names] for row in runs.to_dict("records")]
    headings = [
        "experiment", "seed", "policy", "speed (L/tau)", "starts that stall", "cycle duration (tau)",
        "entries off the diagonal",
    ]  # fmt: skip
    table = Table(
        f"{identity}-runs", "Trained runs, one per row", "runs.csv", headings, rows,
        {"experiment": _GAITS[0] if _GAITS[0] in set(runs["experiment"]) else ""},
    )  # fmt: skip
    speeds = [
        [
            cell(row["experiment"]),
            cell(row["noise"]),
            cell(row["speed"], row["low"], row["high"]),
            cell(row["n"]),
        ]
        for row in noise.to_dict("records")
    ]
    curve = Table(
        f"{identity}-noise", "Speed against noise, mean over starts and runs with its 95 % interval",
        "evaluations.csv", ["experiment", "noise s", "speed (L/tau)", "n"], speeds, {"experiment": ""},
        derived=True,
    )  # fmt: skip
    judged = folder.frame("claims")
    verdicts = counts(judged["verdict"].fillna("not judged"))
    return section(
        folder, identity,
        glance=[Fact("claims", len(judged)), *(Fact(verdict, n) for verdict, n in verdicts)],
        claims=claims(judged, identity, [path.stem for path in folder.path.glob("*.png")]),
        films=films(folder), charts=[charts.paper_chart(noise)], boards=_learned(runs), tables=[curve, table],
    )  # fmt: skip


def _learned(runs: pd.DataFrame) -> list[Board]:
    """Every policy that runs of either gait ended with, the commonest first."""
    boards = []
    for name in _GAITS:
        policies = runs.loc[runs["experiment"] == name, "policy"].astype(str)
        for policy, count in counts(policies):
            digits = policy.split("-") if "-" in policy else list(policy)
            if "*" in digits:
                continue
            actions = [int(digit, 36) for digit in digits]
            words = f"{name} policy {policy}: neuron switched on for each contracted segment, head first"
            text = f"{count} of {len(policies)} run{'s' if len(policies) > 1 else ''}"
            boards.append(Board(media.board(media.one_hot(actions), words), name, text, code=policy))
    return boards


def benchmark(folder: Folder, identity: str) -> Section:
    """Curves, policies, and every number of the comparison with its interval, n and hash."""
    summary, tables = folder.frame("summary"), folder.frame("policy_tables")
    shown = [*charts.noise_charts(summary), *charts.learning_charts(folder.frame("curves"))]
    found = [_comparison(summary, identity), _pairs(folder.frame("pairs"), identity)]
    found += [_runs(folder.frame("runs"), identity)]
    failures = folder.frame("failures")
    if len(failures):
        found.append(plain_table(f"{identity}-failures", "Runs that failed", "failures.csv", failures))
    return section(
        folder, identity, glance=_fastest(summary), charts=shown, boards=_boards(tables, summary),
        tables=found,
    )  # fmt: skip


def _fastest(summary: pd.DataFrame) -> list[Fact]:
    """The fastest agent, and what it is to be compared with."""
    speeds = summary[(summary["metric"] == "speed") & (summary["regularization"] == 0) & (summary["n"] > 0)]
    if speeds.empty:
        return []
    best = speeds.sort_values("value", kind="stable").iloc[-1]
    chosen = [(f"fastest: {best['agent']}, {best['mode']},", best)]
    for agent, words in _REFERENCES.items():
        chosen += [(words, row) for _, row in speeds[speeds["agent"] == agent].head(1).iterrows()]
    return [Fact(words, cell(row["value"], row["low"], row["high"]), "summary.csv") for words, row in chosen]


_REFERENCES = {"wave": "nearest-neighbour wiring", "random": "random action"}


def _comparison(summary: pd.DataFrame, identity: str) -> Table:
    rows = [
        [
            cell(row["agent"]), cell(row["mode"]), cell(row["regularization"]),
            cell(metric(row["metric"]).heading), cell(row["value"], row["low"], row["high"]),
            cell(row["n"]), cell(row["hash"], code=True),
        ]
        for row in summary.to_dict("records")
    ]  # fmt: skip
    headings = ["agent", "mode", "regularization", "metric", "value", "n", "hash"]
    first = metric("speed").heading if "speed" in set(summary["metric"]) else ""
    filters = {"metric": first, "regularization": "", "agent": "", "mode": ""}
    caption = (
        "Every agent in every metric; interquartile mean over runs (of a share the mean), 95 % interval. "
        "`crawler-bench reproduce-cell HASH` re-runs a row from scratch."
    )
    return Table(f"{identity}-comparison", caption, "summary.csv", headings, rows, filters)


def _pairs(pairs: pd.DataFrame, identity: str) -> Table:
    rows = [_pair(row) for row in pairs.to_dict("records")]
    headings = [
        "metric", "first", "second", "first minus second", "n", "P(first > second)", "p", "p, Holm", "p, FDR",
    ]  # fmt: skip
    first = metric("speed").heading if "speed" in set(pairs.get("metric", [])) else ""
    caption = "Agents in pairs over the same seeds: difference with its 95 % interval, and p values."
    filters = {"metric": first, "first": "", "second": ""}
    return Table(f"{identity}-pairs", caption, "pairs.csv", headings, rows, filters)


def _pair(row: dict[object, object]) -> list[Cell]:
    sides = [
        f"{row[f'{side}_agent']}, {row[f'{side}_mode']}, {row[f'{side}_regularization']:g}"
        for side in ("first", "second")
    ]
    improvement = cell(row["improvement"], row["improvement_low"], row["improvement_high"])
    return [
        cell(metric(str(row["metric"])).heading), *map(cell, sides),
        cell(row["difference"], row["low"], row["high"]), cell(row["n"]), improvement,
        *(cell(row[name]) for name in ("p", "p_holm", "p_fdr")),
    ]  # fmt: skip


def _runs(runs: pd.DataFrame, identity: str) -> Table:
    names = [
        "agent",
        "mode",
        "regularization",
        "seed",
        "policy",
        "speed",
        "stall_share",
        "off_diagonal",
        "hash",
    ]
    headings = [
        "agent", "mode", "regularization", "seed", "policy", "speed (L/tau)", "starts that stall",
        "off the diagonal", "hash",
    ]  # fmt: skip
    rows = [
        [cell(row[name], code=name in ("policy", "hash")) for name in names]
        for row in runs.to_dict("records")
    ]
    filters = {"agent": str(runs["agent"].iloc[0]), "mode": "", "regularization": ""}
    caption = "Runs, one per row; `*` in a policy: an action that is drawn."
    return Table(f"{identity}-runs", caption, "runs.csv", headings, rows, filters)


def _boards(tables: pd.DataFrame, summary: pd.DataFrame) -> list[Board]:
    """The mean policy of every agent, mode and regularization."""
    boards, columns = [], action_columns(tables)
    for agent, mode in modes_of(tables):
        for value in regularizations(tables):
            group = {"agent": agent, "mode": mode, "regularization": value}
            chosen = select(tables, **group)
            if chosen.empty:
                continue
            mean = chosen.groupby("observation")[columns].mean().to_numpy(float)
            off = select(summary, metric="off_diagonal", **group)["value"]
            words = f"mean policy of {agent}, {mode}, regularization {value:g}"
            off_diagonal = cell(off.iloc[0]) if len(off) else None
            text = f"{mode}, ε = {value:g}"
            boards.append(Board(media.board(mean, words), agent, text, off_diagonal=off_diagonal))
    return boards


def readings(folder: Folder, identity: str) -> Section:
    """The ranking, and what is read off it."""
    ranked = folder.frame("readings")
    names = ["rank", "reading", "family", "score", "within", "free", "free_constants", "core_failures", "n"]
    names = [name for name in names if name in ranked]
    rows = [
        [cell(row["score"], row["low"], row["high"]) if name == "score" else cell(row[name])
         for name in names]
        for row in ranked.to_dict("records")
    ]  # fmt: skip
    headings = {
        "score": "score (lower is better)", "within": "within tolerance", "free": "free constants",
        "free_constants": "which", "core_failures": "core claims missed",
    }  # fmt: skip
    caption = (
        "Readings, ranked: those within tolerance first, by their number of free constants, then by score. "
        "A score is the mean distance to the claims in tolerances: 0 is the paper's story, 5 no data."
    )
    shown = [headings.get(name, name) for name in names]
    found = [Table(f"{identity}-ranking", caption, "readings.csv", shown, rows, {"family": ""})]
    for name, what in _MORE.items():
        frame = folder.frame(name)
        if len(frame):
            found.append(plain_table(f"{identity}-{name}", what, f"{name}.csv", frame))
    tried = [Fact("readings", len(ranked))]
    if "within" in ranked:
        tried.append(Fact("within tolerance of the claims", int(ranked["within"].sum())))
    return other(folder, identity, found, glance=tried)


_MORE = {
    "conclusions": "In how many readings each conclusion of the paper holds",
    "fields": "Every field that the paper leaves open",
    "confirmation": "Rivals of the default, tried again on fresh seeds",
}


STUDIES: dict[str, Callable[[Folder, str], Section]] = {
    "paper": paper, "benchmark": benchmark, "readings": readings,
}  # fmt: skip
