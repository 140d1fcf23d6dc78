"""What kernels need of the compiler does the same in Python."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from crawler_bench.physics.compilation import kernel, step_kernel
from crawler_bench.physics.intrinsics import constant, exp, flat, lowest_bit, shape_known

Array = NDArray[np.float64]
_three_by_four = shape_known(3, 4)


@kernel
def _exp(x: float) -> float:
    return exp(x)


@kernel
def _lowest_bit(bits: np.uint64) -> int:
    return lowest_bit(bits)


@kernel
def _constant(row: Array, i: int) -> float:
    return constant(row, i)


@step_kernel
def _number(array: Array, known: bool) -> tuple[int, int]:
    """Write to each entry its place in memory."""
    rows, row = _three_by_four(array) if known else array, flat(array)
    for i in range(row.size):
        row[i] = i
    return rows.shape[0] * 10 + rows.shape[1], row.size


def test_exp_is_that_of_the_library() -> None:
    assert [_exp(x) for x in (-30.0, -0.1, 0.0, 2.0)] == [math.exp(x) for x in (-30.0, -0.1, 0.0, 2.0)]


@pytest.mark.parametrize("place", [0, 1, 31, 32, 63])
def test_the_lowest_bit_is_found(place: int) -> None:
    assert _lowest_bit(np.uint64(1 << place | 1 << 63)) == place


def test_a_constant_is_read_when_the_kernel_runs() -> None:
    row = np.array([1.0, 2.0, 3.0])
    assert [_constant(row, i) for i in range(3)] == row.tolist()
    row[1] = 5.0
    assert _constant(row, 1) == 5.0


@pytest.mark.parametrize("known", [False, True])
def test_an_array_seen_otherwise_is_the_same_memory(known: bool) -> None:
    array = np.zeros((3, 4))
    assert _number(array, known) == (34, 12)
    np.testing.assert_array_equal(array, np.arange(12.0).reshape(3, 4))
