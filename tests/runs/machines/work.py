"""What the tests let workers do."""

import os
import signal
import time
from pathlib import Path


def square(number: int, trace: Path) -> int:
    """The square; a negative number kills its worker, always, and 3 does so once."""
    if number < 0 or (number == 3 and not (trace / "died").exists()):
        (trace / "died").write_text("")
        os.kill(os.getpid(), signal.SIGKILL)
    return number**2


def sleep(seconds: float, trace: Path) -> None:
    """Leave a trace of this process, and sleep."""
    (trace / str(os.getpid())).write_text("")
    time.sleep(seconds)


def running(number: str) -> bool:
    """Whether a process of this number is there, and not only waits to be noticed as dead."""
    try:
        state = Path(f"/proc/{int(number)}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return False
    return state != "Z"
