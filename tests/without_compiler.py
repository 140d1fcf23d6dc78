"""A pytest plugin for `make coverage`: leave out what takes too long when nothing is compiled.

The compiled half of the code can be traced only as plain Python, hundreds of times slower. A test that is not
done in SECONDS is skipped, so that those that are short enough show which lines they reach.
"""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

import numba
import pytest

SECONDS = 10


def pytest_configure() -> None:
    """Give plain functions the attribute by which a test calls what was compiled as plain Python."""
    plain = numba.njit

    def njit(**options: Any) -> Any:
        def decorate(function: Any) -> Any:
            made = plain(**options)(function)
            made.py_func = made
            return made

        return decorate

    numba.njit = njit


@contextmanager
def limit() -> Iterator[None]:
    """Skip the test if the block takes more than SECONDS."""

    def skip(number: int, frame: FrameType | None) -> None:
        pytest.skip(f"takes more than {SECONDS} s without the compiler")

    previous = signal.signal(signal.SIGALRM, skip)
    signal.alarm(SECONDS)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, previous)


@pytest.hookimpl(wrapper=True)
def pytest_pyfunc_call(pyfuncitem: pytest.Function):
    with limit():
        return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_fixture_setup(fixturedef: pytest.FixtureDef, request: pytest.FixtureRequest):
    with limit():
        return (yield)
