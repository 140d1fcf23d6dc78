"""Numbers as the cells of a table show them."""

import math


def short(value: object) -> str:
    """A number with as many digits as a reader wants; anything else as it is."""
    try:
        number = float(str(value))
    except ValueError:
        return str(value)
    if math.isnan(number):
        return "-"
    return f"{number:.3g}" if abs(number) < 100 else f"{number:.0f}"


def interval(low: float, high: float) -> str:
    """An interval in short."""
    if low == high:
        return "no spread"
    return "-" if math.isnan(low) else f"{short(low)} .. {short(high)}"


def cell(value: float, low: float, high: float, n: int, identity: str = "") -> str:
    """An estimate in full: value [interval] (number of runs) #hash.

    An interval that closes on the value because all runs agree says so in words.
    """
    inside = "no spread" if low == high else f"{short(low)}, {short(high)}"
    bracket = "" if math.isnan(low) else f" [{inside}]"
    return f"{short(value)}{bracket} ({n})" + (f" #{identity}" if identity else "")
