"""One of several equal parts of a sweep, for batch systems that start the same command many times."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from crawler_bench.config.errors import ConfigError
from crawler_bench.runs.machines.engines import Workers
from crawler_bench.runs.sweep import Cell, Outcome, run_cells


@dataclass(frozen=True)
class Shard:
    """Part `number`, from 1, of `of` parts."""

    number: int
    of: int

    def __str__(self) -> str:
        """As on the command line."""
        return f"{self.number}/{self.of}"


def parse_shard(text: str) -> Shard:
    """Read "3/16".

    Raises:
        ConfigError: if there is no such part.
    """
    parts = re.fullmatch(r"([0-9]{1,6})/([0-9]{1,6})", text)
    shard = Shard(int(parts[1]), int(parts[2])) if parts else Shard(0, 0)
    if not 1 <= shard.number <= shard.of:
        raise ConfigError(f"--shard {text}: write which part of how many, 1/16 to 16/16")
    return shard


def part_of(cells: Sequence[Cell], shard: Shard) -> list[Cell]:
    """The cells of a part; those that share a training are in the same part."""
    numbers: dict[str, int] = {}
    chosen = []
    for cell in cells:
        training = f"{cell.seed} {cell.config.model_dump_json(exclude={'evaluation'})}"
        if numbers.setdefault(training, len(numbers)) % shard.of == shard.number - 1:
            chosen.append(cell)
    return chosen


def run_shard(
    cells: Sequence[Cell], shard: Shard, root: Path, *, jobs: Workers | int, quiet: bool
) -> list[Outcome]:
    """Run the cells of a part. When all parts are done, the same command without one writes the results."""
    return run_cells(part_of(cells, shard), root, jobs=jobs, quiet=quiet)
