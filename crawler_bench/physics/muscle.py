"""The spiking muscle [M20, eq. 4-5], stepped exactly.

F(t) is the summed drive of all past spikes, each worth `spike_gain` and decaying with tau_m; the force f
relaxes with tau_f towards muscle_force_max min(1, F). Between spikes, and on either side of the moment at
which F falls through 1 (the limiter), both are exponentials.
"""

import math

from crawler_bench.physics.compiled import inline_kernel, inner_kernel
from crawler_bench.physics.tolerances import NEGLIGIBLE, NEVER


@inner_kernel
def relax_muscle(
    F: float, f: float, time: float, tau_m: float, tau_f: float, force_max: float
) -> tuple[float, float]:
    """Advance drive [M20, eq. 5] and force [M20, eq. 4] by any time in which no spike arrives.

    Args:
        F: drive (dimensionless).
        f: force, k L.
        time: how long, tau_theta.
        tau_m: decay time of the drive.
        tau_f: relaxation time of the force.
        force_max: force at full drive, k L.

    Returns:
        F and f at the end.
    """
    if F > 1.0:
        limited = min(time_in_limiter(F, tau_m), time)
        f = force_max + (f - force_max) * math.exp(-limited / tau_f)
        F = F * math.exp(-limited / tau_m) if limited == time else 1.0
        time -= limited
    if time > 0.0:
        f = f * math.exp(-time / tau_f) + force_max * F * follow(time, tau_m, tau_f)
        F *= math.exp(-time / tau_m)
    return flush(F), flush(f)


@inline_kernel
def time_in_limiter(F: float, tau_m: float) -> float:
    """Time until a drive falls through 1, where eq. 4 limits it; NEVER if it is below."""
    return tau_m * math.log(F) if F > 1.0 else NEVER


@inner_kernel
def follow(time: float, tau_lead: float, tau_follow: float) -> float:
    """What follows a decay exp(-t / tau_lead) with time constant tau_follow, from 0.

    The integral of exp(-(t - s) / tau_follow) exp(-s / tau_lead) ds / tau_follow, also for equal constants.
    """
    difference = abs(1.0 / tau_follow - 1.0 / tau_lead)
    weight = -math.expm1(-difference * time) / difference if difference != 0.0 else time
    return math.exp(-time / max(tau_follow, tau_lead)) / tau_follow * weight


@inline_kernel
def flush(value: float) -> float:
    """The value, or 0 where it is negligible."""
    return value if value > NEGLIGIBLE else 0.0
