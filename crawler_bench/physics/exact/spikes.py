"""When neurons spike and drives fall through the limiter, and what it does to a muscle.

With q = cot(theta / 2), eq. 6 of a neuron that is OFF becomes dq/dt = -neuron_rate: a clock, which runs down
to its spike at q = 0 (theta = pi). What is kept is the q that it would have had at the epoch, so a neuron
costs nothing while it is OFF. One that is ON turns by an angle that is the same in every decision.
"""

import math

from crawler_bench.physics.coefficients import Coefficients
from crawler_bench.physics.compiled import inline_kernel
from crawler_bench.physics.crawler import set_net_force
from crawler_bench.physics.exact.trajectory import force_at, set_muscle_terms
from crawler_bench.physics.muscle import time_in_limiter
from crawler_bench.physics.relaxation import Response
from crawler_bench.physics.state import Node, Nodes
from crawler_bench.physics.tolerances import COINCIDENCE, NEVER, SURE_TURN


@inline_kernel
def turn_on(node: Node, time: float, k: Coefficients) -> float:
    """Turn a neuron ON for a decision that begins now [M20, eq. 6]; note when it spikes first [M20, eq. 7].

    Returns:
        Its q at the end of the decision.
    """
    q = node.cotangent_at_epoch - k.neuron_rate * time
    turned = k.cos_rate_decision + q * k.sin_rate_decision
    end = (q * k.cos_rate_decision - k.sin_rate_decision) / turned if turned != 0.0 else NEVER
    end = min(max(end, -NEVER), NEVER)
    due, node.spike_time = node.spike_time <= time + COINCIDENCE, NEVER
    turns_far = k.neuron_rate * k.decision > SURE_TURN
    if k.spike_at_2pi:  # where q passes from -infinity to infinity
        if k.spike_at_pi and q >= 0.0:
            angle = math.atan(q)
        else:
            angle = math.atan(-1.0 / q) if q != 0.0 else -0.5 * math.pi
            angle = angle if q < 0.0 else angle + math.pi
        node.spike_time = time if k.spike_at_pi and due else time + angle / k.neuron_rate
    elif turns_far or end < 0.0 <= q:
        angle = math.atan(q)
        spike_time = time + (angle if q >= 0.0 else angle + math.pi) / k.neuron_rate
        if not turns_far:  # it has spiked by the end: rounding must not undo it
            spike_time = min(spike_time, time + k.decision - COINCIDENCE)
        node.spike_time = spike_time
    elif due:  # the spike of a neuron that was OFF, at this very moment
        node.spike_time = time
    return end


@inline_kernel
def turn_off(node: Node, q: float, time: float, k: Coefficients) -> None:
    """Turn a neuron, whose q is given, OFF; note when it spikes."""
    node.cotangent_at_epoch = q + k.neuron_rate * time if q < NEVER else NEVER
    node.spike_time = time + q / k.neuron_rate if k.spike_at_pi and 0.0 <= q < NEVER else NEVER


@inline_kernel
def next_excitation(nodes: Nodes) -> float:
    """When the next neuron spikes or drive falls through its limit."""
    spike, limit = NEVER, NEVER  # apart, so that neither waits for the other
    for node in nodes:
        spike = node.spike_time if node.spike_time < spike else spike
        limit = node.limit_time if node.limit_time < limit else limit
    return min(spike, limit)


@inline_kernel
def due_muscle(nodes: Nodes, time: float) -> int:
    """The first muscle that receives a spike, or leaves its limiter, by now; there must be one."""
    for i in range(nodes.size):
        if nodes[i].spike_time <= time or nodes[i].limit_time <= time:
            return i
    return 0  # there was none


@inline_kernel
def excite(nodes: Nodes, i: int, now: Response, is_on: bool, k: Coefficients) -> None:
    """Apply the spike, or the fall through the limiter, of muscle i that is due [M20, eq. 4-5].

    Note when its next ones are; a neuron that `is_on` spikes again when theta has turned by 2 pi, or by pi.
    """
    node = nodes[i]
    force = force_at(node.muscle, now)
    drive = node.drive_at_epoch * now.e_m
    if node.limit_time <= now.time:
        drive = 1.0
    if node.spike_time <= now.time:
        drive += k.spike_gain
        turn = 0.5 * math.pi if k.spike_at_pi and k.spike_at_2pi else math.pi  # of theta / 2
        node.spike_time = node.spike_time + turn / k.neuron_rate if is_on else NEVER
    node.limit_time = now.time + time_in_limiter(drive, k.tau_m)
    set_muscle_terms(node, drive, force, now, k)
    for pulled in range(max(i - 1, 0), max(i, 1) + 1):
        set_net_force(nodes, pulled, k)
