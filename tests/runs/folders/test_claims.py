"""Claims end with their owners; only then is what they were writing swept."""

import subprocess
import sys
from pathlib import Path

import pytest

from crawler_bench.runs import store
from crawler_bench.runs.folders import claims

HOLD = """
import sys
from pathlib import Path
from crawler_bench.runs.folders import claims
folder = Path(sys.argv[1])
with claims.claim(folder):
    draft = folder.with_name(".partial-run-abcd1234")
    draft.mkdir()
    (draft / "file").write_text("half")
    print(draft.name, flush=True)
    input()
    draft.rename(folder)
"""


@pytest.fixture
def writer(tmp_path):
    """Another process in the middle of writing `run`."""
    process = subprocess.Popen(
        [sys.executable, "-c", HOLD, str(tmp_path / "run")],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=Path(store.__file__).parents[2],
    )  # fmt: skip
    assert process.stdout is not None
    assert process.stdin is not None
    assert process.stdout.readline().startswith(".partial-run-")
    with process:
        yield process
        process.kill()


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def test_what_a_living_process_writes_is_left_alone_however_old(tmp_path, writer):
    before = names(tmp_path)
    claims.sweep(tmp_path)
    assert names(tmp_path) == before
    with pytest.raises(claims.Busy), claims.claim(tmp_path / "run", wait=False):
        pass
    writer.communicate("\n")
    assert (tmp_path / "run" / "file").read_text() == "half"
    assert names(tmp_path) == {"run"}


def test_what_a_dead_process_left_is_swept_at_once(tmp_path, writer):
    writer.kill()
    writer.wait()
    assert len(names(tmp_path)) == 2  # a draft and a claim
    claims.sweep(tmp_path, "another")
    assert len(names(tmp_path)) == 2
    claims.sweep(tmp_path)
    assert not names(tmp_path)
    claims.sweep(tmp_path / "nowhere")


def test_a_claim_waits_for_its_owner(tmp_path, writer):
    writer.stdin.write("\n")
    writer.stdin.flush()
    with claims.claim(tmp_path / "run"):
        assert (tmp_path / "run" / "file").is_file()


def test_writing_results_sweeps_what_was_left_of_them(tmp_path, writer):
    writer.kill()
    writer.wait()
    with store.replace(tmp_path / "run") as draft:
        (draft / "file").write_text("whole")
    assert names(tmp_path) == {"run"}


def test_a_folder_that_was_cut_off_in_mid_exchange_comes_back(tmp_path):
    with store.replace(tmp_path / "run") as draft:
        (draft / "file").write_text("old")
    (tmp_path / "run").rename(tmp_path / ".partial-run-old-abcd1234")
    claims.sweep(tmp_path)
    assert (tmp_path / "run" / "file").read_text() == "old"
    assert names(tmp_path) == {"run"}


def test_files_of_others_are_not_touched(tmp_path):
    for name in (".partial-mine", ".something.lock", ".claims"):
        (tmp_path / name).write_text("")
    claims.sweep(tmp_path)
    assert names(tmp_path) == {".partial-mine", ".something.lock", ".claims"}
