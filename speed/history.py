"""What was measured, commit by commit: two CSV files that are only ever appended to.

`commits.csv` has one row per commit measured: when, on which processor, with which versions.
`measurements.csv` has one row per commit and measurement. `date` joins them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import pandas as pd

from speed.measure import Measurement

PACKAGES = ("numpy", "numba", "gymnasium", "stable-baselines3", "torch")
COMMIT_COLUMNS = ["date", "commit", "dirty", "cpu", "cores", "wall_clock_seconds", "python", *PACKAGES]
COLUMNS = ["date", "commit", *(field.name for field in fields(Measurement))]


class History:
    """The two files of a folder.

    Args:
        folder: where they are, or will be.
    """

    def __init__(self, folder: Path) -> None:
        self._commits, self._measurements = folder / "commits.csv", folder / "measurements.csv"

    def append(self, manifest: Mapping[str, Any], measured: Sequence[Measurement]) -> None:
        """Add what was measured at one commit; what stands in the files stays byte for byte.

        Args:
            manifest: content of the `manifest.json` of these measurements.
            measured: the measurements.
        """
        git = manifest["git"] or {"commit": "", "dirty": True}
        key = {"date": manifest["finished"], "commit": git["commit"][:10]}
        facts = {"dirty": git["dirty"], **manifest["machine"], **manifest["packages"]}
        row = key | facts | {name: manifest[name] for name in ("python", "wall_clock_seconds")}
        _append(pd.DataFrame([row], columns=COMMIT_COLUMNS), self._commits)
        rows = [key | asdict(each) for each in measured]
        _append(pd.DataFrame(rows, columns=COLUMNS).astype({"size": "Int64"}), self._measurements)

    def commits(self) -> pd.DataFrame:
        """One row per commit measured, oldest first."""
        return pd.read_csv(self._commits, dtype={"commit": str})

    def measurements(self) -> pd.DataFrame:
        """One row per commit and measurement, oldest commit first."""
        return pd.read_csv(self._measurements, dtype={"commit": str})

    def latest(self) -> pd.DataFrame:
        """The measurements of the commit measured last."""
        measured = self.measurements()
        return measured.set_index("date", drop=False).loc[[measured["date"].iloc[-1]]].reset_index(drop=True)


def _append(rows: pd.DataFrame, path: Path) -> None:
    there = path.is_file()
    if there and list(pd.read_csv(path, nrows=0).columns) != list(rows.columns):
        raise ValueError(f"{path} has other columns than {', '.join(rows.columns)}")
    rows.to_csv(path, mode="a", header=not there, index=False, float_format="%.9g")
