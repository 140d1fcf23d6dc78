"""The ranking of the readings, and the generated blocks of docs/readings.md."""

import json
from collections.abc import Callable
from pathlib import Path

import pandas as pd

from crawler_bench.output.cells import format_number, markdown
from crawler_bench.paper.verdicts import Verdict
from crawler_bench.readings.catalogue import DEFAULT
from crawler_bench.readings.scoring import GROUPS, SHARE_FULL

HEAD = 12  # readings of the ranking in the documentation, beside the named ones
MOST_MOVED = 5  # groups of claims named in the table of fields
NAMED = (DEFAULT.name, "literal")


def ranking(readings: pd.DataFrame) -> pd.DataFrame:
    """All readings: rank, free constants, score and interval, n, within tolerance, failed core claims."""
    return pd.DataFrame({
        "rank": readings["rank"].map(format_number),
        "reading": list(map(described, readings["reading"], readings["family"], readings["changes"])),
        "free constants": readings["free"],
        "score": list(map(_estimate, readings["score"], readings["low"], readings["high"])),
        "n": readings["n"],
        "within tolerance": ["yes" if each else "no" for each in _true(readings["within"])],
        "core claims failed": readings["core_failures"].fillna("").str.replace(" ", ", "),
    })  # fmt: skip


def described(name: str, family: str, changed: str) -> str:
    """The name of a reading; for one of the search, also its values (from JSON)."""
    if family == "search":
        changes = json.loads(changed)
        return f"{name}: " + ", ".join(f"{key.rpartition('.')[2]} {changes[key]:g}" for key in changes)
    return f"**{name}**" if name in NAMED else name


def blocks(results: Path) -> dict[str, Callable[[], str]]:
    """Every generated block about readings by name.

    Args:
        results: the folder that `crawler-bench readings` wrote.
    """

    def read(name: str) -> pd.DataFrame:
        return pd.read_csv(results / f"{name}.csv", keep_default_na=False, na_values=["nan"])

    def table(name: str, columns: dict[str, str]) -> str:
        frame = read(name)[list(columns)].map(format_number)
        if "moved" in columns:
            frame["moved"] = frame["moved"].map(_first_groups)
        return markdown(frame.rename(columns=columns))

    return {
        "readings summary": lambda: _summary(read("readings"), read("confirmation")),
        "readings ranking": lambda: markdown(ranking(_head(read("readings")))),
        "readings fields": lambda: table("fields", {
            "field": "field", "words": "the paper's words", "sourced": "values with a source",
            "default": "default",
        }),
        "readings profiles": lambda: table("fields", {
            "field": "field", "tried": "tried alone", "lowest": "lowest score", "best": "at",
            "highest": "highest score", "tolerated": "within tolerance",
            "not_worse": "not firmly worse than the best", "moved": "groups it moves by a tolerance or more",
        }),
        "readings given": lambda: table("given", {
            "field": "field", "tried": "tried alone", "lowest": "lowest score", "best": "at",
            "highest": "highest score", "tolerated": "within tolerance",
        }),
        "readings epsilon": lambda: _epsilon(read("ends")),
        "readings literal": lambda: _record(read("claims"), "literal"),
        "readings confirmation": lambda: _confirmation(read("confirmation")),
        "readings telling": lambda: table("telling", {
            "quantity": "quantity", "figure": "in the paper's", "low": "5 % of readings below",
            "high": "5 % above", "resolution": "spread over that of seeds",
            "pins": "follows most closely", "rho": "rank correlation",
        }),
        "readings conclusions": lambda: _conclusions(read("conclusions")),
        "readings indistinct": lambda: (results / "indistinct.txt").read_text().strip(),
        "readings rule": lambda: table("rules", {
            "rule": "score", "rho": "rank correlation with ours", "default_rank": "rank of the default",
            "best": "best reading",
        }),
    }  # fmt: skip


def _estimate(value: object, low: object, high: object) -> str:
    return f"{format_number(value)} ({format_number(low)} .. {format_number(high)})"


def _first_groups(listed: str) -> str:
    """The groups that a field moves most."""
    names = listed.split(", ")
    more = f" and {len(names) - MOST_MOVED} more" if len(names) > MOST_MOVED else ""
    return ", ".join(names[:MOST_MOVED]) + more


def _head(readings: pd.DataFrame) -> pd.DataFrame:
    chosen = (pd.to_numeric(readings["rank"]) <= HEAD) | readings["reading"].isin(NAMED)
    head: pd.DataFrame = readings[chosen]
    return head


def _summary(readings: pd.DataFrame, confirmation: pd.DataFrame) -> str:
    rows = readings.set_index("reading")
    default, literal = rows.loc[DEFAULT.name], rows.loc["literal"]
    open_ones = readings[readings["family"] != "given"]
    sourced = readings[readings["free"] == literal["free"]]
    replaced = confirmation[confirmation["replaces"].astype(str) == "True"]
    decision = (
        f"By the rule, {replaced.iloc[0]['reading']} would replace the default."
        if len(replaced)
        else "By the rule, the default stays."
    )
    within, seeds = int(_true(open_ones["within"]).sum()), readings["n"].max()
    best = format_number(sourced["score"].min())
    return (
        f"{len(readings)} readings of {seeds} paired training runs each, {len(GROUPS)} groups of claims. "
        f"Of the {len(open_ones)} that vary what the paper leaves open, {within} are within tolerance. "
        f"The default is number {format_number(default['rank'])} scoring "
        f"{_estimate(*default[['score', 'low', 'high']])} and {default['free']} free constants, "
        f"the literal reading number {format_number(literal['rank'])} with {format_number(literal['score'])} "
        f"and {literal['free']}. Of the {len(sourced)} readings without a free constant of the body the best "
        f"has {best}. {decision}"
    )


def _true(column: pd.Series) -> pd.Series:
    return column.astype(str) == "True"


def _record(claims: pd.DataFrame, reading: str) -> str:
    """The verdicts of a reading's claims."""
    rows = claims[claims["reading"] == reading]
    counts = rows["verdict"].value_counts()
    told = ", ".join(f"{counts[each.value]} {each.value}" for each in Verdict if each.value in counts)
    named = {
        words: ", ".join(rows[rows["verdict"] == verdict.value]["claim"]) or "none"
        for words, verdict in (
            ("Reproduced", Verdict.REPRODUCED),
            ("not", Verdict.NOT),
            ("without data", Verdict.MISSING),
        )
    }
    listed = "; ".join(f"{words}: {claims}" for words, claims in named.items())
    return f"{len(rows)} claims: {told}. {listed}."


def _confirmation(frame: pd.DataFrame) -> str:
    shown = pd.DataFrame({
        "reading": frame["reading"],
        "free": frame["free"],
        "score, seeds of the study": frame["score_before"].map(format_number),
        "score, fresh seeds": list(map(_estimate, frame["score"], frame["low"], frame["high"])),
        "n": frame["n"],
        "lower than the default by": list(
            map(_estimate, frame["lower_by"], frame["lower_low"], frame["lower_high"])
        ),
        "on the diagonal": frame["diagonal"].map(format_number),
        "replaces the default": ["yes" if each else "no" for each in _true(frame["replaces"])],
    })  # fmt: skip
    return markdown(shown)


def _conclusions(frame: pd.DataFrame) -> str:
    def cell(row: pd.Series) -> str:
        return f"{float(row['holds']):.0%} ({float(row['firmly']):.0%})" if row["readings"] else "-"

    counts = frame.groupby("population", sort=False)["readings"].first()
    frame = frame.assign(cell=frame.apply(cell, axis=1))
    wide = frame.pivot(index="conclusion", columns="population", values="cell")
    wide = wide.loc[frame["conclusion"].unique(), list(counts.index)]
    wide.columns = [f"{name} ({counts[name]})" for name in wide.columns]
    return markdown(wide.reset_index())


def _epsilon(ends: pd.DataFrame) -> str:
    """The values of epsilon at which the runs end as the paper says."""
    along = ends[ends["field"] == "regularization"]
    sentences = []
    for end, rows in along.groupby("end", sort=False):
        enough = rows[rows["share"] >= SHARE_FULL]["value"].map(format_number)
        where = f"at epsilon = {', '.join(enough)}" if len(enough) else "at no epsilon"
        sentences.append(f"*{end}*: in at least {SHARE_FULL:.0%} of the runs {where}")
    tried = ", ".join(along["value"].drop_duplicates().map(format_number))
    return f"Of epsilon = {tried}, {along['n'].max()} runs each: {'; '.join(sentences)}."
