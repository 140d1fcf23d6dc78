"""The speed measurements, `make bench`, as tables of the documentation."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from crawler_bench.output.cells import format_number, markdown

NOT_MEASURED = "Not measured yet: `make bench`."
Block = Callable[[], str]


def blocks(folder: Path) -> dict[str, Block]:
    """Every generated block about speed by name.

    Args:
        folder: what `python -m speed` wrote, or not yet.
    """

    def block(make: Callable[..., pd.DataFrame], *names: str) -> Block:
        def text() -> str:
            paths = [folder / f"{name}.csv" for name in names]
            if not all(path.is_file() for path in paths):
                return NOT_MEASURED
            frame = make(*(pd.read_csv(path) for path in paths)).map(format_number)
            return markdown(frame)

        return text

    return {
        "performance": block(_goals, "ratios", "values"),
        "performance ratios": block(_ratios, "ratios"),
        "performance values": block(_values, "values"),
        "performance counts": block(lambda counts: counts, "counts"),
        "performance learning": block(_learning, "learning"),
        "performance segments": block(lambda costs: _costs(costs, "segments"), "segments"),
        "performance batch": block(lambda costs: _costs(costs, "size"), "batch"),
    }


def _goals(ratios: pd.DataFrame, values: pd.DataFrame) -> pd.DataFrame:
    """What has a goal: ratios, which are to be at least so high, and numbers to be at most so high."""
    rows = [
        (row["what"], row["peer"], row["ratio"], f">= {row['goal']:g}", row["ratio"] >= row["goal"])
        for row in ratios[ratios["goal"].notna()].to_dict("records")
    ]
    rows += [
        (_with_unit(row), "-", row["value"], f"<= {row['goal']:g}", row["value"] <= row["goal"])
        for row in values[values["goal"].notna()].to_dict("records")
    ]
    return pd.DataFrame(
        [(*row[:4], "✔" if row[4] else "✘") for row in rows],
        columns=["what", "peer", "ratio or value", "goal", "met"],
    )


def _with_unit(row: Mapping[Any, Any]) -> str:
    return f"{row['what']} ({row['unit']})" if isinstance(row["unit"], str) else str(row["what"])


def _ratios(ratios: pd.DataFrame) -> pd.DataFrame:
    columns = {
        "what": "what", "peer": "peer", "unit": "unit", "per_second": "thousands per second",
        "peer_per_second": "of the peer", "ratio": "ratio", "ratio_min": "lowest", "ratio_max": "highest",
        "goal": "goal", "note": "note",
    }  # fmt: skip
    thousands = ratios.assign(
        per_second=ratios["per_second"] / 1e3, peer_per_second=ratios["peer_per_second"] / 1e3
    )
    return thousands[list(columns)].astype({"note": object}).fillna({"note": ""}).rename(columns=columns)


def _values(values: pd.DataFrame) -> pd.DataFrame:
    return values[["what", "value", "unit", "goal"]]


def _learning(learning: pd.DataFrame) -> pd.DataFrame:
    shown = learning.assign(environment_share=100 * learning["environment_share"])
    shown.columns = [
        "learner", "crawlers", "decisions", "gradient updates", "decisions per second",
        "share of the environment (%)",
    ]  # fmt: skip
    return shown


def _costs(costs: pd.DataFrame, over: str) -> pd.DataFrame:
    """Microseconds of a decision: one row per size, one column per integrator."""
    table = costs.assign(seconds=1e6 * costs["seconds"]).pivot(
        index=over, columns="integrator", values="seconds"
    )
    return table.rename(columns=lambda name: f"{name} (µs)").reset_index()
