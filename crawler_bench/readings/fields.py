"""What the paper leaves open, as data: each field with the words that it interprets and the values to try.

A value is *sourced* if the paper, or a paper that it builds on, prints or names it; every other value is a
free constant, fitted or chosen by us, and counts against the reading that uses it.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

REGULARIZATION = "environment.regularization"
NO_LIMIT = 1e9  # tau: a time limit that is never met
PRINTED_STEP = 0.01  # tau, Delta t of Table S1
DERIVED_INTERVAL = (
    0.19  # tau: 20 decisions, the horizon of gamma = 0.95, as the wave passes one of 10 segments
)

Value = Any  # a number, a word or a truth value: what YAML holds


@dataclass(frozen=True)
class Field:
    """One thing that the paper leaves open, or that its conclusion might not depend on.

    Attributes:
        key: dotted key of a run's configuration.
        words: the paper's words that a value interprets.
        sourced: values that have a source, with it.
        tried: values tried alone, other than the default's.
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
          {"reaction": "eq. 2 with [P16]", "external": "eq. 1 and 2", "none": "Fig. 1A"}, ("reaction", "none")),
    Field("parameters.spike_phase", '"crosses a multiple of 2 pi" against mod(theta - pi, 2 pi) = 0 (eq. 7)',
          {"pi": "eq. 7", "2pi": "text before eq. 7", "every_pi": "eq. 7 and its text, both"}, ("pi", "2pi")),
    Field("parameters.observation", '"most strongly contracted" against argmin (u_i - u_(i-1)) (eq. 9)',
          {"most_contracted": "text before eq. 9", "most_stretched": "eq. 9"}, ("most_stretched",)),
    Field("parameters.tau_f", '"the ratio of timescales for muscular and neuronal activity": named (eq. 4), not given',
          {1.0: "Table S1, if its muscular timescale is tau_f", 0.4: "[P16, Table 1]"},
          (0.2, 0.3, 0.5, 0.6, 0.7, 1.0), continuous=True),
    Field("parameters.tau_m", '"scaled muscular timescale 1" (Table S1)', {1.0: "Table S1"}, (0.5, 0.75, 1.5, 2.0)),
    Field("parameters.neuron_rate", '"tau_theta dtheta/dt = 1 - cos theta + ..." (eq. 6): no factor is printed; with times in units of tau_m it is "the ratio tau_m/tau_theta", named and not given',
          {1.0: "eq. 6"}, (1.0, 1.2, 1.4, 1.5, 1.7, 2.0, 3.0), continuous=True),
    Field("parameters.spike_gain", '"F = sum exp(-(t - t_s) / tau_m)" (eq. 5): no factor is printed',
          {1.0: "eq. 5"}, (0.8, 0.9, 1.1, 1.25, 1.5, 2.0), continuous=True),
    Field("parameters.decision_interval", '"Delta t is the size of the discrete time step (Table S1)": 0.01',
          {PRINTED_STEP: "Table S1", DERIVED_INTERVAL: "1 / (1 - gamma) decisions in the passage of one segment, 1 / (0.026 N)"},
          (PRINTED_STEP, 0.05, 0.1, 0.15, 0.25, 0.3, 0.5, 1.0), continuous=True),
    Field("parameters.penalty", '"r = (u_(t + Delta t) - u_t) - epsilon r_2" (eq. 11): per decision; its weight then hangs on Delta t',
          {"decision": "eq. 11", "rate": "eq. 11, if its two terms are to keep their ratio for any Delta t"}, ("rate",)),
    Field("parameters.decide_on", '"each time the agent takes an action in a state" (eq. 12): at each Delta t, or when the state changes',
          {"interval": "eq. 11 and 12", "change": "text before eq. 12"}, ("change",)),
    Field("parameters.longest_hold", "how long an action lasts if the state does not change is not named",
          {2.0: "matters only where decisions wait for a change"}, ()),
    Field("parameters.dt", '"scaled discrete timestep 0.01" (Table S1), in implicit Euler steps instead of exactly',
          {PRINTED_STEP: "Table S1"}, (PRINTED_STEP, 0.038)),
    Field("settings.initial_q", '"a Q-matrix of values that are uniform and high"', {},
          (0.05, 0.2, 1.0, 2.0, 7.0, 15.0, 50.0), continuous=True),
    Field("environment.episode_distance", '"each episode corresponds to the crawler moving a fixed distance forward"',
          {}, (1.0, 2.0, 4.0, 6.0, 12.0, 20.0), continuous=True),
    Field("environment.time_limit", "no time limit is named", {NO_LIMIT: "not in the paper"},
          (250.0, 500.0, 1000.0, 2000.0, 4000.0), continuous=True),
    Field("settings.end_is_terminal", '"after which it is reset"; eq. 12 makes no exception at the end of an episode',
          {False: "eq. 12", True: "the textbook that the paper cites"}, (True,)),
)  # fmt: skip

# What the paper gives; the question is whether its conclusion depends on it.
GIVEN = (
    Field("settings.learning_rate", '"most reasonable choices for these will converge"', {0.05: "Formulation"},
          (0.01, 0.02, 0.1, 0.2)),
    Field("settings.discount", '"most reasonable choices for these will converge"', {0.95: "Formulation"},
          (0.8, 0.9, 0.98, 0.99)),
    Field("parameters.n_segments", '"which has 10 segments"', {10: "Fig. 1"}, (6, 8, 14, 20)),
    Field(REGULARIZATION, '"the regularization parameter epsilon = 0.01"', {0.01: "Results"},
          (0.0005, 0.001, 0.002, 0.005, 0.02, 0.05, 0.1)),
)  # fmt: skip


def word(value: Value) -> str:
    """A value as tables and names of readings write it."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int | float):
        return "none" if value == NO_LIMIT else f"{value:g}"
    return str(value)
