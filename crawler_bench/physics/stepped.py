"""The crawler in implicit Euler steps of dt: neurons and muscles exactly, the body to first order.

A step of the force balance of body.py, with u the displacements at its end and u_0 those at its start, reads

    A w = B f - friction,       w = c v + k u = (c + k dt) v + k u_0,       v = (u - u_0) / dt,

so it is that of a body at u_0 whose damping is c + k dt. This integrator has no shortcuts: the exact one is
compared with it, and it takes over where that one gives up.
"""

from crawler_bench.physics.body import STUCK, balance_forces
from crawler_bench.physics.coefficients import Coefficients, Stepping
from crawler_bench.physics.compiled import inner_kernel
from crawler_bench.physics.crawler import fires_with, set_net_force
from crawler_bench.physics.muscle import flush, relax_muscle
from crawler_bench.physics.neuron import NO_SPIKE, step_neuron
from crawler_bench.physics.state import Node, Nodes


@inner_kernel
def advance(nodes: Nodes, action: int, n_steps: int, k: Coefficients, s: Stepping) -> None:
    """Advance the crawler by n_steps steps of dt with one neuron ON.

    Args:
        nodes: changed in place.
        action: the neuron that is ON, 0 to N - 1, with the tail's when it is the head's [M20, eq. 10].
        n_steps: number of steps.
        k: coefficients.
        s: coefficients of the steps.
    """
    also_on = fires_with(action, nodes.size - 1)
    for _ in range(n_steps):
        for i in range(nodes.size):
            is_on = i == action or i == also_on
            step_muscle(nodes[i], step_spike(nodes[i], is_on, k, s), k, s)
        for i in range(nodes.size):
            set_net_force(nodes, i, k)
        step_body(nodes, k, s)


@inner_kernel
def step_spike(node: Node, is_on: bool, k: Coefficients, s: Stepping) -> float:
    """Advance a neuron by dt; return the time of its spike from the start of the step, or NO_SPIKE."""
    node.neuron, spike = step_neuron(
        node.neuron, is_on, s.dt, k.neuron_rate, s.tan_rate_dt, bool(k.spike_at_pi), bool(k.spike_at_2pi)
    )
    return spike


@inner_kernel
def step_muscle(node: Node, spike: float, k: Coefficients, s: Stepping) -> None:
    """Advance a muscle by dt; its spike and its fall through the limiter come at their own times."""
    F, f = node.drive, node.force
    if spike != NO_SPIKE:
        F, f = relax_muscle(F, f, spike, k.tau_m, k.tau_f, k.force_max)
        F, f = relax_muscle(F + k.spike_gain, f, s.dt - spike, k.tau_m, k.tau_f, k.force_max)
    elif F * s.drive_decay <= 1.0 < F:
        F, f = relax_muscle(F, f, s.dt, k.tau_m, k.tau_f, k.force_max)
    else:  # the same, with its exponentials known: ten times faster
        gain = s.limited_force_gain if F > 1.0 else s.force_gain * F
        F, f = flush(F * s.drive_decay), flush(f * s.force_decay + gain)
    node.drive, node.force = F, f
    node.muscle.constant, node.muscle.as_e_f, node.muscle.as_r_f = f, 0.0, 0.0


@inner_kernel
def step_body(nodes: Nodes, k: Coefficients, s: Stepping) -> None:
    """Advance the body by dt under the net muscle forces at the end of the step."""
    balance_forces(nodes, k)
    for node in nodes:
        moving = node.w.constant - node.displacement
        node.velocity = moving / (k.damping + s.dt) if node.slip != STUCK else 0.0
        node.displacement += s.dt * node.velocity
