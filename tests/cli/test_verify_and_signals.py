"""What a command does when it is told to end, and the command that checks results."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from crawler_bench.cli import verify
from crawler_bench.runs.folders.checksums import damage, seal
from tests.runs.machines.work import running

ROOT = Path(verify.__file__).parents[2]


@pytest.fixture
def results(tmp_path):
    """A results folder and a run, both sealed."""
    for name in ("results/paper", "results/runs/one"):
        folder = tmp_path / name
        folder.mkdir(parents=True)
        (folder / "claims.csv").write_text("claim\n")
        seal(folder, folder.name)
    return tmp_path / "results"


def test_a_sound_folder_is_verified(results, capsys):
    (results / "paper" / "notes.txt").write_text("mine")
    verify.verify(results)
    said = capsys.readouterr().out
    assert "2 folders are as they were written" in said
    assert "added since: notes.txt" in said


@pytest.mark.parametrize("name", ["paper", "benchmark", "readings", "search"])
def test_what_is_committed_is_as_it_was_written(name):
    assert damage(ROOT / "results" / name, name) == ""


def test_what_was_changed_is_named(results, capsys):
    (results / "runs" / "one" / "claims.csv").write_text("")
    with pytest.raises(RuntimeError, match="1 of 2 folders are not as they were written"):
        verify.verify(results)
    assert (
        f"PROBLEM {results}/runs/one/claims.csv was changed after it was written" in capsys.readouterr().out
    )
    with pytest.raises(ValueError, match="nowhere is no folder"):
        verify.verify(results.parent / "nowhere")


COMMAND = """
import sys, time
from pathlib import Path
from crawler_bench.cli.terminal.signals import ended_by_signals
from crawler_bench.runs.machines.engines import Workers
from crawler_bench.runs.machines.workplaces import engine
from tests.runs.machines.work import sleep
with ended_by_signals(), engine(Workers(2)) as run:
    list(run(sleep, [(600.0, Path(sys.argv[1]))] * 4))
"""


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_ends_all_workers_and_says_what_goes_on(tmp_path, number):
    process = subprocess.Popen(
        [sys.executable, "-c", COMMAND, str(tmp_path)], cwd=ROOT, stderr=subprocess.PIPE, text=True,
        env=os.environ | {"PYTHONPATH": str(ROOT)}, start_new_session=True,
    )  # fmt: skip
    with process:
        try:
            while len(workers := list(tmp_path.iterdir())) < 2:
                assert process.poll() is None
                time.sleep(0.02)
            os.kill(process.pid, number)
            _, said = process.communicate()
        finally:
            process.kill()
    assert process.returncode == 128 + number
    ended = f"interrupted by {number.name}; the same command goes on from the runs that are finished"
    assert said.splitlines() == [f"crawler-bench: {ended}"]
    deadline = time.monotonic() + 5
    while alive := [worker.name for worker in workers if running(worker.name)]:
        assert time.monotonic() < deadline, alive
        time.sleep(0.05)


SWALLOWING = """
import ctypes, signal, time
from crawler_bench.cli.terminal import signals
signals.PATIENCE = 0.2
with signals.ended_by_signals():
    ctypes.CFUNCTYPE(None)(lambda: signal.raise_signal(signal.SIGTERM))()
    time.sleep(60)
"""


def test_an_end_that_c_code_swallows_comes_a_little_later():
    done = subprocess.run(
        [sys.executable, "-c", SWALLOWING], cwd=ROOT, capture_output=True, text=True, timeout=50, check=False
    )
    assert done.returncode == 128 + signal.SIGTERM
    ended = "interrupted by SIGTERM; the same command goes on from the runs that are finished"
    assert done.stderr.splitlines() == [f"crawler-bench: {ended}"]
