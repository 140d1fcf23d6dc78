"""The decorator of every function that is compiled to machine code."""

import sys
from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar

import numba
from numba.core import event

from crawler_bench.physics.compiled.cache import cache_folder

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")

SECONDS = 10  # about how long it takes to compile what a first decision needs

config: Any = numba.config  # a module that numba fills while it is imported
njit: Any = numba.njit  # its declared type lacks an option used here


def kernel(function: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """Compile a function to machine code at its first call; keep the code on disk.

    It divides as NumPy does, and lets other threads run Python meanwhile.
    """
    return _compile(function)


def inner_kernel(function: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """Compile like `kernel` a function that makes no array: it counts no references to those it is given.

    Numba counts them, with an atomic instruction each, where it cannot prove that they do not change; in a
    loop over a few nodes that takes longer than the physics. The option is numba's own; should it go, leave
    it out. Only an inner kernel may be given an array back by an inner kernel (a view, as by `parts`): any
    other would count one reference too few, and free memory that is in use.
    """
    return _compile(function, _nrt=False, forceinline=False)


def inline_kernel(function: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """Compile like `inner_kernel` a function that becomes part of every kernel which calls it.

    For what every decision calls: passing a crawler and its coefficients takes longer than most of these do.
    """
    return _compile(function, _nrt=False, forceinline=True)


def _compile(function: Callable[Arguments, Result], **options: bool) -> Callable[Arguments, Result]:
    previous = config.CACHE_DIR
    config.CACHE_DIR = str(cache_folder())  # read once, while the decorator below chooses its cache
    try:
        compiled: Callable[Arguments, Result] = njit(
            cache=True, error_model="numpy", no_cfunc_wrapper=True, nogil=True, **options
        )(function)
    finally:
        config.CACHE_DIR = previous
    return compiled


class _Announcement(event.Listener):
    """Says once that compiling takes a while: it happens at a first call, where nobody expects it."""

    def __init__(self) -> None:
        self.is_made = False

    def on_start(self, event: Any) -> None:
        """Speak, if the first of our kernels is being compiled."""
        is_ours = event.data["dispatcher"].py_func.__module__.split(".")[0] == __name__.split(".")[0]
        if is_ours and not self.is_made:
            self.is_made = True
            print(f"compiling the physics (once, about {SECONDS} s)", file=sys.stderr, flush=True)

    def on_end(self, event: Any) -> None:
        """Nothing is to be said."""


register: Any = event.register  # it declares no types
register("numba:compile", _Announcement())
