"""joblib's processes and Dask's workers do the same, also where one dies."""

import _thread
import importlib.util
import os
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from crawler_bench.config.schema import ConfigError
from crawler_bench.runs.machines.engines import Lost, Workers, as_workers
from crawler_bench.runs.machines.workplaces import engine
from tests.runs.machines.work import running, sleep, square

ROOT = Path(__file__).parents[3]
HAS_DASK = importlib.util.find_spec("distributed") is not None
PLACES = ["", pytest.param("dask", marks=pytest.mark.skipif(not HAS_DASK, reason="Dask is an extra"))]


@pytest.mark.parametrize("on", PLACES)
def test_a_worker_that_dies_costs_its_task_a_second_try(on, tmp_path):
    tasks = [(number, tmp_path) for number in (*range(8), -1, 8, 9)]
    with engine(Workers(2, on)) as run:
        found = list(run(square, tasks))
    lost = [each for each in found if isinstance(each, Lost)]
    assert sorted(each for each in found if not isinstance(each, Lost)) == [n**2 for n in range(10)]
    assert [each.task for each in lost] == [(-1, tmp_path)]
    assert "died" in lost[0].reason


@pytest.mark.parametrize("on", PLACES)
def test_whatever_ends_the_work_ends_the_workers(on, tmp_path):
    def interrupt():
        while len(list(tmp_path.iterdir())) < (2 if time.monotonic() < started + 30 else 1):
            time.sleep(0.01)  # until both are asleep, if joblib still has both
        _thread.interrupt_main()

    started = time.monotonic()
    threading.Thread(target=interrupt, daemon=True).start()
    with pytest.raises(KeyboardInterrupt), engine(Workers(2, on)) as run:
        list(run(sleep, [(600.0, tmp_path)] * 4))
    assert time.monotonic() - started < 300
    assert not [each.name for each in tmp_path.iterdir() if running(each.name)]


def test_places_that_there_are_not():
    assert as_workers(3) == Workers(3)
    assert Workers(3).processes == 3
    assert Workers().processes == os.cpu_count()
    for on in ("dusk", "tcp:/host", "slurm2"):
        with pytest.raises(ConfigError, match="dask, slurm, kubernetes or a scheduler's address"):
            Workers(on=on)


@pytest.mark.skipif(not HAS_DASK, reason="Dask is an extra")
def test_a_cluster_that_cannot_be_had_is_said_in_one_line(monkeypatch):
    from crawler_bench.runs.machines import cluster

    cases = [
        (Workers(1, "tcp://127.0.0.1:9"), "no scheduler answers there"),
        (Workers(1, "kubernetes"), "pip install dask-kubernetes"),
        (Workers(0, "slurm"), "say with --jobs how many workers"),
    ]
    monkeypatch.setattr(cluster, "CONNECT", "1s")
    for workers, said in cases:
        with pytest.raises(ConfigError, match=said) as caught, engine(workers):
            pass
        assert "\n" not in str(caught.value)


@pytest.mark.slow
@pytest.mark.skipif(not HAS_DASK, reason="Dask is an extra")
def test_a_scheduler_that_dies_is_said_in_one_line_and_the_same_call_goes_on(tmp_path, capfd):
    """Workers started by hand, as on machines of one's own."""
    code = (
        "import time; from distributed import LocalCluster\n"
        "if __name__ == '__main__':\n"
        "    cluster = LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)\n"
        "    print(cluster.scheduler_address, flush=True); time.sleep(600)"
    )
    (tmp_path / "cluster.py").write_text(code)
    trace = tmp_path / "trace"
    trace.mkdir()
    with subprocess.Popen(
        [sys.executable, str(tmp_path / "cluster.py")], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
        text=True, env=os.environ | {"PYTHONPATH": str(ROOT)},
    ) as process:  # fmt: skip
        try:
            address = process.stdout.readline().strip()
            capfd.readouterr()
            with engine(Workers(2, address)) as run:
                results = run(sleep, [(0.2, trace)] * 200)
                next(results)
                process.kill()
                with pytest.raises(RuntimeError, match="scheduler is gone; the same command goes on"):
                    list(results)
            assert capfd.readouterr().err == ""
        finally:
            process.kill()
