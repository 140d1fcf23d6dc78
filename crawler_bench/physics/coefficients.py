"""The parameters as the kernels need them."""

import math
from typing import NamedTuple

from crawler_bench.physics.parameters import CrawlerParameters
from crawler_bench.physics.response import Relaxation, Response, follow, relaxation, respond

EVENT_TOLERANCE = 1e-13  # of forces, velocities and times at which a node starts or stops sliding

_LONGEST = 2.0  # in units of the shortest time constant: rounding errors grow by its exponential


class Coefficients(NamedTuple):
    """Numbers that the kernels need, computed once from the parameters."""

    exact: bool  # integrate from event to event, or in steps of dt
    dt: float
    decision: float  # decision interval
    damping: float  # c / k
    stiffness: float  # c + dt, the factor of the Laplacian in an implicit Euler step
    forward: float  # friction limits, k L
    backward: float
    may_balance: bool  # whether friction can balance with every node sliding
    pull_on_head: float  # share of f_0 that acts on node 0 and on node 1 (reading `head_muscle`)
    pull_on_neck: float
    neuron_rate: float
    tan_rate_dt: float
    sin_rate_decision: float
    cos_rate_decision: float
    spike_at_pi: bool
    spike_gain: float
    tau_m: float
    tau_f: float
    force_max: float
    drive_decay: float  # exp(-dt / tau_m)
    force_decay: float  # exp(-dt / tau_f)
    force_gain: float  # force after dt per unit of drive at its start
    limited_force_gain: float  # force after dt of a drive above 1
    times: Relaxation
    end: Response  # the responses at the end of a decision
    longest: float  # time after an epoch at which the exact integrator begins another
    horizon: float  # the decisions that fit into it, or one
    tolerance: float  # of events
    contraction_sign: float  # of the strain whose argmax is observed (reading `observation`)


def coefficients(parameters: CrawlerParameters, tolerance: float = EVENT_TOLERANCE) -> Coefficients:
    """Prepare the parameters for the kernels."""
    p = parameters
    times = relaxation(p.tau_m, p.tau_f, p.damping)
    turn = p.neuron_rate * p.decision_interval
    longest = _LONGEST * min(p.tau_m, p.tau_f, p.damping)
    horizon = p.decision_interval * max(1, math.floor(longest / p.decision_interval))
    return Coefficients(
        exact=p.integrator == "exact",
        dt=p.dt,
        decision=p.decision_interval,
        damping=p.damping,
        stiffness=p.damping + p.dt,
        forward=p.forward_limit,
        backward=p.backward_limit,
        may_balance=_may_balance(p),
        pull_on_head=0.0 if p.head_muscle == "none" else 1.0,
        pull_on_neck=-1.0 if p.head_muscle == "reaction" else 0.0,
        neuron_rate=p.neuron_rate,
        tan_rate_dt=math.tan(p.neuron_rate * p.dt),
        sin_rate_decision=math.sin(turn),
        cos_rate_decision=math.cos(turn),
        spike_at_pi=p.spike_phase == "pi",
        spike_gain=p.spike_gain,
        tau_m=p.tau_m,
        tau_f=p.tau_f,
        force_max=p.muscle_force_max,
        drive_decay=math.exp(-p.dt / p.tau_m),
        force_decay=math.exp(-p.dt / p.tau_f),
        force_gain=p.muscle_force_max * follow(p.dt, p.tau_m, p.tau_f),
        limited_force_gain=-p.muscle_force_max * math.expm1(-p.dt / p.tau_f),
        times=times,
        end=respond(p.decision_interval, times),
        longest=longest,
        horizon=horizon,
        tolerance=tolerance,
        contraction_sign=1.0 if p.observation == "most_contracted" else -1.0,
    )


def _may_balance(p: CrawlerParameters) -> bool:
    """Whether some nodes that slide forward and all others backward meet the same total friction."""
    nodes = p.n_segments + 1
    return any(
        math.isclose(n * p.forward_limit, (nodes - n) * p.backward_limit, rel_tol=1e-9)
        for n in range(1, nodes)
    )
