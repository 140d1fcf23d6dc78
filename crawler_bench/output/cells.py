"""Numbers as the cells of a table show them, and tables as Markdown."""

import math
import re

import pandas as pd


def format_number(value: object) -> str:
    """Three significant digits of a number, NaN as "-"; anything else as it is."""
    try:
        number = float(str(value))
    except ValueError:
        return str(value)
    if math.isnan(number):
        return "-"
    return f"{number:.3g}" if abs(number) < 100 else f"{number:.0f}"


def format_interval(low: float, high: float) -> str:
    """Both ends of an interval, or "no spread" where they are equal."""
    if low == high:
        return "no spread"
    return "-" if math.isnan(low) else f"{format_number(low)} .. {format_number(high)}"


def format_cell(value: float, low: float, high: float, n: int, identity: str = "") -> str:
    """An estimate in full: value [interval] (number of runs) #hash; "no spread" where all runs agree."""
    inside = "no spread" if low == high else f"{format_number(low)}, {format_number(high)}"
    bracket = "" if math.isnan(low) else f" [{inside}]"
    return f"{format_number(value)}{bracket} ({n})" + (f" #{identity}" if identity else "")


def markdown(frame: pd.DataFrame) -> str:
    """A frame as a Markdown table.

    Its text may be emphasized or code; a name in it starts no column, row, link or HTML of its own.
    """
    return frame.map(_harmless).to_markdown(index=False, disable_numparse=True)


def _harmless(value: object) -> object:
    if not isinstance(value, str):
        return value
    text = re.sub(r"<(?=[A-Za-z/!?])", "&lt;", " ".join(value.splitlines()))
    return re.sub(r"(?<!\\)\|", r"\|", text).replace("](", r"]\(")
