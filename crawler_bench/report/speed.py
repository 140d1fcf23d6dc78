"""The speed measurements, `make speed`, as tables of the documentation."""

from collections.abc import Callable
from pathlib import Path

import pandas as pd

from crawler_bench.output.cells import format_number, markdown

NOT_MEASURED = "Not measured yet: `make speed`."
Block = Callable[[], str]


def blocks(folder: Path) -> dict[str, Block]:
    """Every generated block about speed by name; all but the list of commits show the commit measured last.

    Args:
        folder: what `make speed` wrote, or not yet.
    """

    def block(make: Callable[[pd.DataFrame], pd.DataFrame], file: str = "measurements") -> Block:
        def text() -> str:
            path = folder / f"{file}.csv"
            if not path.is_file():
                return NOT_MEASURED
            table = pd.read_csv(path, dtype={"commit": str})
            shown = table if file == "commits" else table[table["date"] == table["date"].iloc[-1]]
            return markdown(make(shown).map(format_number))

        return text

    return {
        "speed": block(_goals),
        "speed ratios": block(_ratios),
        "speed values": block(_values),
        "speed learning": block(_learning),
        "speed segments": block(lambda measured: _costs(measured, "segments")),
        "speed batch": block(lambda measured: _costs(measured, "batch")),
        "speed commits": block(_commits, "commits"),
    }


def _goals(measured: pd.DataFrame) -> pd.DataFrame:
    """What has a goal, a ratio to reach or a value not to exceed, and whether it is met."""
    rows = []
    for row in measured.fillna({"against": "-", "unit": ""}).to_dict("records"):
        size = "" if pd.isna(row["size"]) else f", {row['size']:g}"
        unit = f" ({row['unit']})" if row["unit"] and row["against"] == "-" else ""
        head = (f"{row['what']}{size}{unit}", row["against"], row["value"])
        if pd.notna(row["at_least"]):
            rows.append((*head, f">= {row['at_least']:g}", row["value"] >= row["at_least"]))
        elif pd.notna(row["at_most"]):
            rows.append((*head, f"<= {row['at_most']:g}", row["value"] <= row["at_most"]))
    return pd.DataFrame(
        [(*row[:4], "✔" if row[4] else "✘") for row in rows],
        columns=["what", "peer", "ratio or value", "goal", "met"],
    )


def _ratios(measured: pd.DataFrame) -> pd.DataFrame:
    ratios = measured[measured["kind"] == "ratio"]
    columns = {
        "what": "what", "against": "peer", "unit": "unit", "thousands": "thousands per second",
        "value": "ratio", "low": "lowest", "high": "highest", "at_least": "goal",
    }  # fmt: skip
    return ratios.assign(thousands=ratios["per_second"] / 1e3)[list(columns)].rename(columns=columns)


def _values(measured: pd.DataFrame) -> pd.DataFrame:
    columns = {"what": "what", "value": "value", "unit": "unit", "at_most": "goal"}
    return measured.loc[measured["kind"] == "value", list(columns)].rename(columns=columns)


def _learning(measured: pd.DataFrame) -> pd.DataFrame:
    columns = {
        "what": "learner", "size": "crawlers", "per_second": "decisions per second",
        "value": "share of the environment (%)", "at_most": "goal",
    }  # fmt: skip
    return measured.loc[measured["kind"] == "learning", list(columns)].rename(columns=columns)


def _costs(measured: pd.DataFrame, kind: str) -> pd.DataFrame:
    """Microseconds of a decision: one row per size, one column per integrator."""
    costs = measured[measured["kind"] == kind]
    table = costs.assign(value=1e6 * costs["value"]).pivot(index="size", columns="what", values="value")
    return table.rename(columns=lambda name: f"{name} (µs)").rename_axis(index=kind).reset_index()


def _commits(commits: pd.DataFrame) -> pd.DataFrame:
    commit = "`" + commits["commit"].str[:7] + "`"  # quoted: a commit of digits alone is no number
    shown = commits.assign(commit=commit, date=commits["date"].str[:10])
    return shown[["commit", "date", "cpu", "python", "numba", "wall_clock_seconds"]].rename(
        columns={"date": "measured on", "wall_clock_seconds": "seconds that took"}
    )
