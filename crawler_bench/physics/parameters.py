"""Every constant of the crawler: Table S1 of Mishra et al. 2020, and the readings of what it leaves open.

Lengths are in units of the segment rest length L, times in the neuronal timescale tau_theta, forces in k L.
Sources: [M20] Mishra, van Rees & Mahadevan 2020; [P16] Pehlevan, Paoletti & Mahadevan 2016.
"""

import math
from dataclasses import dataclass, fields
from numbers import Integral, Real
from typing import Any

from crawler_bench.physics.tolerances import WHOLE_MULTIPLE

CHOICES = {
    "friction_law": ("table", "literal"),
    "head_muscle": ("reaction", "external", "none"),
    "spike_phase": ("pi", "2pi", "every_pi"),
    "observation": ("most_contracted", "most_stretched"),
    "penalty": ("decision", "rate"),
    "decide_on": ("interval", "change"),
    "integrator": ("exact", "step"),
}


@dataclass(frozen=True, kw_only=True)
class CrawlerParameters:
    """The constants of [M20, eq. 1-10], validated; an impossible value raises a ValueError.

    Fields marked "reading" are choices where the paper is silent or contradicts itself; those marked
    "fitted" are numbers that the paper does not give and that were chosen to tell its story.
    """

    n_segments: int = 10  # segments N; nodes are 0 (head) to N (tail) [M20, Fig. 1]
    damping: float = 3.5  # c tau_theta / k [M20, Table S1]
    tau_m: float = 1.0  # decay time of a spike's drive, tau_theta [M20, Table S1]
    tau_f: float = 0.4  # relaxation time of the muscle force, tau_theta [P16, Table 1; eq. 4 names it]
    muscle_force_max: float = 1.0  # k L [M20, Table S1]
    friction_forward: float = 0.3  # k L: backward limit / anisotropy = 9 / 30 [M20, Table S1]
    friction_backward: float = 9.0  # k L [M20, Table S1, "scaled backward frictional force"]
    friction_law: str = "table"  # reading: "literal" makes 9 the *forward* limit, as eq. 8 prints it
    head_muscle: str = "external"  # reading: does f_0 pull back on node 1 ("reaction") or not ("external")
    spike_phase: str = "every_pi"  # reading: eq. 7 spikes at pi, its text at multiples of 2 pi; or at both
    neuron_rate: float = 1.59  # 1 / tau_theta, multiplies eq. 6; tau_m / tau_theta in times of tau_m [fitted]
    spike_gain: float = 1.0  # multiplies the sum of eq. 5 [M20]
    observation: str = "most_contracted"  # reading: eq. 9's argmin taken literally is "most_stretched"
    dt: float = 0.01  # integration step, tau_theta [M20, Table S1]
    integrator: str = "exact"  # from event to event, or implicit Euler steps of dt
    decision_interval: float = 0.19  # between actions, tau_theta [derived from gamma; Table S1 has 0.01]
    penalty: str = "decision"  # reading: eq. 11 takes epsilon r_2 off once per decision, or per unit of time
    decide_on: str = (
        "interval"  # reading: act at every interval, or at the first where the observation changes
    )
    longest_hold: float = 2.0  # time after which an action ends though nothing changes, tau_theta [chosen]

    def __post_init__(self) -> None:
        """Cast every number to its declared type, then check that the model is solvable.

        Raises:
            ValueError: naming the field, its value and what is allowed.
        """
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name in CHOICES:
                choices = CHOICES[field.name]
                _require(isinstance(value, str) and value in choices, field.name, value, _one_of(choices))
            elif field.name == "n_segments":
                whole = isinstance(value, Integral) and not isinstance(value, bool) and int(value) >= 2
                _require(whole, field.name, value, "a whole number of at least 2")
                object.__setattr__(self, field.name, int(value))
            else:
                number = _as_float(value)
                _require(math.isfinite(number) and number > 0, field.name, value, "a finite number above 0")
                object.__setattr__(self, field.name, number)
        # For either integrator, so that the one can stand in for the other at any time.
        self._check_neuron_step()
        self._check_decision_interval()
        self._check_external_head_muscle()

    def _check_neuron_step(self) -> None:
        limit = math.pi / (2 * self.neuron_rate)
        _require(self.dt < limit, "dt", self.dt, f"below pi / (2 neuron_rate) = {limit:.6g}")

    def _check_decision_interval(self) -> None:
        steps = self.decision_interval / self.dt
        whole = (
            steps < 2**31 and round(steps) >= 1 and math.isclose(steps, round(steps), rel_tol=WHOLE_MULTIPLE)
        )
        _require(whole, "decision_interval", self.decision_interval, f"a whole multiple of dt = {self.dt:g}")

    def _check_external_head_muscle(self) -> None:
        """Without its reaction, f_0 pushes the whole body; friction alone can hold it [M20, eq. 1-2]."""
        if self.head_muscle == "external":
            resistance = (self.n_segments + 1) * self.forward_limit
            _require(
                resistance > self.muscle_force_max,
                "friction_forward",
                self.friction_forward,
                f"(n_segments + 1) times the forward limit above muscle_force_max = "
                f"{self.muscle_force_max:g}, or head_muscle 'reaction': without the reaction of eq. 1 only "
                "friction holds the body",
            )

    @property
    def steps_per_decision(self) -> int:
        """Integration steps in one decision interval."""
        return round(self.decision_interval / self.dt)

    @property
    def intervals_per_decision(self) -> int:
        """Decision intervals for which one action is held at the most."""
        return (
            1 if self.decide_on == "interval" else max(1, round(self.longest_hold / self.decision_interval))
        )

    @property
    def anisotropy(self) -> float:
        """Ratio of the backward to the forward friction limit, eta_f [M20, Table S1]."""
        return self.friction_backward / self.friction_forward

    @property
    def forward_limit(self) -> float:
        """Friction on a node that slides forward, k L."""
        return self.friction_backward if self.friction_law == "literal" else self.friction_forward

    @property
    def backward_limit(self) -> float:
        """Magnitude of the friction on a node that slides backward, k L."""
        scale = self.anisotropy if self.friction_law == "literal" else 1.0
        return self.friction_backward * scale


def _as_float(value: Any) -> float:
    """The number that a value is; NaN if it is none."""
    if isinstance(value, bool) or not isinstance(value, Real):
        return math.nan
    try:
        return float(value)
    except OverflowError:
        return math.inf


def _one_of(choices: tuple[str, ...]) -> str:
    return "one of " + ", ".join(repr(choice) for choice in choices)


def _require(condition: bool, name: str, value: Any, allowed: str) -> None:
    if not condition:
        raise ValueError(f"{name} = {value!r} is not possible: it must be {allowed}")
