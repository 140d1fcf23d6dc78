"""Payloads that would leave a marker if anything of them were run."""

import json
import shutil
import time
import zipfile
from pathlib import Path

from stable_baselines3.common.save_util import data_to_json

from crawler_bench.config.schema import RunConfig, override
from crawler_bench.runs import store
from crawler_bench.runs.folders import checksums

SHORT = {
    "starts": 1,
    "warm_up": 1,
    "duration": 2,
    "settle": 1,
    "gait": 2,
    "evaluation.noise": [0],
    "decisions": 64,
}

EVIL = """
from pathlib import Path
Path({marker!r}).write_text("run")
from agents.reference import Random as Evil
"""


class Payload:
    """A pickle of it writes a file."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self):
        """What unpickling calls."""
        return Path.write_text, (self.path, "run")


def poison(path: Path, marker: Path) -> None:
    """Put a pickle into the settings of a saved agent of Stable-Baselines3."""
    poisoned = path.with_name("poisoned.zip")
    with zipfile.ZipFile(path) as old, zipfile.ZipFile(poisoned, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            if name == "data":
                data = json.loads(content) | json.loads(data_to_json({"evil": Payload(marker)}))
                content = json.dumps(data).encode()
            new.writestr(name, content)
    shutil.move(poisoned, path)


def run_of(agent: str, folder: Path, **changes) -> Path:
    """A sealed run folder of an agent that nobody has trained."""
    folder.mkdir()
    store.write_config(folder, override(RunConfig(), {"agent": agent} | SHORT | changes, "test"), 0)
    (folder / "learning.csv").write_text("decisions,gradient_updates,time,distance,policy\n")
    (folder / "agent.json").write_text("{}")
    store.write_manifest(folder, time.monotonic())
    checksums.seal(folder, folder.name)
    return folder


def results_of(folder: Path, agent: str, entry: str) -> Path:
    """A results folder with one run of an agent, and its entry."""
    (folder / "entries").mkdir(parents=True)
    run = {
        "agent": agent,
        "mode": "deterministic",
        "regularization": 0.0,
        "seed": 0,
        "hash": "ab",
        "run": "r",
    }
    header, row = ",".join(run), ",".join(f'"{value}"' for value in run.values())
    for name in ("runs", "evaluations", "curves", "summary"):
        (folder / f"{name}.csv").write_text(f"{header}\n{row if name == 'runs' else ''}\n")
    (folder / "entries" / f"{Path(agent).name}.yaml").write_text(entry)
    return folder
