"""Every reading that is tried: what it changes in the default, and why.

A reading is a value for every field of `crawler_bench.readings.fields`. The literal reading takes the
equations as they are printed; the repairs lead from there to the default, one change after another.
"""

import itertools
from collections.abc import Mapping
from dataclasses import dataclass

from crawler_bench.config.errors import ConfigError, nearest
from crawler_bench.config.schema import EnvironmentConfig, RunConfig, override, to_mapping
from crawler_bench.readings.fields import (
    FIELDS,
    GIVEN,
    PRINTED_STEP,
    REGULARIZATION,
    Field,
    Value,
    word,
)


@dataclass(frozen=True)
class Reading:
    """The default with some values changed.

    Attributes:
        name: of the reading, unique.
        family: why it is tried.
        changes: dotted key: value.
    """

    name: str
    family: str
    changes: Mapping[str, Value]

    @property
    def is_open(self) -> bool:
        """Whether it varies what the paper leaves open, and not what the paper gives."""
        return self.family != "given"

    def configure(self, base: RunConfig) -> RunConfig:
        """A run of this reading.

        Args:
            base: the run of the default reading; a changed epsilon applies to the regularized gait alone.
        """
        learns = bool(base.settings)
        kept = {key: value for key, value in self.changes.items() if learns or key.startswith("parameters.")}
        if base.environment.regularization == 0:
            kept.pop(REGULARIZATION, None)
        if not learns:  # without learning the task does not matter: readings that share a body share its run
            base = base.model_copy(update={"environment": EnvironmentConfig(regularization=0)})
        return override(base, kept, self.name)

    def free_constants(self, base: RunConfig) -> tuple[str, ...]:
        """Names of the fields whose value has no source."""
        values = values_of(self.configure(base))
        exact = values["parameters.integrator"] == "exact"
        return tuple(
            field.name
            for field in (*FIELDS, *GIVEN)
            if not field.is_sourced(values[field.key]) and not (field.name == "dt" and exact)
        )


def values_of(run: RunConfig) -> dict[str, Value]:
    """Every value of a run by dotted key."""
    content = to_mapping(run)
    flat = {"settings.end_is_terminal": False, "decisions": content["decisions"]}
    for section in ("parameters", "environment", "settings"):
        flat |= {f"{section}.{name}": value for name, value in content[section].items()}
    return flat


def _name(changes: Mapping[str, Value]) -> str:
    hidden = ("parameters.integrator", "decisions")
    return ",".join(f"{key.rpartition('.')[2]}={word(changes[key])}" for key in changes if key not in hidden)


def _reading(family: str, changes: Mapping[str, Value], suffix: str = "") -> Reading:
    return Reading(_name(changes) + suffix, family, dict(changes))


def _alone(field: Field, value: Value) -> dict[str, Value]:
    steps = {"parameters.integrator": "step"} if field.name == "dt" else {}
    return {field.key: value} | steps


# As the equations are printed, where the text or a table contradicts them.
LITERAL = {
    "parameters.friction_law": "literal",
    "parameters.observation": "most_stretched",
    "parameters.spike_phase": "pi",
    "parameters.neuron_rate": 1.0,
    "parameters.decision_interval": PRINTED_STEP,
    "parameters.tau_f": 1.0,
}
SAME_TIME = 16_000_000  # decisions of PRINTED_STEP take about as long as 800,000 of the default's
DEFAULT = Reading("default", "default", {})
# The default until November 2026, in which random action is faster than the gait that is learned.
FORMER = Reading(
    "former-default",
    "former",
    {
        "parameters.head_muscle": "reaction",
        "parameters.tau_f": 0.7,
        "parameters.neuron_rate": 2.0,
        "parameters.spike_gain": 2.0,
        "parameters.spike_phase": "pi",
        "parameters.decision_interval": 0.2,
        "settings.initial_q": 0.2,
        "environment.episode_distance": 2.0,
        "environment.time_limit": 1000.0,
    },
)


def _repairs() -> list[Reading]:
    """From the literal reading to the default, one change after another."""
    left = dict(LITERAL)
    steps = [Reading("literal", "literal", dict(left))]
    for number, key in enumerate(list(left)[:-2], 1):  # without the last two it is `tau_f=1`
        del left[key]
        steps.append(Reading(f"literal-repaired-{number}-{key.rpartition('.')[2]}", "repairs", dict(left)))
    return steps


def _sourced() -> list[Reading]:
    """No free constant but the two of every reading: the words where they contradict an equation."""
    printed = {key: LITERAL[key] for key in ("parameters.neuron_rate", "parameters.decision_interval")}
    return [
        Reading(
            f"sourced,tau_f={tau_f:g},{phase}",
            "sourced",
            {**printed, "parameters.tau_f": tau_f, "parameters.spike_phase": phase},
        )
        for tau_f, phase in itertools.product((1.0, 0.4), ("pi", "2pi", "every_pi"))
        if (tau_f, phase) not in ((1.0, "pi"), (1.0, "every_pi"))  # two repairs of the literal reading
    ]


def _pairs() -> list[Reading]:
    """The former default with another split of a muscle's strength, or other values known to work."""
    rate, gain, tau_f = "parameters.neuron_rate", "parameters.spike_gain", "parameters.tau_f"
    held, phase = "parameters.decision_interval", "parameters.spike_phase"
    split: list[dict[str, Value]] = [
        {rate: r, gain: g} for r, g in ((1.0, 4.0), (1.5, 2.65), (2.5, 1.6), (3.0, 1.35), (4.0, 1.0))
    ]
    near: list[dict[str, Value]] = [
        {rate: 1.5, gain: 3.0},
        {rate: 2.0, gain: 2.2},
        {rate: 2.5, gain: 1.5},
        {rate: 3.0, gain: 1.2, held: 0.3},
        {rate: 3.0, gain: 1.3, held: 0.3},
        {rate: 3.0, gain: 1.3, held: 0.3, tau_f: 0.4},
        {rate: 3.0, gain: 1.3, held: 0.1},
        {rate: 1.0, gain: 3.15, tau_f: 0.4, phase: "2pi"},
    ]
    return [Reading(f"former,{_name(each)}", "pairs", {**FORMER.changes, **each}) for each in (*split, *near)]


def _sparse() -> list[Reading]:
    """One fitted constant of the body at a time, and others with which the search did well."""
    rate, gain, tau_f = "parameters.neuron_rate", "parameters.spike_gain", "parameters.tau_f"
    at_pi = {"parameters.spike_phase": "pi"}
    changes: list[dict[str, Value]] = [{tau_f: 1.0, rate: value} for value in (1.7, 1.8, 1.9)]
    changes += [{**at_pi, tau_f: sourced, rate: value} for sourced in (1.0, 0.4) for value in (3.0, 4.0)]
    changes += [{tau_f: sourced, rate: 1.0, gain: value} for sourced in (1.0, 0.4) for value in (1.5, 2.0)]
    near = {"settings.initial_q": 5.86, "environment.episode_distance": 5.97}
    changes.append({**at_pi, tau_f: 0.696, rate: 2.46, gain: 1.53, **near})
    return [_reading("sparse", each) for each in changes]


def one_at_a_time() -> tuple[Reading, ...]:
    """Every open field alone, over its values; the printed time step also over the same time."""
    alone = [_reading("alone", _alone(field, value)) for field in FIELDS for value in field.tried]
    longer = {"parameters.decision_interval": PRINTED_STEP, "decisions": SAME_TIME}
    return (*alone, _reading("alone", longer, ",same-time"))


def readings() -> tuple[Reading, ...]:
    """Every reading but those of the search, the default first."""
    given = [_reading("given", _alone(field, value)) for field in GIVEN for value in field.tried]
    return (DEFAULT, FORMER, *_pairs(), *_sparse(), *one_at_a_time(), *given, *_sourced(), *_repairs())


def find_reading(name: str, among: tuple[Reading, ...]) -> Reading:
    """The reading of a name.

    Raises:
        ConfigError: if there is none, suggesting the nearest.
    """
    for reading in among:
        if reading.name == name:
            return reading
    raise ConfigError(f"no reading is called {name!r}{nearest(name, [each.name for each in among])}")
