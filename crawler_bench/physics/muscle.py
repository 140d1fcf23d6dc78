"""The spiking muscle [M20, eq. 4-5], stepped exactly.

F(t) is the summed drive of all past spikes, each worth `spike_gain` and decaying with tau_m; the force f
relaxes with tau_f towards muscle_force_max min(1, F). Between spikes, and on either side of the moment at
which F falls through 1 (the limiter), both are exponentials.
"""

import math

import numpy as np
from numpy.typing import NDArray

from crawler_bench.physics.compilation import inner_kernel, step_kernel
from crawler_bench.physics.response import follow

# A muscle left alone would decay into denormal numbers, which are slow and mean nothing.
NEGLIGIBLE = 1e-200


@inner_kernel
def flush(value: float) -> float:
    """The value, or 0 where it is negligible."""
    return value if value > NEGLIGIBLE else 0.0


@step_kernel
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
    return flush(F), flush(f)


@inner_kernel
def step_quiet_muscle(
    F: float, f: float, drive_decay: float, force_decay: float, gain: float, limited_gain: float
) -> tuple[float, float]:
    """Advance drive and force by one step without a spike, and on one side of the limiter.

    Args:
        F: drive (dimensionless).
        f: force, k L.
        drive_decay: factor of a drive in one step.
        force_decay: factor of a force in one step.
        gain: what one step adds to a force, k L, per unit of its drive.
        limited_gain: what one step adds to a force whose drive is limited, k L.

    Returns:
        F and f at the end.
    """
    pull = limited_gain if F > 1.0 else gain * F
    return flush(F * drive_decay), flush(f * force_decay + pull)


@inner_kernel
def step_quiet_muscles(
    F: NDArray[np.float64],
    f: NDArray[np.float64],
    drive_decay: float,
    force_decay: float,
    gain: float,
    limited_gain: float,
) -> bool:
    """Advance all muscles, (N + 1,) drives F and forces f, like `step_quiet_muscle`.

    Returns:
        Whether a drive falls through 1 in the next step.
    """
    crossings = 0
    for i in range(F.size):  # without branches, so that it is done for several muscles at a time
        F[i], f[i] = step_quiet_muscle(F[i], f[i], drive_decay, force_decay, gain, limited_gain)
        crossings += int(leaves_limiter(F[i], drive_decay))
    return crossings > 0


@inner_kernel
def leaves_limiter(F: float, drive_decay: float) -> bool:
    """Whether a drive falls through 1 in one step."""
    return (F > 1.0) & (F * drive_decay <= 1.0)


@inner_kernel
def any_leaves_limiter(F: NDArray[np.float64], drive_decay: float) -> bool:
    """Whether one of the (N + 1,) drives falls through 1 in one step."""
    crossings = 0
    for i in range(F.size):
        crossings += int(leaves_limiter(F[i], drive_decay))
    return crossings > 0
