"""When neurons spike and drives fall through the limiter, and what it does to a muscle, for exact.py.

With q = cot(theta / 2), eq. 6 of a neuron that is OFF becomes dq/dt = -neuron_rate: a clock, which runs down
to its spike at q = 0 (theta = pi). PHASE holds the q that it would have had at the epoch, so that a neuron
costs nothing while it is OFF. One that is ON turns by an angle that is the same in every decision.
"""

import math

import numpy as np

from crawler_bench.physics.coefficients import Coefficients
from crawler_bench.physics.compilation import inner_kernel
from crawler_bench.physics.course import add_up, bend
from crawler_bench.physics.intrinsics import NO_BITS, WORD, lowest_bit
from crawler_bench.physics.layout import (
    CHARGE,
    LIMIT_AT,
    NEVER,
    PHASE,
    PULL,
    PULL_F,
    PULL_R,
    SPIKE_AT,
    Memory,
)
from crawler_bench.physics.response import Response

_COINCIDENCE = 1e-13  # of a spike with the end of a decision, tau_theta
_SURE = 1.5  # half the angle by which an ON neuron turns before it may have passed its spike and come round


@inner_kernel
def turn_on(memory: Memory, i: int, clock: float, k: Coefficients) -> float:
    """Turn neuron i ON for a decision that begins now; note when it spikes first.

    Returns:
        Its q at the end of the decision.
    """
    q = memory[PHASE, i] - k.neuron_rate * clock
    turned = k.cos_rate_decision + q * k.sin_rate_decision
    end = (q * k.cos_rate_decision - k.sin_rate_decision) / turned if turned != 0.0 else NEVER
    end = min(max(end, -NEVER), NEVER)
    due, memory[SPIKE_AT, i] = memory[SPIKE_AT, i] <= clock + _COINCIDENCE, NEVER
    if not k.spike_at_pi:  # at theta = 2 pi, where q passes from -infinity to infinity
        angle = math.atan(-1.0 / q) if q != 0.0 else -0.5 * math.pi
        memory[SPIKE_AT, i] = clock + (angle if q < 0.0 else angle + math.pi) / k.neuron_rate
    elif (q >= 0.0) & (end < 0.0) or k.neuron_rate * k.decision > _SURE:
        angle = math.atan(q)
        time = clock + (angle if q >= 0.0 else angle + math.pi) / k.neuron_rate
        if end < 0.0 <= q and k.neuron_rate * k.decision <= _SURE:  # it has spiked: rounding must not undo it
            time = min(time, clock + k.decision - _COINCIDENCE)
        memory[SPIKE_AT, i] = time
    elif due:  # the spike of a neuron that was OFF, at this very moment
        memory[SPIKE_AT, i] = clock
    return end


@inner_kernel
def turn_off(memory: Memory, i: int, q: float, clock: float, k: Coefficients) -> None:
    """Turn neuron i, whose q is given, OFF; note when it spikes."""
    memory[PHASE, i] = q + k.neuron_rate * clock if q < NEVER else NEVER
    memory[SPIKE_AT, i] = clock + q / k.neuron_rate if k.spike_at_pi and 0.0 <= q < NEVER else NEVER


@inner_kernel
def next_excitation(memory: Memory) -> float:
    """When the next neuron spikes or drive falls through its limit."""
    spike, limit = NEVER, NEVER
    for i in range(memory.shape[1]):
        a, b = memory[SPIKE_AT, i], memory[LIMIT_AT, i]
        spike = spike if spike < a else a  # shorter in machine code than min
        limit = limit if limit < b else b
    return min(spike, limit)


@inner_kernel
def due(memory: Memory, clock: float) -> int:
    """The first muscle that spikes, or leaves its limiter, by now; there must be one."""
    for start in range(0, memory.shape[1], WORD):
        found = NO_BITS
        for n in range(min(WORD, memory.shape[1] - start)):
            i = np.uint64(start + n)
            is_due = (memory[SPIKE_AT, i] <= clock) | (memory[LIMIT_AT, i] <= clock)
            found |= np.uint64(is_due) << np.uint64(n)
        if found != NO_BITS:
            return start + lowest_bit(found)
    return 0  # there was none


@inner_kernel
def excite(memory: Memory, i: int, clock: float, now: Response, on: bool, k: Coefficients) -> None:
    """Apply the spike or the fall through the limiter of muscle i that is due; note when the next one is."""
    force = memory[PULL, i] + memory[PULL_F, i] * now.e_f + memory[PULL_R, i] * now.r_f
    drive = memory[CHARGE, i] * now.e_m
    if memory[LIMIT_AT, i] <= clock:
        drive = 1.0
    if memory[SPIKE_AT, i] <= clock:
        drive += k.spike_gain
        memory[SPIKE_AT, i] = memory[SPIKE_AT, i] + math.pi / k.neuron_rate if on else NEVER
    memory[LIMIT_AT, i] = clock + k.tau_m * math.log(drive) if drive > 1.0 else NEVER
    bend(memory, i, drive, force, now, k)
    for node in range(max(i - 1, 0), max(i, 1) + 1):
        add_up(memory, node, k)
