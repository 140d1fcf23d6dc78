"""Running the command line from tests."""

import os
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path

import pytest

from crawler_bench import cli

ROOT = Path(cli.__file__).parents[2]


def crawler_bench(*words) -> tuple[int, str, str]:
    """Run a command in this process; its exit code, standard output and standard error."""
    out, err = StringIO(), StringIO()
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(out), redirect_stderr(err):
        patch.setattr(sys, "argv", ["crawler-bench", *map(str, words)])
        patch.delenv("CRAWLER_BENCH_DEBUG", raising=False)
        with pytest.raises(SystemExit) as ended:
            cli.main()
    return int(ended.value.code or 0), out.getvalue(), err.getvalue()


def python(code: str, cwd: Path, *path: Path) -> subprocess.CompletedProcess[str]:
    """Run code in another process, with these folders before the project's on the path."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(map(str, (*path, ROOT)))}
    return subprocess.run(
        [sys.executable, "-c", code], cwd=cwd, env=environment, capture_output=True, text=True, check=False
    )


def complaint(*words) -> tuple[int, str]:
    """Exit code of a command that must fail, and the one line in which it says why."""
    code, out, err = crawler_bench(*words)
    assert out == ""
    *notes, last = err.splitlines()
    assert last.startswith("crawler-bench: ")
    assert not [line for line in notes if line.startswith((" ", "crawler-bench: ", "Traceback"))], err
    return code, last
