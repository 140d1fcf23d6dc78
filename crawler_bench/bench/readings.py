"""What the paper leaves open, as data: every field with the words it interprets, and every reading that is tried.

A reading is the default with some values changed. A value is *sourced* when the paper, or a paper that it builds
on, prints it or names it; every other value is a free constant, *fitted* or chosen by us, and counts against the
reading that uses it.
"""

import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from crawler_bench.config import EnvironmentConfig, RunConfig, nearest, override, to_mapping

REGULARIZATION = "environment.regularization"
NO_LIMIT = 1e9  # tau: a time limit that is never met
PRINTED_STEP = 0.01  # tau, Delta t of Table S1

Value = Any  # a number, a word or a truth value: what YAML holds


@dataclass(frozen=True)
class Field:
    """One thing that the paper leaves open, or that it might not depend on.

    Attributes:
        key: dotted key of a run's configuration.
        words: the paper's words that a value interprets.
        sourced: values that have a source, with it.
        tried: values tried alone, beside the default's.
        continuous: whether the joint search varies it.
    """

    key: str
    words: str
    sourced: Mapping[Value, str]
    tried: tuple[Value, ...]
    continuous: bool = False

    @property
    def name(self) -> str:
        """Its short name."""
        return self.key.rpartition(".")[2]

    def is_sourced(self, value: Value) -> bool:
        """Whether a value has a source."""
        return value in self.sourced


# In the order of the paper. The words are quotations; sources are equations, tables and papers.
FIELDS = (
    Field("parameters.friction_law", '"scaled backward frictional force 9, friction anisotropy 30" (Table S1) against eq. 8',
          {"table": "Table S1", "literal": "eq. 8"}, ("literal",)),
    Field("parameters.head_muscle", '"+ f_0 - f_1 = f_0^f" at the head (eq. 2), no f_0 at node 1 (eq. 1)',
          {"reaction": "eq. 2 with [P16]", "external": "eq. 1 and 2", "none": "Fig. 1A"}, ("external", "none")),
    Field("parameters.spike_phase", '"crosses a multiple of 2 pi" against mod(theta - pi, 2 pi) = 0 (eq. 7)',
          {"pi": "eq. 7", "2pi": "text before eq. 7"}, ("2pi",)),
    Field("parameters.observation", '"most strongly contracted" against argmin (u_i - u_(i-1)) (eq. 9)',
          {"most_contracted": "text before eq. 9", "most_stretched": "eq. 9"}, ("most_stretched",)),
    Field("parameters.tau_f", '"the ratio of timescales for muscular and neuronal activity": named (eq. 4), not given',
          {1.0: "Table S1, if its muscular timescale is tau_f", 0.4: "[P16, Table 1]"},
          (0.2, 0.4, 0.55, 0.85, 1.0, 1.5), continuous=True),
    Field("parameters.tau_m", '"scaled muscular timescale 1" (Table S1)', {1.0: "Table S1"}, (0.5, 0.75, 1.5, 2.0)),
    Field("parameters.neuron_rate", '"tau_theta dtheta/dt = 1 - cos theta + ..." (eq. 6): no factor is printed',
          {1.0: "eq. 6"}, (1.0, 1.5, 2.5, 3.0, 4.0), continuous=True),
    Field("parameters.spike_gain", '"F = sum exp(-(t - t_s) / tau_m)" (eq. 5): no factor is printed',
          {1.0: "eq. 5"}, (1.0, 1.5, 1.75, 2.25, 2.5, 3.0, 4.0), continuous=True),
    Field("parameters.decision_interval", '"Delta t is the size of the discrete time step (Table S1)": 0.01',
          {PRINTED_STEP: "Table S1"}, (PRINTED_STEP, 0.05, 0.1, 0.3, 0.4, 0.5, 1.0), continuous=True),
    Field("parameters.dt", '"scaled discrete timestep 0.01" (Table S1), in implicit Euler steps instead of exactly',
          {PRINTED_STEP: "Table S1"}, (0.005, PRINTED_STEP, 0.02, 0.05)),
    Field("settings.initial_q", '"a Q-matrix of values that are uniform and high"', {},
          (0.02, 0.05, 0.1, 0.4, 1.0, 2.0), continuous=True),
    Field("environment.episode_distance", '"each episode corresponds to the crawler moving a fixed distance forward"',
          {}, (0.5, 1.0, 5.0, 10.0), continuous=True),
    Field("environment.time_limit", "no time limit is named", {NO_LIMIT: "not in the paper"},
          (250.0, 500.0, 2000.0, NO_LIMIT), continuous=True),
    Field("settings.end_is_terminal", '"after which it is reset"; eq. 12 makes no exception at the end of an episode',
          {False: "eq. 12", True: "the textbook that the paper cites"}, (True,)),
)  # fmt: skip

# What the paper does give: whether its conclusion depends on it is another question than what it is.
GIVEN = (
    Field("settings.learning_rate", '"most reasonable choices for these will converge"', {0.05: "Formulation"},
          (0.01, 0.02, 0.1, 0.2)),
    Field("settings.discount", '"most reasonable choices for these will converge"', {0.95: "Formulation"},
          (0.8, 0.9, 0.98, 0.99)),
    Field("parameters.n_segments", '"which has 10 segments"', {10: "Fig. 1"}, (6, 8, 12, 16, 20)),
    Field(REGULARIZATION, '"the regularization parameter epsilon = 0.01"', {0.01: "Results"},
          (0.0005, 0.001, 0.002, 0.005, 0.02, 0.05, 0.1)),
)  # fmt: skip


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

    def configure(self, base: RunConfig) -> RunConfig:
        """A run of this reading.

        Args:
            base: the run of the default reading. A changed epsilon is the regularized gait's alone.
        """
        learns = bool(base.settings)
        kept = {key: value for key, value in self.changes.items() if learns or key.startswith("parameters.")}
        if base.environment.regularization == 0:
            kept.pop(REGULARIZATION, None)
        if not learns:  # a policy that never learns knows no task: readings that share a body share its run
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


def word(value: Value) -> str:
    """A value in short."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int | float):
        return "none" if value == NO_LIMIT else f"{value:g}"
    return str(value)


def _name(changes: Mapping[str, Value]) -> str:
    hidden = ("parameters.integrator", "decisions")
    return ",".join(f"{key.rpartition('.')[2]}={word(changes[key])}" for key in changes if key not in hidden)


def _reading(family: str, changes: Mapping[str, Value], suffix: str = "") -> Reading:
    return Reading(_name(changes) + suffix, family, dict(changes))


def _alone(field: Field, value: Value) -> dict[str, Value]:
    steps = {"parameters.integrator": "step"} if field.name == "dt" else {}
    return {field.key: value} | steps


# As printed, equation by equation, where the text or a table says otherwise.
LITERAL = {
    "parameters.friction_law": "literal",
    "parameters.observation": "most_stretched",
    "parameters.head_muscle": "external",
    "parameters.neuron_rate": 1.0,
    "parameters.spike_gain": 1.0,
    "parameters.decision_interval": PRINTED_STEP,
    "environment.time_limit": NO_LIMIT,
    "parameters.tau_f": 1.0,
}
SAME_TIME = 16_000_000  # decisions of PRINTED_STEP in the time of 800,000 of the default's
DEFAULT = Reading("default", "default", {})


def _repairs() -> list[Reading]:
    """From the literal reading to the default, one change after another."""
    left = dict(LITERAL)
    steps = [Reading("literal", "literal", dict(left))]
    for number, key in enumerate(list(left)[:-1], 1):
        del left[key]
        steps.append(Reading(f"literal-repaired-{number}-{key.rpartition('.')[2]}", "repairs", dict(left)))
    return steps


def _sourced() -> list[Reading]:
    """No free constant but the two that every reading has: words where they contradict an equation."""
    printed = {key: LITERAL[key] for key in LITERAL if key not in list(LITERAL)[:3] and "tau_f" not in key}
    return [
        Reading(
            f"sourced,tau_f={tau_f:g},{phase}",
            "sourced",
            {**printed, "parameters.tau_f": tau_f, "parameters.spike_phase": phase},
        )
        for tau_f, phase in itertools.product((1.0, 0.4), ("pi", "2pi"))
    ]


def _pairs() -> list[Reading]:
    """How the strength of a muscle is split between neuron_rate and spike_gain, and readings known to work."""
    rate, gain, tau_f = "parameters.neuron_rate", "parameters.spike_gain", "parameters.tau_f"
    held, phase = "parameters.decision_interval", "parameters.spike_phase"
    split = [{rate: r, gain: g} for r, g in ((1.0, 4.0), (1.5, 2.65), (2.5, 1.6), (3.0, 1.35), (4.0, 1.0))]
    near = [
        {rate: 1.5, gain: 3.0},
        {rate: 2.0, gain: 2.2},
        {rate: 2.5, gain: 1.5},
        {rate: 3.0, gain: 1.2, held: 0.3},
        {rate: 3.0, gain: 1.3, held: 0.3},
        {rate: 3.0, gain: 1.3, held: 0.3, tau_f: 0.4},
        {rate: 3.0, gain: 1.3, held: 0.1},
        {rate: 1.0, gain: 3.15, tau_f: 0.4, phase: "2pi"},
    ]
    return [_reading("pairs", changes) for changes in split + near]


def _sparse() -> list[Reading]:
    """One fitted constant of the body at a time, the other as printed, tau_f from a source."""
    rate, gain, tau_f = "parameters.neuron_rate", "parameters.spike_gain", "parameters.tau_f"
    changes: list[dict[str, Value]] = []
    for sourced in (1.0, 0.4):
        changes += [{tau_f: sourced, gain: 1.0, rate: value} for value in (3.0, 4.0, 5.0, 6.0)]
        changes += [{tau_f: sourced, rate: 1.0, gain: value} for value in (3.0, 4.0, 5.0, 6.0)]
    return [_reading("sparse", each) for each in changes]


def one_at_a_time() -> tuple[Reading, ...]:
    """Every field of what is open, alone over its values; the printed time step also for as long a time."""
    alone = [_reading("alone", _alone(field, value)) for field in FIELDS for value in field.tried]
    longer = {"parameters.decision_interval": PRINTED_STEP, "decisions": SAME_TIME}
    return (*alone, _reading("alone", longer, ",same-time"))


def readings() -> tuple[Reading, ...]:
    """Every reading that is tried beside those of the search, the default first."""
    given = [_reading("given", _alone(field, value)) for field in GIVEN for value in field.tried]
    return (DEFAULT, *_repairs(), *_sourced(), *one_at_a_time(), *_pairs(), *_sparse(), *given)


def find_reading(name: str, among: tuple[Reading, ...]) -> Reading:
    """The reading of a name.

    Raises:
        ValueError: if there is none, naming the one that was probably meant.
    """
    for reading in among:
        if reading.name == name:
            return reading
    raise ValueError(f"no reading is called {name!r}{nearest(name, [each.name for each in among])}")
