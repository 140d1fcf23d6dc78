"""One form for whatever goes wrong: one line on standard error; exit 2 for wrong usage, 1 for failure."""

import os
import sys
from collections.abc import Callable
from typing import Any

import typer

from crawler_bench.cli.terminal.console import notes
from crawler_bench.config.errors import ConfigError, explain

FAILED, MISUSED, INTERRUPTED = 1, 2, 130  # exit codes
# What Typer raises for a wrong command line; the class itself has no public name in it.
USAGE_ERRORS: Any = (typer.BadParameter.__mro__[1], ConfigError)


def exit_code(command: Callable[[], Any]) -> int:
    """Run a command and say what a user can mend in one line; a bug keeps its traceback.

    With CRAWLER_BENCH_DEBUG set, every error keeps it.
    """
    try:
        code = int(command() or 0)
    except (KeyboardInterrupt, typer.Abort):
        code = INTERRUPTED
    except (OSError, ValueError, RuntimeError, *USAGE_ERRORS) as error:
        if os.environ.get("CRAWLER_BENCH_DEBUG"):
            raise
        wrong_usage = isinstance(error, USAGE_ERRORS)
        _complain(_usage(error) if isinstance(error, USAGE_ERRORS[0]) else explain(error))
        return MISUSED if wrong_usage else FAILED
    if code == INTERRUPTED:
        _complain("interrupted; the same command goes on from the runs that are finished")
    return code


def _usage(error: Any) -> str:
    """What is wrong with the command line, and where the right one is described."""
    said = " ".join(str(error.format_message()).split()).rstrip(".").replace("Value error, ", "")
    words = error.ctx.command_path.split() if error.ctx is not None else ["crawler-bench"]
    return f"{said[:1].lower()}{said[1:]}; see `{' '.join(['crawler-bench', *words[1:], '--help'])}`"


def _complain(message: str) -> None:
    sys.stdout.flush()
    text = f"crawler-bench: {message}"
    notes.print(text, style="red", markup=False, highlight=False, soft_wrap=True)
