"""Which results folders there are to report on, and what each of them holds."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from crawler_bench.output.csv_files import read_csv

# What a kind of results is told by; anything else with a CSV is "other". In the order of the report.
WITNESSES = {
    "paper": ("claims.csv", "runs.csv", "evaluations.csv"),
    "benchmark": ("summary.csv", "pairs.csv", "policy_tables.csv"),
    "readings": ("readings.csv", "claims.csv"),
    "search": ("trials.csv", "finals.csv"),
}
OTHER = "other"
DEFAULT = Path("results")
RUNS = "runs"  # results/runs holds runs, not results


@dataclass(frozen=True)
class Folder:
    """A results folder.

    Attributes:
        path: where it is.
        kind: of its results, a key of WITNESSES or OTHER.
    """

    path: Path
    kind: str

    def frame(self, name: str) -> pd.DataFrame:
        """A CSV of the folder; without rows and columns where there is none."""
        path = self.path / f"{name}.csv"
        return read_csv(path) if path.is_file() else pd.DataFrame()


def find_folders(paths: Sequence[Path]) -> list[Folder]:
    """Results folders among these, or directly inside them, in the order of the report.

    Raises:
        FileNotFoundError: if a path is not a folder.
        ValueError: if a path holds no results.
    """
    found: dict[Path, Folder] = {}
    for path in paths:
        if not path.is_dir():
            raise FileNotFoundError(
                f"{path} is not a folder; name one that a command wrote results to, such as results/paper"
            )
        here = list(_recognize(path))
        if not here:
            raise ValueError(f"{path} holds no results; `crawler-bench reproduce` writes some")
        found |= {each.path.resolve(): each for each in here}
    order = [*WITNESSES, OTHER]
    return sorted(found.values(), key=lambda each: (order.index(each.kind), each.path))


def _recognize(path: Path) -> Iterator[Folder]:
    kind = kind_of(path)
    if kind:
        yield Folder(path, kind)
        return
    for child in sorted(path.iterdir()):
        if child.is_dir() and child.name != RUNS and not child.name.startswith(".") and kind_of(child):
            yield Folder(child, kind_of(child))


def kind_of(path: Path) -> str:
    """The kind of results in a folder; empty if it holds none."""
    for kind, names in WITNESSES.items():
        if all((path / name).is_file() for name in names):
            return kind
    return OTHER if any(path.glob("*.csv")) else ""
