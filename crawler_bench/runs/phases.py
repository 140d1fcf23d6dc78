"""How a part of long work says how far it is: the command line shows a bar, a test or a script nothing."""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager

# Name of the part, how much there is to do, and of what; gives a function that takes how much is done.
Phase = Callable[[str, float, str], AbstractContextManager[Callable[[float], None]]]


@contextmanager
def unseen(name: str, total: float, unit: str) -> Iterator[Callable[[float], None]]:
    """Show nothing."""
    yield lambda done: None
