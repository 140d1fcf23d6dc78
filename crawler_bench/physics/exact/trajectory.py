"""The trajectory of muscles and body from one event to the next, in closed form.

All times count from an *epoch*, at which the responses of relaxation.py start. Muscle forces and net muscle
forces are sums p + q e_f + r r_f of *terms*. So is w = c du/dt + k u on the nodes that slide, by the force
balance of body.py, and each displacement relaxes towards its w with time constant c / k. What an event
changes is written as what it *would have been at the epoch*, had it always moved as it does now, so that an
event concerns only those that it changes. Rounding errors grow with the time since the epoch; so, every few
decisions, a new epoch begins, which changes no motion, only the time it counts from.
"""

from crawler_bench.physics.body import STUCK, holding_force, solve_sliding, stand_still
from crawler_bench.physics.coefficients import Coefficients
from crawler_bench.physics.compiled import inline_kernel, inner_kernel
from crawler_bench.physics.crawler import set_net_force
from crawler_bench.physics.muscle import flush, time_in_limiter
from crawler_bench.physics.neuron import cotangent, tangent
from crawler_bench.physics.relaxation import START, Response
from crawler_bench.physics.state import Clock, Node, Nodes, Terms
from crawler_bench.physics.tolerances import NEGLIGIBLE, NEVER


@inline_kernel
def read_clock(clock: Clock) -> Response:
    """The responses at the time up to which the trajectory has been followed."""
    now = clock.now
    return Response(now.time, now.e_m, now.e_f, now.r_f, now.e_c, now.s_f, now.s_r)


@inline_kernel
def store_clock(clock: Clock, now: Response) -> None:
    """Note the time up to which the trajectory has been followed."""
    to = clock.now
    to.time, to.e_m, to.e_f, to.r_f = now.time, now.e_m, now.e_f, now.r_f  # type: ignore[misc]
    to.e_c, to.s_f, to.s_r = now.e_c, now.s_f, now.s_r  # type: ignore[misc]


@inline_kernel
def force_at(terms: Terms, now: Response) -> float:
    """What a sum of terms is now."""
    return terms.constant + terms.as_e_f * now.e_f + terms.as_r_f * now.r_f


@inline_kernel
def position(node: Node, now: Response) -> float:
    """Displacement of a sliding node now: c du/dt + k u = w."""
    return (
        node.displacement_at_epoch * now.e_c
        + node.w.constant * (1.0 - now.e_c)
        + node.w.as_e_f * now.s_f
        + node.w.as_r_f * now.s_r
    )


@inner_kernel
def initialize(nodes: Nodes, clock: Clock, k: Coefficients) -> None:
    """Begin the trajectory of a crawler from its state alone; the epoch is now."""
    for node in nodes:
        node.displacement_at_epoch = node.displacement
        node.cotangent_at_epoch = cotangent(node.neuron)
        spikes = k.spike_at_pi and node.neuron > 0.0
        node.spike_time = node.cotangent_at_epoch / k.neuron_rate if spikes else NEVER
        node.limit_time = time_in_limiter(node.drive, k.tau_m)
        set_muscle_terms(node, node.drive, node.force, START, k)
        stand_still(node, node.displacement)  # what an earlier trajectory left may not even be a number
    for i in range(nodes.size):
        set_net_force(nodes, i, k)
    set_trajectory(nodes, 0, nodes.size - 1, -1, START, k)
    clock.has_trajectory = 1.0
    store_clock(clock, START)


@inline_kernel
def set_muscle_terms(node: Node, drive: float, force: float, now: Response, k: Coefficients) -> None:
    """Let a muscle go on from the drive and the force that it has now [M20, eq. 4-5]."""
    charge = drive / now.e_m
    limited = drive > 1.0
    constant, as_r_f = (k.force_max, 0.0) if limited else (0.0, k.force_max * charge)
    node.drive_at_epoch, node.muscle.constant, node.muscle.as_r_f = charge, constant, as_r_f
    node.muscle.as_e_f = (force - constant - as_r_f * now.r_f) / now.e_f


@inline_kernel
def set_trajectory(nodes: Nodes, low: int, high: int, changed: int, now: Response, k: Coefficients) -> None:
    """Let the nodes from `low` to `high` go on from where they are under new net forces and slip states.

    Args:
        nodes: the trajectory up to now.
        low: the first node, which is at the head or stuck.
        high: the last node, which is at the tail or stuck.
        changed: the node that starts or stops sliding now, whose displacement_at_epoch is where it is; or -1.
        now: the responses.
        k: coefficients.
    """
    any_slides = False
    for i in range(low, high + 1):
        node = nodes[i]
        if node.slip == STUCK:
            stand_still(node, node.displacement_at_epoch)
        else:
            any_slides = True
            if i != changed:
                node.displacement_at_epoch = position(node, now)
    if any_slides:
        solve_sliding(nodes, low, high, k)
        growth = 1.0 / now.e_c
        for i in range(low, high + 1):
            node = nodes[i]
            if node.slip != STUCK:
                relaxed = node.displacement_at_epoch - node.w.constant * (1.0 - now.e_c)
                relaxed = relaxed - node.w.as_e_f * now.s_f - node.w.as_r_f * now.s_r
                node.displacement_at_epoch = relaxed * growth
    for i in range(low, high + 1):
        set_margin(nodes, i)


@inline_kernel
def set_margin(nodes: Nodes, i: int) -> None:
    """Find what keeps node i in its slip state.

    Of a stuck node, the force that holds it, as its terms; of a sliding one, its velocity in its direction,
    times c, whose constant term goes as e_c.
    """
    node = nodes[i]
    if node.slip == STUCK:
        constant, as_e_f, as_r_f = holding_force(nodes, i)
    else:
        constant = node.slip * (node.w.constant - node.displacement_at_epoch)
        as_e_f, as_r_f = node.slip * node.w.as_e_f, node.slip * node.w.as_r_f
    node.margin.constant, node.margin.as_e_f, node.margin.as_r_f = constant, as_e_f, as_r_f


@inner_kernel
def begin_epoch(nodes: Nodes, clock: Clock, now: Response, k: Coefficients) -> None:
    """Count from now on."""
    for node in nodes:
        if node.slip != STUCK:
            node.displacement_at_epoch = position(node, now)
        restart(node.muscle, now)
        restart(node.net, now)
        restart(node.w, now)
        node.drive_at_epoch = flush(node.drive_at_epoch * now.e_m)
        node.cotangent_at_epoch -= k.neuron_rate * now.time
        node.spike_time -= now.time
        node.limit_time -= now.time
    for i in range(nodes.size):
        set_margin(nodes, i)
    store_clock(clock, START)


@inline_kernel
def restart(terms: Terms, now: Response) -> None:
    """Count from now on in a sum of terms, negligible ones being 0."""
    as_e_f, as_r_f = terms.as_e_f * now.e_f + terms.as_r_f * now.r_f, terms.as_r_f * now.e_m
    terms.as_e_f = as_e_f if abs(as_e_f) > NEGLIGIBLE else 0.0
    terms.as_r_f = as_r_f if abs(as_r_f) > NEGLIGIBLE else 0.0


@inline_kernel
def write_positions(nodes: Nodes, now: Response) -> None:
    """Write where all nodes are now."""
    for node in nodes:
        node.displacement = position(node, now) if node.slip != STUCK else node.displacement_at_epoch


@inner_kernel
def write_state(nodes: Nodes, clock: Clock, k: Coefficients) -> None:
    """Write the rest of the state at the clock's time; without a trajectory it is there."""
    if clock.has_trajectory == 0.0:
        return
    now = read_clock(clock)
    for node in nodes:
        node.neuron = tangent(node.cotangent_at_epoch - k.neuron_rate * now.time)
        node.drive = flush(node.drive_at_epoch * now.e_m)
        node.force = flush(force_at(node.muscle, now))
        moving = (force_at(node.w, now) - node.displacement) * k.times.rate_c
        node.velocity = moving if node.slip != STUCK else 0.0
