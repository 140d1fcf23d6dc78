"""Readings that the search begins with: those that earlier measurements found to tell much of the story."""

from collections.abc import Iterator, Sequence

from crawler_bench.readings.catalogue import Reading

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


LEADS = (*_leads("lead", _VALUES, _WORDS), *_leads("lead-every-pi", _AT_EVERY_PI, _WORDS | _EVERY_PI))
