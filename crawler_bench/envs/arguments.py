"""Arguments of the environments: what is not possible is refused by name."""

import math
from numbers import Real
from typing import Any

import numpy as np

from crawler_bench.physics.parameters import CrawlerParameters


def require_at_least_zero(name: str, value: Any) -> None:
    """Raise a ValueError unless this is a finite number of at least 0."""
    if not (_is_number(value) and math.isfinite(value) and value >= 0):
        raise ValueError(f"{name} = {value!r} is not possible: it must be a finite number of at least 0")


def require_positive(name: str, value: Any) -> None:
    """Raise a ValueError unless this is a number above 0; infinity is one."""
    if not (_is_number(value) and value > 0):
        raise ValueError(f"{name} = {value!r} is not possible: it must be a number above 0")


def require_count(name: str, value: Any) -> None:
    """Raise a ValueError unless this is a whole number of at least 1."""
    if not isinstance(value, int | np.integer) or isinstance(value, bool) or value < 1:
        raise ValueError(f"{name} = {value!r} is not possible: it must be a whole number of at least 1")


def require_parameters(value: Any) -> CrawlerParameters:
    """Return the parameters, or raise a TypeError that says what is there instead."""
    if not isinstance(value, CrawlerParameters):
        raise TypeError(f"parameters must be a CrawlerParameters, not {type(value).__name__}")
    return value


def _is_number(value: Any) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)
