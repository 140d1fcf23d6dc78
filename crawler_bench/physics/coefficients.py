"""The parameters as the kernels need them: numbers computed once, read by name."""

import math
import warnings
from typing import Any, NamedTuple

import numpy as np

from crawler_bench.physics.muscle import follow
from crawler_bench.physics.parameters import CrawlerParameters
from crawler_bench.physics.relaxation import Relaxation, Response, relaxation, respond
from crawler_bench.physics.state import Array, dtype_of
from crawler_bench.physics.tolerances import EQUAL_FRICTION, EVENT, LONGEST_EPOCH


class Coefficients(NamedTuple):
    """What both integrators need."""

    exact: bool  # integrate from event to event, or in steps of dt
    damping: float  # c / k
    forward: float  # friction limits, k L
    backward: float
    may_balance: bool  # whether friction can balance with every node sliding
    pull_on_head: float  # share of f_0 that acts on node 0 and on node 1 (reading `head_muscle`)
    pull_on_neck: float
    neuron_rate: float
    spike_at_pi: bool  # where theta passes pi, 2 pi, or both (reading `spike_phase`)
    spike_at_2pi: bool
    spike_gain: float
    tau_m: float
    tau_f: float
    force_max: float
    contraction_sign: float  # of the strain whose argmax is observed (reading `observation`)
    # The exact integrator.
    decision: float  # decision interval
    sin_rate_decision: float
    cos_rate_decision: float
    times: Relaxation
    end: Response  # the responses at the end of a decision
    longest: float  # time after an epoch at which another begins
    horizon: float  # the decisions that fit into it, or one
    tolerance: float  # of events


class Stepping(NamedTuple):
    """What the stepped integrator needs besides."""

    dt: float
    steps: int  # in a decision
    tan_rate_dt: float
    drive_decay: float  # factor of a drive in a step
    force_decay: float  # factor of a force in a step
    force_gain: float  # what a step adds to a force, k L, per unit of its drive
    limited_force_gain: float  # what a step adds to a force whose drive is above 1


def coefficients(parameters: CrawlerParameters, tolerance: float = EVENT) -> Coefficients:
    """Prepare the parameters for the kernels."""
    p = parameters
    times = relaxation(p.tau_m, p.tau_f, p.damping)
    turn = p.neuron_rate * p.decision_interval
    if p.integrator == "exact" and may_balance(p):
        warnings.warn(
            f"friction can balance with every node sliding (n_segments = {p.n_segments}, friction "
            f"{p.forward_limit:g} and {p.backward_limit:g}): while fewer than two nodes stick, the exact "
            f"integrator takes Euler steps of dt = {p.dt:g}; a smaller dt is more accurate",
            stacklevel=2,
        )
    longest = LONGEST_EPOCH * min(p.tau_m, p.tau_f, p.damping)
    return Coefficients(
        exact=p.integrator == "exact",
        damping=p.damping,
        forward=p.forward_limit,
        backward=p.backward_limit,
        may_balance=may_balance(p),
        pull_on_head=0.0 if p.head_muscle == "none" else 1.0,
        pull_on_neck=-1.0 if p.head_muscle == "reaction" else 0.0,
        neuron_rate=p.neuron_rate,
        spike_at_pi=p.spike_phase != "2pi",
        spike_at_2pi=p.spike_phase != "pi",
        spike_gain=p.spike_gain,
        tau_m=p.tau_m,
        tau_f=p.tau_f,
        force_max=p.muscle_force_max,
        contraction_sign=1.0 if p.observation == "most_contracted" else -1.0,
        decision=p.decision_interval,
        sin_rate_decision=math.sin(turn),
        cos_rate_decision=math.cos(turn),
        times=times,
        end=respond(p.decision_interval, times),
        longest=longest,
        horizon=p.decision_interval * max(1, math.floor(longest / p.decision_interval)),
        tolerance=tolerance,
    )


def stepping(parameters: CrawlerParameters) -> Stepping:
    """Prepare what steps of dt need."""
    p = parameters
    return Stepping(
        dt=p.dt,
        steps=p.steps_per_decision,
        tan_rate_dt=math.tan(p.neuron_rate * p.dt),
        drive_decay=math.exp(-p.dt / p.tau_m),
        force_decay=math.exp(-p.dt / p.tau_f),
        force_gain=p.muscle_force_max * follow(p.dt, p.tau_m, p.tau_f),
        limited_force_gain=-p.muscle_force_max * math.expm1(-p.dt / p.tau_f),
    )


def may_balance(p: CrawlerParameters) -> bool:
    """Whether some nodes that slide forward and all others backward meet the same total friction."""
    nodes = p.n_segments + 1
    return any(
        math.isclose(n * p.forward_limit, (nodes - n) * p.backward_limit, rel_tol=EQUAL_FRICTION)
        for n in range(1, nodes)
    )


def as_record(values: Any) -> Any:
    """A named tuple, with those inside it, as a NumPy record of the same names: one pointer for kernels."""
    kind: Any = type(values)
    return np.array(tuple(values), dtype=dtype_of(kind))[()]


def as_floats(values: Any) -> Array:
    """A named tuple as a row of floats, (n,), which is cheap to hand to a kernel; its view is the record."""
    return np.frombuffer(as_record(values).tobytes(), dtype=np.float64).copy()
