"""What a command does when it is told to end: its workers end at once, and it says so."""

import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
PATIENCE = 4.0  # seconds to end in order; then the process ends without


class _Ended(BaseException):
    """Raised in the middle of whatever is being done; nothing but the end of the command catches it."""


@contextmanager
def ended_by_signals() -> Iterator[None]:
    """Within the block, in the main thread, a signal ends all workers and exits with 128 + its number."""
    received = signal.SIGTERM

    def end(number: int, _frame: FrameType | None) -> None:
        nonlocal received
        received = signal.Signals(number)
        for each in SIGNALS:
            signal.signal(each, signal.SIG_IGN)
        sys.unraisablehook = _say_unless_ended
        timer = threading.Timer(PATIENCE, _end_now, (received,))
        timer.daemon = True
        timer.start()
        raise _Ended

    in_main = threading.current_thread() is threading.main_thread()
    before = {each: signal.getsignal(each) for each in SIGNALS} if in_main else {}
    for each, handler in before.items():
        if handler is not signal.SIG_IGN:  # as nohup wants it
            signal.signal(each, end)
    try:
        yield
    except _Ended:
        _say(received)
        sys.exit(128 + received)
    finally:
        for each, handler in before.items():
            signal.signal(each, handler)


def _say(received: signal.Signals) -> None:
    text = f"interrupted by {received.name}; the same command goes on from the runs that are finished"
    print(f"crawler-bench: {text}", file=sys.stderr, flush=True)


def _say_unless_ended(unraisable: Any) -> None:
    """Python prints what C code that calls it cannot pass on; of the end of a command it must not."""
    if not isinstance(unraisable.exc_value, _Ended):
        sys.__unraisablehook__(unraisable)


def _end_now(received: signal.Signals) -> None:
    """End without order, as where C code, such as the compiler's, has swallowed the end."""
    from crawler_bench.runs.machines.engines import end_workers

    end_workers()
    _say(received)
    os._exit(128 + received)
