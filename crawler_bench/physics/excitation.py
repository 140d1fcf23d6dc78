"""When neurons spike and drives fall through the limiter, and what it does to a muscle, for exact.py."""

import math

import numpy as np
from numpy.typing import NDArray

from crawler_bench.physics.coefficients import Coefficients
from crawler_bench.physics.compilation import inner_kernel
from crawler_bench.physics.events import LIMIT_AT, SPIKE_AT
from crawler_bench.physics.layout import DRIVE, FORCE
from crawler_bench.physics.neuron import first_spike, neuron_after, step_neurons_off
from crawler_bench.physics.response import Response

Rows = NDArray[np.float64]


@inner_kernel
def schedule_spikes(V: Rows, spike_at: Rows, action: int, other: int, k: Coefficients) -> float:
    """Move the neurons to the end of the decision; note when each spikes first, return the earliest time."""
    earliest = step_neurons_off(V, spike_at, action, other, k.decision, k.neuron_rate, k.spike_at_pi)
    turn = k.neuron_rate * k.decision
    for i in range(1 + int(other != action)):
        on = other if i else action
        after = neuron_after(V[on], True, turn, k.sin_rate_decision, k.cos_rate_decision)
        # Without a spike V has risen; where it may have gone all the way round, it is asked for in any case.
        if after < V[on] or turn > 1.5 or not k.spike_at_pi:
            spike_at[on] = first_spike(V[on], True, k.neuron_rate, k.decision, k.spike_at_pi)
            earliest = min(earliest, spike_at[on])
        V[on] = after
    return earliest


@inner_kernel
def schedule_limits(F: Rows, limit_at: Rows, tau_m: float) -> float:
    """Note when each drive falls through 1; return the earliest time."""
    earliest = np.inf
    for i in range(F.size):
        limit_at[i] = tau_m * math.log(F[i]) if F[i] > 1.0 else np.inf
        earliest = min(earliest, limit_at[i])
    return earliest


@inner_kernel
def due(work: Rows, clock: float) -> int:
    """A muscle that spikes, or leaves its limiter, by now."""
    for i in range(work.shape[1]):
        if work[SPIKE_AT, i] <= clock or work[LIMIT_AT, i] <= clock:
            return i
    return 0


@inner_kernel
def delay_excitation(work: Rows, delay: float) -> None:
    """Put off all that is noted."""
    for i in range(work.shape[1]):
        work[SPIKE_AT, i] += delay
        work[LIMIT_AT, i] += delay


@inner_kernel
def excite(state: Rows, work: Rows, i: int, clock: float, now: Response, on: bool, k: Coefficients) -> None:
    """Apply the spike or the fall through the limiter of muscle i that is due; note when the next one is."""
    F, f, spike_at, limit_at = state[DRIVE], state[FORCE], work[SPIKE_AT], work[LIMIT_AT]
    constant, as_e_f, as_r_f = parts(F[i], f[i], limit_at[i], k.force_max)
    force = constant + as_e_f * now.e_f + as_r_f * now.r_f
    drive = F[i] * now.e_m
    if limit_at[i] <= clock:
        drive = 1.0
    if spike_at[i] <= clock:
        drive += k.spike_gain
        spike_at[i] = spike_at[i] + math.pi / k.neuron_rate if on else np.inf
    F[i] = drive / now.e_m
    limit_at[i] = clock + k.tau_m * math.log(drive) if drive > 1.0 else np.inf
    own = k.force_max * (1.0 - now.e_f) if drive > 1.0 else k.force_max * F[i] * now.r_f
    f[i] = (force - own) / now.e_f


@inner_kernel
def parts(F: float, f: float, limit_at: float, force_max: float) -> tuple[float, float, float]:
    """A muscle's force as its parts that are constant, go as e_f, go as r_f."""
    if limit_at < np.inf:
        return force_max, f - force_max, 0.0
    return 0.0, f, force_max * F
