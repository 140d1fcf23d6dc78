"""The course of muscles and body from one event to the next, in closed form, for exact.py.

All times count from an *epoch*, at which responses start (see response.py). Muscle forces and net muscle
forces are p + q e_f + r r_f. On the nodes S that slide, the force w = c du/dt + k u obeys the balance

    A_SS w_S = (B f - friction)_S - A_S,stuck u_stuck,

so w is such a sum too, and each displacement relaxes towards its w with time constant c / k. What changes
course at an event is written as what it *would have been at the epoch*, had it always followed its new
course, so that an event concerns only those that change course. Rounding errors grow with the time since the
epoch; so, every few decisions, a new epoch begins, which changes no course, only the time it counts from.
"""

import math

import numpy as np

from crawler_bench.physics.body import FORWARD, STUCK
from crawler_bench.physics.coefficients import Coefficients
from crawler_bench.physics.compilation import inner_kernel, step_kernel
from crawler_bench.physics.layout import (
    CHARGE,
    CLOCK,
    DISPLACEMENT,
    DRIVE,
    EPOCH,
    FORCE,
    HOLD,
    HOLD_F,
    HOLD_R,
    IS_LAID,
    LIMIT_AT,
    NET,
    NET_F,
    NET_R,
    NEURON,
    NEVER,
    ORIGIN,
    PHASE,
    PULL,
    PULL_F,
    PULL_R,
    RESPONSES,
    SLIP,
    SPIKE_AT,
    VELOCITY,
    W_F,
    W_R,
    WORK,
    Memory,
    W,
)
from crawler_bench.physics.muscle import NEGLIGIBLE, flush
from crawler_bench.physics.neuron import cotangent, tangent
from crawler_bench.physics.response import START, Response


@inner_kernel
def responses(memory: Memory) -> Response:
    """The responses at the time up to which the course has been followed."""
    first, second = memory[RESPONSES], memory[RESPONSES + 1]
    return Response(first[0], first[1], first[2], second[0], second[1], second[2])


@inner_kernel
def arrive(memory: Memory, clock: float, now: Response) -> None:
    """Note the time up to which the course has been followed."""
    first, second = memory[RESPONSES], memory[RESPONSES + 1]
    memory[EPOCH, CLOCK] = clock
    first[0], first[1], first[2] = now.e_m, now.e_f, now.r_f
    second[0], second[1], second[2] = now.e_c, now.s_f, now.s_r


@step_kernel
def lay(memory: Memory, k: Coefficients) -> None:
    """Lay the course of a crawler of which the state alone is known; the epoch is now."""
    tail = memory.shape[1] - 1
    for i in range(tail + 1):
        V, F, f = memory[NEURON, i], memory[DRIVE, i], memory[FORCE, i]
        memory[ORIGIN, i] = memory[DISPLACEMENT, i]
        memory[PHASE, i] = cotangent(V)
        spikes = k.spike_at_pi and V > 0.0
        memory[SPIKE_AT, i] = memory[PHASE, i] / k.neuron_rate if spikes else NEVER
        memory[LIMIT_AT, i] = k.tau_m * math.log(F) if F > 1.0 else NEVER
        bend(memory, i, F, f, START, k)
    for i in range(tail + 1):
        add_up(memory, i, k)
    memory[W : W_R + 1] = 0.0  # what an earlier course left may not even be a number
    set_course(memory, 0, tail, -1, START, k)
    for i in range(tail + 1):
        hold(memory, i)
    memory[EPOCH, IS_LAID] = 1.0
    arrive(memory, 0.0, START)


@inner_kernel
def bend(memory: Memory, i: int, drive: float, force: float, now: Response, k: Coefficients) -> None:
    """Put muscle i, whose drive and force now are given, on its course."""
    memory[CHARGE, i] = charge = drive / now.e_m
    limited = drive > 1.0
    constant, as_r_f = (k.force_max, 0.0) if limited else (0.0, k.force_max * charge)
    memory[PULL, i], memory[PULL_R, i] = constant, as_r_f
    memory[PULL_F, i] = (force - constant - as_r_f * now.r_f) / now.e_f


@inner_kernel
def add_up(memory: Memory, i: int, k: Coefficients) -> None:
    """Net muscle force on node i, row i of B f [M20, eq. 1-3]."""
    for part in range(3):
        pull, net = memory[PULL + part], memory[NET + part]
        share = k.pull_on_head if i == 0 else 1.0
        total = share * pull[i]
        if i < pull.size - 1:
            total -= pull[i + 1]
        if i == 1:
            total += k.pull_on_neck * pull[0]
        net[i] = total


@inner_kernel
def position(memory: Memory, n: int, now: Response) -> float:
    """Displacement of node n now, if it slides."""
    i = np.uint64(n)  # an index without sign needs no check for one below 0
    u = memory[ORIGIN, i] * now.e_c + memory[W, i] * (1.0 - now.e_c)
    return float(u + memory[W_F, i] * now.s_f + memory[W_R, i] * now.s_r)


@inner_kernel
def set_course(memory: Memory, low: int, high: int, fresh: int, now: Response, k: Coefficients) -> None:
    """Find w of the nodes from `low` to `high` by the Thomas algorithm; let displacements follow it.

    Args:
        memory: the course up to now; ORIGIN of nodes that do not slide any more is where they are.
        low: the first node, which is at the head or stuck.
        high: the last node, which is at the tail or stuck.
        fresh: the node that starts or stops sliding now, or -1; if it slides, ORIGIN is where it is.
        now: the responses.
        k: coefficients.
    """
    u, slip, last, pivot = memory[ORIGIN], memory[SLIP], memory.shape[1] - 1, memory[WORK]
    net, net_f, net_r, w, w_f, w_r = (
        memory[NET], memory[NET_F], memory[NET_R], memory[W], memory[W_F], memory[W_R],
    )  # fmt: skip
    any_slides = False
    above, above_f, above_r, taken = 0.0, 0.0, 0.0, 0.0  # what row n - 1 adds, and takes off the diagonal
    for n in range(low, high + 1):
        i = np.uint64(n)
        if slip[i] == STUCK:
            above, above_f, above_r, taken = u[i], 0.0, 0.0, 0.0
        else:
            any_slides = True
            degree = 1.0 if n == 0 or n == last else 2.0
            friction = k.forward if slip[i] == FORWARD else -k.backward
            taken = 1.0 / (degree - taken)
            u[i] = u[i] if n == fresh else position(memory, n, now)
            above = taken * (net[i] - friction + above)
            above_f, above_r = taken * (net_f[i] + above_f), taken * (net_r[i] + above_r)
        w[i], w_f[i], w_r[i], pivot[i] = above, above_f, above_r, taken  # on a stuck node w is u
    if not any_slides:
        return
    growth = 1.0 / now.e_c
    after, after_f, after_r = 0.0, 0.0, 0.0  # w of node n + 1
    for n in range(high, low - 1, -1):
        i = np.uint64(n)
        if slip[i] != STUCK:
            w[i] += pivot[i] * after
            w_f[i] += pivot[i] * after_f
            w_r[i] += pivot[i] * after_r
            u[i] = (u[i] - w[i] * (1.0 - now.e_c) - w_f[i] * now.s_f - w_r[i] * now.s_r) * growth
        after, after_f, after_r = w[i], w_f[i], w_r[i]


@inner_kernel
def hold(memory: Memory, n: int) -> tuple[float, float, float]:
    """Find what keeps node n in its state; note it.

    Returns:
        Force that holds a stuck node; velocity of a sliding one in its direction, times c; as its parts.
    """
    i, slip = np.uint64(n), memory[SLIP, np.uint64(n)]
    if slip == STUCK:
        last = memory.shape[1] - 1  # beyond an end it meets itself, as w is u there
        above, below = np.uint64(max(n - 1, 0)), np.uint64(min(n + 1, last))
        p = memory[NET, i] + (memory[W, above] + memory[W, below] - 2.0 * memory[ORIGIN, i])
        q_f = memory[NET_F, i] + memory[W_F, above] + memory[W_F, below]
        q_r = memory[NET_R, i] + memory[W_R, above] + memory[W_R, below]
    else:
        p = slip * (memory[W, i] - memory[ORIGIN, i])
        q_f, q_r = slip * memory[W_F, i], slip * memory[W_R, i]
    memory[HOLD, i], memory[HOLD_F, i], memory[HOLD_R, i] = p, q_f, q_r
    return p, q_f, q_r


@inner_kernel
def settle(memory: Memory, row: int, now: Response) -> None:
    """Write to a row where all nodes are now; it may be ORIGIN."""
    for i in range(memory.shape[1]):  # without branches, so that it is done for several nodes at a time
        there = position(memory, i, now)
        memory[row, i] = there if memory[SLIP, i] != STUCK else memory[ORIGIN, i]


@inner_kernel
def _or_zero(part: float) -> float:
    """Part of a force, or 0 where it is negligible."""
    return part if abs(part) > NEGLIGIBLE else 0.0


@step_kernel
def begin_epoch(memory: Memory, clock: float, now: Response, k: Coefficients) -> None:
    """Count from `clock` on, at which the responses are `now`; find HOLD anew."""
    tail = memory.shape[1] - 1
    settle(memory, ORIGIN, now)
    for part in (PULL, NET, W):
        as_e_f, as_r_f = memory[part + 1], memory[part + 2]
        for i in range(tail + 1):
            as_e_f[i] = _or_zero(as_e_f[i] * now.e_f + as_r_f[i] * now.r_f)
            as_r_f[i] = _or_zero(as_r_f[i] * now.e_m)
    for i in range(tail + 1):
        memory[CHARGE, i] = flush(memory[CHARGE, i] * now.e_m)
        memory[PHASE, i] -= k.neuron_rate * clock
        memory[SPIKE_AT, i] -= clock
        memory[LIMIT_AT, i] -= clock
        hold(memory, i)
    arrive(memory, 0.0, START)


@step_kernel
def report(memory: Memory, k: Coefficients) -> None:
    """Write the state, of which the course tells all; without a course it is there."""
    if memory[EPOCH, IS_LAID] == 0.0:
        return
    now, turned = responses(memory), k.neuron_rate * memory[EPOCH, CLOCK]
    for i in range(memory.shape[1]):
        memory[NEURON, i] = tangent(memory[PHASE, i] - turned)
        memory[DRIVE, i] = flush(memory[CHARGE, i] * now.e_m)
        force = memory[PULL, i] + memory[PULL_F, i] * now.e_f + memory[PULL_R, i] * now.r_f
        memory[FORCE, i] = flush(force)
        w = memory[W, i] + memory[W_F, i] * now.e_f + memory[W_R, i] * now.r_f
        moving = (w - memory[DISPLACEMENT, i]) * k.times.rate_c
        memory[VELOCITY, i] = moving if memory[SLIP, i] != STUCK else 0.0
