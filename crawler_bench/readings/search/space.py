"""The joint space of readings that the search draws from.

Each constant is either free, and then any number in its range, or takes one of the values that have a source;
so the search can trade closeness to the paper for fewer constants of our own.
"""

from dataclasses import dataclass

import optuna

from crawler_bench.readings.catalogue import Reading
from crawler_bench.readings.fields import DERIVED_INTERVAL, NO_LIMIT, Value

DIGITS = 3  # significant ones of a free constant
FREE = "free"


@dataclass(frozen=True)
class Range:
    """What a constant may be.

    Attributes:
        low: lower end of the range of the free constant.
        high: upper end.
        step: between values; None draws on a logarithmic scale.
        sourced: values with a source that it may have instead.
    """

    low: float
    high: float
    step: float | None = None
    sourced: tuple[float, ...] = ()

    def nearest(self, value: float) -> float:
        """The value in the range that is nearest to one outside of it, or between its steps."""
        inside = min(max(value, self.low), self.high)
        return inside if self.step is None else self.low + round((inside - self.low) / self.step) * self.step


CONSTANTS = {
    "parameters.tau_f": Range(0.3, 1.6, sourced=(1.0, 0.4)),
    "parameters.neuron_rate": Range(1.0, 5.0),
    "parameters.spike_gain": Range(0.6, 3.0, sourced=(1.0,)),
    "parameters.decision_interval": Range(0.05, 1.0, step=0.05, sourced=(DERIVED_INTERVAL,)),
    "settings.initial_q": Range(0.1, 50.0),
    "environment.episode_distance": Range(0.5, 20.0),
    "environment.time_limit": Range(100.0, 4000.0, sourced=(NO_LIMIT,)),
}
CHOICES: dict[str, tuple[Value, ...]] = {
    "parameters.spike_phase": ("pi", "2pi", "every_pi"),
    "parameters.head_muscle": ("reaction", "external", "none"),
    "parameters.penalty": ("decision", "rate"),
    "parameters.decide_on": ("interval", "change"),
}


def draw(trial: optuna.Trial) -> dict[str, Value]:
    """The changes from the default reading that a trial proposes, by dotted key."""
    changes: dict[str, Value] = {key: trial.suggest_categorical(key, of) for key, of in CHOICES.items()}
    for key, of in CONSTANTS.items():
        source = trial.suggest_categorical(f"{key} from", (FREE, *of.sourced)) if of.sourced else FREE
        number = trial.suggest_float(key, of.low, of.high, step=of.step, log=of.step is None)
        changes[key] = float(f"{number:.{DIGITS}g}") if source == FREE else float(str(source))
    return changes


def proposal(reading: Reading) -> dict[str, Value]:
    """The parameters of a trial that proposes a reading; what the reading does not change is not fixed."""
    parameters: dict[str, Value] = {}
    for key, value in reading.changes.items():
        if key in CHOICES:
            parameters[key] = value
        elif key in CONSTANTS:
            of = CONSTANTS[key]
            if of.sourced:
                parameters[f"{key} from"] = value if value in of.sourced else FREE
            parameters[key] = of.nearest(float(str(value)))
    return parameters
