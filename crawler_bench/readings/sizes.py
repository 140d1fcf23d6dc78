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
        again: how many of them are run again.
        finals: how many of those are run a third time.
        search_seeds: of the trials, of those run again, and of the finals; no other run uses them.
        names: of the readings; empty means all.
        overrides: of every run: how long it learns and how it is measured.
    """

    seeds: tuple[int, ...]
    fresh: tuple[int, ...]
    trials: int
    again: int
    finals: int
    search_seeds: tuple[tuple[int, ...], tuple[int, ...], tuple[int, ...]]
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
    trials=3000,
    again=60,
    finals=8,
    search_seeds=(tuple(range(500, 510)), tuple(range(700, 720)), tuple(range(800, 850))),
    names=(),
    overrides={"evaluation.starts": 6, "evaluation.noise": [0.0, 0.025, 0.05, 0.1, 0.2]},
)


def smoke() -> Size:
    """The smoke preset: enough to see that everything works."""
    changes = smoke_changes("readings")
    seeds, fresh = (parse_seeds(changes.pop(name)) for name in ("seeds", "fresh"))
    trials, again, finals = (changes.pop(name) for name in ("trials", "again", "finals"))
    return Size(
        seeds, fresh, trials, again, finals, (seeds, seeds, fresh), tuple(changes.pop("names")), changes
    )
