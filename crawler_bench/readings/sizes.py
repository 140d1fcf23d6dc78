"""Sizes of the study of the readings."""

from dataclasses import dataclass

from crawler_bench.config.schema import RunConfig, override
from crawler_bench.readings.catalogue import Reading, readings

SMOKE_READINGS = ("default", "literal", "tau_f=1", "regularization=0.05")


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
        learns = base.decisions > 0
        kept = {key: value for key, value in self.overrides.items() if learns or key != "decisions"}
        return override(base, kept, "the preset")

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
SMOKE = Size(
    seeds=(0, 1),
    fresh=(100, 101),
    trials=4,
    names=SMOKE_READINGS,
    overrides={
        "decisions": 20_000,
        "evaluation.starts": 2,
        "evaluation.warm_up": 50.0,
        "evaluation.duration": 200.0,
        "evaluation.settle": 100.0,
        "evaluation.gait": 150.0,
        "evaluation.noise": [0.0, 0.025, 0.2],
    },
)
