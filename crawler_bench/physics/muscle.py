"""The spiking muscle [M20, eq. 4-5], stepped exactly.

F(t) is the summed drive of all past spikes, each worth `spike_gain` and decaying with tau_m; the force f
relaxes with tau_f towards muscle_force_max min(1, F). Between spikes, and on either side of the moment at
which F falls through 1 (the limiter), both are exponentials.
"""

import math

from crawler_bench.physics.compilation import kernel
from crawler_bench.physics.response import follow

# A muscle left alone would decay into denormal numbers, which are slow and mean nothing.
NEGLIGIBLE = 1e-200


@kernel
def relax_muscle(
    F: float, f: float, time: float, tau_m: float, tau_f: float, force_max: float
) -> tuple[float, float]:
    """Advance drive and force by any time in which no spike arrives.

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
        limited = min(tau_m * math.log(F), time)
        f = force_max + (f - force_max) * math.exp(-limited / tau_f)
        F = F * math.exp(-limited / tau_m) if limited == time else 1.0
        time -= limited
    if time > 0.0:
        f = f * math.exp(-time / tau_f) + force_max * F * follow(time, tau_m, tau_f)
        F *= math.exp(-time / tau_m)
    return F if F > NEGLIGIBLE else 0.0, f if f > NEGLIGIBLE else 0.0
