"""Compiled kernels whose on-disk cache can never be stale.

Numba's cache looks at the file of the function it compiles and not at the files of the functions which that
one calls: an edit to the friction law would go unnoticed by a cached step. So the cache lives in a folder
named after a hash of every source that can stand in a compiled call chain.
"""

import functools
import hashlib
import importlib
import math
import os
import re
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import numba
import numpy as np
import platformdirs
from llvmlite import ir
from numba.extending import intrinsic, overload
from numpy.typing import NDArray

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")

config: Any = numba.config  # a module that numba fills while it is imported
njit: Any = numba.njit  # its declared type lacks an option used here

_PACKAGE = Path(__file__).resolve().parents[1]
KEPT_VERSIONS = 8  # of the compiled code
KERNEL_SOURCES = (_PACKAGE / "physics", _PACKAGE / "envs", _PACKAGE.parent / "agents")


def source_hash(*places: Path) -> str:
    """Hash every Python file in the given files and folders.

    Args:
        places: files or folders; a folder stands for all `.py` files below it.

    Returns:
        16 hexadecimal digits that change whenever one of the sources does.
    """
    digest = hashlib.sha256()
    for place in places:
        for path in sorted(place.rglob("*.py")) if place.is_dir() else [place]:
            digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


# Taken when this process imports the sources: an edit made meanwhile must not lend its name to their results.
KERNEL_HASH = source_hash(*KERNEL_SOURCES)


@functools.cache
def cache_folder() -> Path:
    """Folder of the compiled code for the sources as they were imported.

    `CRAWLER_BENCH_CACHE` moves it; where the user's cache cannot be written, the temporary folder serves.
    """
    home = Path(os.environ.get("CRAWLER_BENCH_CACHE") or platformdirs.user_cache_dir("crawler-bench"))
    folder = home / KERNEL_HASH
    try:
        if not folder.is_dir():
            folder.mkdir(parents=True)
            _forget_old_versions(home)
        if os.access(folder, os.W_OK):
            return folder
    except OSError:
        pass
    folder = Path(tempfile.gettempdir()) / f"crawler-bench-{os.getuid()}" / KERNEL_HASH
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def _forget_old_versions(home: Path) -> None:
    """Keep the compiled code of the newest versions; a process that needs an older one compiles it again."""
    versions = [each for each in home.iterdir() if re.fullmatch("[0-9a-f]{16}", each.name) and each.is_dir()]
    for old in sorted(versions, key=lambda each: each.stat().st_mtime)[:-KEPT_VERSIONS]:
        shutil.rmtree(old, ignore_errors=True)


def kernel(function: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """Compile a function to machine code without the Python interpreter, cached on disk.

    It lets other threads run Python meanwhile.
    """
    return _compile(function, nogil=True)


def step_kernel(function: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """Compile like `kernel` a function that allocates nothing: it counts no references to its arrays.

    Numba counts them, with an atomic instruction each, where it cannot prove that they do not change. In a
    loop over steps that takes longer than the physics.

    It stays a call. Left unsaid, numba would make it part of every `inner_kernel` that calls it; and what a
    kernel seldom needs is prepared in each of its calls.
    """
    return _compile(function, _nrt=False, forceinline=False)


def inner_kernel(function: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """Compile like `step_kernel` a function that becomes part of every kernel which calls it.

    A call passes each array as seven numbers; over a few nodes that takes longer than the loop.
    """
    return _compile(function, _nrt=False, forceinline=True)


def _compile(function: Callable[Arguments, Result], **options: bool) -> Callable[Arguments, Result]:
    previous = config.CACHE_DIR
    config.CACHE_DIR = str(cache_folder())  # read once, while the decorator below chooses its cache
    try:
        compiled: Callable[Arguments, Result] = njit(
            cache=True, error_model="numpy", no_cfunc_wrapper=True, **options
        )(function)
    finally:
        config.CACHE_DIR = previous
    return compiled


def _emit_exp(typing_context: Any, x: Any) -> Any:
    def emit(context: Any, builder: Any, signature: Any, operands: Any) -> Any:
        return builder.call(builder.module.declare_intrinsic("llvm.exp", [ir.DoubleType()]), operands)

    return numba.float64(numba.float64), emit


_library_exp: Any = intrinsic(_emit_exp)


def exp(x: float) -> float:
    """The exponential function, `math.exp`.

    In kernels it is the one of the C library, which numba calls through a wrapper for old libraries; a
    crawler would pay for that several times a decision.
    """
    return math.exp(x)


@overload(exp, strict=False)
def _exp_in_kernels(x: Any) -> Any:
    return lambda x: _library_exp(x)


def shape_known(*shape: int) -> Callable[[NDArray[np.float64]], NDArray[np.float64]]:
    """A function that returns a contiguous array of doubles as it is, and whose compiler knows the shape.

    Where rows lie and how long loops are, is then not calculated in each call but compiled in. The caller
    has to see to it that the array has this shape.
    """

    def emit_known(typing_context: Any, array: Any) -> Any:
        def emit(context: Any, builder: Any, signature: Any, operands: Any) -> Any:
            arrays: Any = importlib.import_module(
                "numba.np.arrayobj"
            )  # not needed where the cache has the code
            given, known = (
                arrays.make_array(array)(context, builder, value) for value in (operands[0], None)
            )
            sizes = [context.get_constant(numba.intp, n) for n in shape]
            steps = [context.get_constant(numba.intp, 8 * math.prod(shape[n:])) for n in range(1, len(shape))]
            item = context.get_constant(numba.intp, 8)
            arrays.populate_array(
                known, data=given.data, shape=sizes, strides=[*steps, item], itemsize=item,
                meminfo=given.meminfo, parent=given.parent,
            )  # fmt: skip
            return known._getvalue()

        return array(array), emit

    def as_it_is(array: NDArray[np.float64]) -> NDArray[np.float64]:
        return array

    known: Any = intrinsic(emit_known)
    return as_it_is if config.DISABLE_JIT else known
