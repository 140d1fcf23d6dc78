"""Values that come from outside, from a caller or a file: refused in one line that names them."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray


def require(condition: Any, name: str, value: Any, allowed: str) -> None:
    """Raise a ValueError that names the setting unless the condition holds."""
    if not condition:
        raise ValueError(f"{name} = {value!r} is not possible: it must be {allowed}")


def number(name: str, value: Any, possible: Callable[[float], Any], allowed: str) -> float:
    """Return the setting as a float if it is possible."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = np.nan
    require(possible(number), name, value, allowed)
    return number


def checked_table(values: Any) -> NDArray[np.float64]:
    """Return the table if it is one."""
    table = np.array(values, dtype=np.float64)
    if table.ndim != 2 or not table.size or not np.isfinite(table).all():
        raise ValueError("q_table must be rows of equally many finite numbers")
    return table


def checked_observation(observation: Any, n_observations: int) -> int:
    """Return the observation if the table has a row for it."""
    whole = isinstance(observation, int | np.integer) and not isinstance(observation, bool)
    fits = whole and 0 <= observation < n_observations
    require(fits, "observation", observation, f"a whole number from 0 to {n_observations - 1}")
    return int(observation)
