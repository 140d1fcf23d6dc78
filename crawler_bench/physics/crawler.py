"""The coupled crawler: neurons drive muscles, muscles pull the body, friction holds it [M20, eq. 1-10].

Node 0 is the head and + is forward; node i rests at x_i = -i and stands at x_i = -i + u_i, so segment i
(between nodes i - 1 and i) is contracted when u_i - u_{i-1} > 0. Muscle i pulls the two ends of segment i
together; muscle 0 acts on the head alone. Neuron i drives muscle i: both are part of record i of the state.

Two integrators share all this: stepped.py takes implicit Euler steps, exact/ goes from event to event.
"""

from crawler_bench.physics.coefficients import Coefficients
from crawler_bench.physics.compiled import inline_kernel, inner_kernel
from crawler_bench.physics.state import Nodes


@inline_kernel
def fires_with(action: int, tail: int) -> int:
    """The neuron that is ON with neuron `action`: that of the tail with that of the head, else itself."""
    return tail if action == 0 else action


@inline_kernel
def net_muscle_force(i: int, tail: int, own: float, behind: float, head: float, k: Coefficients) -> float:
    """Row i of B f [M20, eq. 1-3]: what the muscles do to node i, k L.

    Args:
        i: the node.
        tail: the last node, which has no muscle behind it.
        own: f_i, which pulls the node back to the one before; on the head it pushes forward.
        behind: f_{i+1}.
        head: f_0.
        k: coefficients; they hold the reading of the head muscle.
    """
    total = k.pull_on_head * own if i == 0 else own
    if i < tail:
        total -= behind
    if i == 1:
        total += k.pull_on_neck * head
    return total


@inline_kernel
def set_net_force(nodes: Nodes, i: int, k: Coefficients) -> None:
    """Find the net muscle force on node i from the muscles' terms."""
    tail = nodes.size - 1
    node, own, behind, head = nodes[i], nodes[i].muscle, nodes[min(i + 1, tail)].muscle, nodes[0].muscle
    node.net.constant = net_muscle_force(i, tail, own.constant, behind.constant, head.constant, k)
    node.net.as_e_f = net_muscle_force(i, tail, own.as_e_f, behind.as_e_f, head.as_e_f, k)
    node.net.as_r_f = net_muscle_force(i, tail, own.as_r_f, behind.as_r_f, head.as_r_f, k)


@inner_kernel
def set_power(nodes: Nodes, k: Coefficients) -> None:
    """Power of each node: net muscle force times speed [M20, eq. 13], k L^2 / tau_theta."""
    tail = nodes.size - 1
    for i in range(nodes.size):
        node, behind = nodes[i], nodes[min(i + 1, tail)].force
        net = net_muscle_force(i, tail, node.force, behind, nodes[0].force, k)
        node.power = abs(net * node.velocity)


@inline_kernel
def measure(nodes: Nodes) -> tuple[float, float]:
    """Find the strain of each segment, contraction positive [M20, eq. 9].

    Returns:
        The centroid, L: mean displacement of the nodes; and the largest change of strain from one segment to
        the next, r_2 of [M20, eq. 11].
    """
    here = nodes[0].displacement
    total, largest, before = here, 0.0, here
    for i in range(1, nodes.size):
        following = nodes[i].displacement
        nodes[i - 1].strain = following - here
        change = abs(following - 2.0 * here + before) if i > 1 else 0.0
        largest = max(largest, change)
        total += following
        before, here = here, following
    return total / nodes.size, largest
