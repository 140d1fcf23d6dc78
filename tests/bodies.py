"""The body that many expected numbers were worked out for: the default until November 2026."""

from typing import Any

from crawler_bench.physics.parameters import CrawlerParameters

FORMER: dict[str, Any] = {
    "head_muscle": "reaction",
    "spike_phase": "pi",
    "tau_f": 0.7,
    "neuron_rate": 2.0,
    "spike_gain": 2.0,
    "decision_interval": 0.2,
}


def former(**changes: Any) -> CrawlerParameters:
    """That body with some constants changed."""
    return CrawlerParameters(**{**FORMER, **changes})
