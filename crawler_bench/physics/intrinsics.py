"""What kernels need of the compiler and numba does not offer. Without compilation, each is plain Python."""

import importlib
import math
from collections.abc import Callable
from typing import Any

import numba
import numpy as np
from llvmlite import ir
from numba.core.imputils import impl_ret_borrowed
from numba.extending import intrinsic
from numpy.typing import NDArray

from crawler_bench.physics.compilation import config

Array = NDArray[np.float64]

WORD = 64  # bits of an integer that lists what is found, which takes no branches
NO_BITS = np.uint64(0)

_borrowed: Any = impl_ret_borrowed  # its declared type lacks its arguments


def _in_kernels(emit: Callable[..., Any], in_python: Callable[..., Any]) -> Any:
    """What is emitted into kernels; without compilation, the function of Python.

    Not by numba's `overload`: such a function could return no view of an array in kernels that count no
    references.
    """
    return in_python if config.DISABLE_JIT else intrinsic(emit)


def _emit_exp(typing_context: Any, x: Any) -> Any:
    def emit(context: Any, builder: Any, signature: Any, operands: Any) -> Any:
        return builder.call(builder.module.declare_intrinsic("llvm.exp", [ir.DoubleType()]), operands)

    return numba.float64(numba.float64), emit


exp: Callable[[float], float] = _in_kernels(_emit_exp, math.exp)
"""The exponential function of the C library.

Numba calls it through a wrapper for old libraries; a crawler would pay for that several times a decision.
"""


def _arrays() -> Any:
    return importlib.import_module("numba.np.arrayobj")  # not needed where the cache has the code


def _require_contiguous(array: Any) -> None:
    if array.layout != "C" or array.dtype != numba.float64:
        raise numba.TypingError("a contiguous array of doubles is needed")


def _view(context: Any, builder: Any, given: Any, kind: Any, shape: list[Any]) -> Any:
    """The memory of a contiguous array of doubles as an array of another kind and shape."""
    item = context.get_constant(numba.intp, 8)
    steps = [item]
    for size in reversed(shape[1:]):
        steps.insert(0, builder.mul(steps[0], size))
    view = _arrays().make_array(kind)(context, builder)
    _arrays().populate_array(
        view, data=given.data, shape=shape, strides=steps, itemsize=item, meminfo=given.meminfo,
        parent=given.parent,
    )  # fmt: skip
    return _borrowed(context, builder, kind, view._getvalue())


def shape_known(*shape: int) -> Callable[[Array], Array]:
    """A function that returns a contiguous array of doubles as it is, and whose compiler knows the shape.

    Where rows lie and how long loops are, is then not calculated in each call but compiled in. The caller
    has to see to it that the array has this shape.
    """

    def emit_known(typing_context: Any, array: Any) -> Any:
        _require_contiguous(array)

        def emit(context: Any, builder: Any, signature: Any, operands: Any) -> Any:
            given = _arrays().make_array(array)(context, builder, operands[0])
            sizes = [context.get_constant(numba.intp, n) for n in shape]
            return _view(context, builder, given, array, sizes)

        return array(array), emit

    known: Callable[[Array], Array] = _in_kernels(emit_known, lambda array: array)
    return known


def _emit_flat(typing_context: Any, array: Any) -> Any:
    _require_contiguous(array)
    row = numba.types.Array(array.dtype, 1, "C")

    def emit(context: Any, builder: Any, signature: Any, operands: Any) -> Any:
        given = _arrays().make_array(array)(context, builder, operands[0])
        size = context.get_constant(numba.intp, 1)
        for n in range(array.ndim):
            size = builder.mul(size, builder.extract_value(given.shape, n))
        return _view(context, builder, given, row, [size])

    return row(array), emit


flat: Callable[[Array], Array] = _in_kernels(_emit_flat, lambda array: array.reshape(array.size))
"""A contiguous array of doubles as one row: the same memory."""


def _emit_lowest_bit(typing_context: Any, bits: Any) -> Any:
    def emit(context: Any, builder: Any, signature: Any, operands: Any) -> Any:
        return builder.cttz(operands[0], ir.Constant(ir.IntType(1), 1))

    return numba.int64(numba.uint64), emit


lowest_bit: Callable[[np.uint64], int] = _in_kernels(
    _emit_lowest_bit, lambda bits: (int(bits) & -int(bits)).bit_length() - 1
)
"""The place of the lowest bit that is set; there must be one."""


def _emit_constant(typing_context: Any, array: Any, i: Any) -> Any:
    _require_contiguous(array)

    def emit(context: Any, builder: Any, signature: Any, operands: Any) -> Any:
        given = _arrays().make_array(array)(context, builder, operands[0])
        entry = builder.load(builder.gep(given.data, [operands[1]]))
        entry.set_metadata("invariant.load", builder.module.add_metadata([]))
        return entry

    return numba.float64(array, numba.intp), emit


constant: Callable[[Array, int], float] = _in_kernels(_emit_constant, lambda array, i: array[i])
"""Entry i, at least 0, of a row of doubles that no kernel makes or changes.

The compiler may then read it when it is needed, or once for a whole loop. Else it reads all beforehand, as
everything that is written meanwhile might be a part of it, and keeps most of it in memory again.
"""
