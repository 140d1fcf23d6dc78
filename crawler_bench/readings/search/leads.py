"""Readings that the search begins with: those that earlier measurements found to tell much of the story."""

from collections.abc import Iterator, Sequence

from crawler_bench.readings.catalogue import Reading
from crawler_bench.readings.fields import DERIVED_INTERVAL, NO_LIMIT

_KEYS = (
    "parameters.tau_f",
    "parameters.neuron_rate",
    "parameters.spike_gain",
    "parameters.decision_interval",
    "settings.initial_q",
    "environment.episode_distance",
    "environment.time_limit",
)
# In the order of _KEYS: the default of the first version, and points of a first, smaller search around it.
_VALUES = (
    (0.7, 2.0, 2.0, 0.2, 0.2, 2.0, 1000.0),
    (0.674, 2.579, 1.354, 0.25, 4.9, 6.3, 463.0),
    (0.695, 2.568, 1.336, 0.3, 6.27, 4.47, 462.0),
    (0.741, 2.664, 1.319, 0.3, 6.65, 5.11, 453.0),
    (0.664, 2.546, 1.447, 0.3, 6.79, 5.16, 554.0),
    (0.671, 2.453, 1.458, 0.25, 8.15, 5.52, 446.0),
    (0.649, 2.461, 1.373, 0.3, 11.5, 4.78, 554.0),
    (0.85, 2.2, 1.8, 0.2, 2.0, 5.0, 600.0),
    (1.0, 3.5, 1.0, 1.0, 1.0, 2.0, 1000.0),
    (1.0, 4.0, 1.0, 0.5, 5.0, 5.0, 300.0),
    (0.622, 2.69, 1.32, 0.25, 4.69, 5.06, 436.0),
    (0.753, 2.35, 1.5, 0.25, 6.65, 4.93, 626.0),
)
# The same with a spike at every multiple of pi: no factor in eq. 5, and tau_f = 1.
_AT_EVERY_PI = (
    (1.0, 2.0, 1.0, 0.5, 0.2, 2.0, 1000.0),
    (1.0, 1.84, 1.0, 0.35, 0.286, 3.04, 641.0),
    (1.0, 1.82, 1.0, 0.35, 0.711, 2.62, 699.0),
)
# With the head muscle as eq. 1 prints it, no time limit, the derived interval: added after 850 trials.
_EXTERNAL = (
    (0.7, 2.4, 1.5, DERIVED_INTERVAL, 6.5, 6.3, NO_LIMIT),
    (0.7, 2.4, 1.5, DERIVED_INTERVAL, 3.0, 6.3, NO_LIMIT),
    (0.7, 2.4, 1.6, DERIVED_INTERVAL, 6.5, 6.3, NO_LIMIT),
    (0.8, 2.2, 1.7, DERIVED_INTERVAL, 6.5, 6.3, NO_LIMIT),
    (0.75, 2.4, 1.6, DERIVED_INTERVAL, 6.5, 6.3, NO_LIMIT),
    (0.65, 2.5, 1.4, DERIVED_INTERVAL, 6.5, 6.3, NO_LIMIT),
    (0.7, 2.3, 1.6, DERIVED_INTERVAL, 3.0, 6.3, NO_LIMIT),
    (0.75, 2.3, 1.6, DERIVED_INTERVAL, 5.0, 5.0, NO_LIMIT),
    (0.72, 2.5, 1.42, 0.25, 6.5, 6.3, NO_LIMIT),
    (0.65, 2.4, 1.5, DERIVED_INTERVAL, 5.0, 8.0, NO_LIMIT),
)
# The same with a spike at every multiple of pi, and no factor in eq. 5.
_EXTERNAL_AT_EVERY_PI = (
    (0.4, 1.5, 1.0, DERIVED_INTERVAL, 6.5, 6.3, NO_LIMIT),
    (0.45, 1.5, 1.0, DERIVED_INTERVAL, 6.5, 6.3, NO_LIMIT),
    (0.5, 1.5, 1.0, DERIVED_INTERVAL, 6.5, 6.3, NO_LIMIT),
    (0.4, 1.6, 1.0, DERIVED_INTERVAL, 6.5, 6.3, NO_LIMIT),
    (0.4, 1.55, 1.0, DERIVED_INTERVAL, 4.0, 8.0, NO_LIMIT),
    (0.45, 1.55, 1.0, DERIVED_INTERVAL, 8.0, 7.0, NO_LIMIT),
    (0.4, 1.5, 1.0, DERIVED_INTERVAL, 2.0, 5.0, NO_LIMIT),
    (0.43, 1.5, 1.0, DERIVED_INTERVAL, 6.5, 6.3, NO_LIMIT),
    (0.5, 1.5, 1.0, DERIVED_INTERVAL, 2.0, 6.3, NO_LIMIT),
    (0.47, 1.52, 1.0, DERIVED_INTERVAL, 2.0, 6.3, NO_LIMIT),
    (0.5, 1.55, 1.0, DERIVED_INTERVAL, 6.5, 10.0, NO_LIMIT),
    (0.55, 1.55, 1.0, 0.25, 2.0, 6.3, NO_LIMIT),
    (0.48, 1.5, 1.0, 0.25, 3.0, 6.3, NO_LIMIT),
    (0.52, 1.6, 0.95, 0.25, 6.5, 6.3, NO_LIMIT),
    (0.5, 1.3, 1.15, DERIVED_INTERVAL, 6.5, 6.3, NO_LIMIT),
    (0.5, 1.4, 1.1, DERIVED_INTERVAL, 3.0, 6.3, NO_LIMIT),
)
_WORDS = {
    "parameters.spike_phase": "pi",
    "parameters.head_muscle": "reaction",
    "parameters.penalty": "decision",
    "parameters.decide_on": "interval",
}
_EVERY_PI = {"parameters.spike_phase": "every_pi"}


def _leads(name: str, values: Sequence[tuple[float, ...]], words: dict[str, str]) -> Iterator[Reading]:
    for i, each in enumerate(values):
        yield Reading(f"{name}-{i}", "search", {**dict(zip(_KEYS, each, strict=True)), **words})


_HEAD = {"parameters.head_muscle": "external"}
LEADS = (
    *_leads("lead", _VALUES, _WORDS),
    *_leads("lead-every-pi", _AT_EVERY_PI, _WORDS | _EVERY_PI),
    *_leads("lead-external", _EXTERNAL, _WORDS | _HEAD),
    *_leads("lead-external-every-pi", _EXTERNAL_AT_EVERY_PI, _WORDS | _HEAD | _EVERY_PI),
)
