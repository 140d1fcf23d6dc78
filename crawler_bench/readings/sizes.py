"""Sizes of the study of the readings."""

from dataclasses import dataclass

from crawler_bench.config.files import smoke_changes
from crawler_bench.config.schema import Experiment, RunConfig, parse_seeds, resize
from crawler_bench.readings.catalogue import Reading, readings


@dataclass(frozen=True)
class Size:
    """How much is run.

    Attributes:
        seeds: of every reading.
        fresh: seeds of the confirmation, which nothing was chosen by.
        trials: of the search.
        names: of the readings; empty means all.
        overrides: of every run: how long it learns and how it is measured.
    """

    seeds: tuple[int, ...]
    fresh: tuple[int, ...]
    trials: int
    names: tuple[str, ...]
    overrides: dict[str, object]

    def apply(self, base: RunConfig) -> RunConfig:
        """The run of this size; what never learns takes no decisions."""
        return resize(Experiment(name="base", run=base), self.overrides, "the preset").run

    def readings(self) -> tuple[Reading, ...]:
        """The readings to run."""
        return tuple(each for each in readings() if not self.names or each.name in self.names)


FULL = Size(
    seeds=tuple(range(5)),
    fresh=tuple(range(100, 110)),
    trials=32,
    names=(),
    overrides={"evaluation.starts": 6, "evaluation.noise": [0.0, 0.025, 0.05, 0.1, 0.2]},
)


def smoke() -> Size:
    """The smoke preset: enough to see that everything works."""
    changes = smoke_changes("readings")
    seeds, fresh = (parse_seeds(changes.pop(name)) for name in ("seeds", "fresh"))
    return Size(seeds, fresh, changes.pop("trials"), tuple(changes.pop("names")), changes)
