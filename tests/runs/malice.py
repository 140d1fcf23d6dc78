"""Payloads that would leave a marker if anything of them were run."""

import json
import shutil
import zipfile
from pathlib import Path

from stable_baselines3.common.save_util import data_to_json

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
