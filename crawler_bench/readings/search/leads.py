"""Readings that the search begins with: those that earlier measurements found to tell much of the story."""

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
)
_WORDS = {
    "parameters.spike_phase": "pi",
    "parameters.head_muscle": "reaction",
    "parameters.penalty": "decision",
    "parameters.decide_on": "interval",
}
_EVERY_PI = {"parameters.spike_phase": "every_pi"}

LEADS = (
    *(
        Reading(f"lead-{i}", "search", dict(zip(_KEYS, v, strict=True)) | _WORDS)
        for i, v in enumerate(_VALUES)
    ),
    Reading(
        "lead-every-pi",
        "search",
        dict(zip(_KEYS, (1.0, 2.0, 1.0, 0.5, 0.2, 2.0, 1000.0), strict=True)) | _WORDS | _EVERY_PI,
    ),
)
