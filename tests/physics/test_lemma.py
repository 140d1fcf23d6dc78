"""The lemma on which root finding rests (docs/physics.md): between events a margin turns at most once.

Margins are taken from the equations of motion themselves: between events eq. 1-5 with dry friction are linear
with constant coefficients, so the matrix exponential of the whole crawler gives every margin at any time, and
nothing of the integrators is used.
"""

from typing import NamedTuple

import numpy as np
from hypothesis import Phase, assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.linalg import expm

from crawler_bench.physics.as_printed import force_on_nodes, laplacian_of_chain

Array = NDArray[np.float64]
FORWARD_LIMIT, BACKWARD_LIMIT = 0.3, 9.0
INSTANTS = 200
ROUNDING = 1e-11  # of the range of a margin: turns that are smaller than this are not counted

generated = settings(max_examples=120, deadline=None, derandomize=True, phases=[Phase.generate])
taus = st.sampled_from([0.2, 0.4, 0.7, 0.7001, 1.0, 1.5, 3.5])


def turns(course: Array) -> int:
    """How often a sampled course changes between rising and falling, rounding aside."""
    smallest = ROUNDING * float(np.max(np.abs(course)))
    count, direction, extreme = 0, 0.0, course[0]
    for value in course[1:]:
        step = value - extreme
        if step * direction > 0.0:
            extreme = value
        elif abs(step) > smallest:
            count += int(direction != 0.0)
            direction, extreme = np.sign(step), value
    return count


def test_turns_are_counted() -> None:
    t = np.linspace(0.0, 1.0, 100)
    assert [turns(np.cos(n * np.pi * t)) for n in (0, 1, 2, 3)] == [0, 0, 1, 2]
    assert turns(t + 1e-13 * np.cos(1e3 * t)) == 0


class Crawler(NamedTuple):
    """A crawler between two events: dx/dt = rates x, with x the drives, forces, displacements and a 1."""

    rates: Array
    start: Array
    slip: Array  # (N + 1,) 1 forward, 0 stuck, -1 backward
    limited: Array  # (N + 1,) whether the drive is above 1


def random_crawler(
    rng: np.random.Generator, n: int, tau_m: Array, tau_f: float, c: float, head_muscle: str
) -> Crawler:
    """Any drives, forces and displacements, with any nodes sliding either way but not all of them."""
    drives, forces, u = rng.uniform(0.0, 2.0, n), rng.uniform(0.0, 1.0, n), rng.normal(0.0, 0.3, n)
    slip, limited = rng.integers(-1, 2, n), drives > 1.0
    slip[rng.integers(n)] = 0
    rest, eye, zero = np.zeros(n), np.eye(n), np.zeros((n, n))
    muscles = np.column_stack([force_on_nodes(rest, rest, each, c, head_muscle) for each in eye])
    friction = np.where(slip > 0, FORWARD_LIMIT, -BACKWARD_LIMIT)
    # Sliding nodes: c A v = B f - A u - friction, all others rest.
    inverse = np.zeros((n, n))
    sliding = np.flatnonzero(slip)
    inverse[np.ix_(sliding, sliding)] = np.linalg.inv(c * laplacian_of_chain(n)[np.ix_(sliding, sliding)])
    rates = np.block(
        [
            [-eye / tau_m[:, None], zero, zero, rest[:, None]],
            [np.diag(~limited) / tau_f, -eye / tau_f, zero, limited[:, None] / tau_f],
            [zero, inverse @ muscles, -inverse @ laplacian_of_chain(n), -(inverse @ friction)[:, None]],
            [np.zeros((1, 3 * n + 1))],
        ]
    )
    return Crawler(rates, np.concatenate((drives, forces, u, [1.0])), slip, limited)


def follow(crawler: Crawler, duration: float) -> Array:
    """(INSTANTS, size of x), equally far apart."""
    step, x = expm(crawler.rates * duration / (INSTANTS - 1)), crawler.start
    path = [x]
    for _ in range(INSTANTS - 1):
        x = step @ x
        path.append(x)
    return np.array(path)


class Course(NamedTuple):
    """What turns at most once: a stuck node's holding force, a sliding node's speed times c exp(t / c)."""

    values: Array  # (INSTANTS,)
    far: float  # where its first slope would take it by the end; a sliding node grows as at the end


def courses(crawler: Crawler, duration: float, c: float, head_muscle: str) -> list[Course]:
    """One course per node."""
    path, n, rates = follow(crawler, duration), crawler.slip.size, crawler.rates
    growth, found = np.exp(np.linspace(0.0, duration, INSTANTS) / c), []
    v = path @ rates.T
    speed, forces = v[:, 2 * n : 3 * n], path[:, n : 2 * n]
    held = [
        force_on_nodes(x[2 * n : 3 * n], each, f, c, head_muscle)
        for x, each, f in zip(path, speed, forces, strict=True)
    ]
    first, second = rates @ path[0], rates @ rates @ path[0]  # derivatives at the start
    held_slope = force_on_nodes(first[2 * n : 3 * n], second[2 * n : 3 * n], first[n : 2 * n], c, head_muscle)
    for i, slip in enumerate(crawler.slip):
        if slip == 0:
            values = np.array(held)[:, i]
            found.append(Course(values, float(values[0] + held_slope[i] * duration)))
        else:
            values = slip * speed[:, i] * c * growth
            w_slope = slip * (c * second[2 * n + i] + first[2 * n + i])
            found.append(Course(values, float(values[0] + growth[-1] * w_slope * duration)))
    return found


def until_the_first_limiter(crawler: Crawler, tau_m: float) -> float:
    """The time at which a drive falls through 1, or 3 if it takes longer."""
    drives = crawler.start[: crawler.slip.size]
    return float(min([3.0, *(tau_m * np.log(drives[crawler.limited]))]))


crawlers = given(
    seed=st.integers(0, 2**32 - 1),
    n=st.integers(3, 8),
    tau_m=taus,
    tau_f=taus,
    c=taus,
    head_muscle=st.sampled_from(["reaction", "external", "none"]),
)


@generated
@crawlers
def test_a_margin_turns_at_most_once_between_events(
    seed: int, n: int, tau_m: float, tau_f: float, c: float, head_muscle: str
) -> None:
    crawler = random_crawler(np.random.default_rng(seed), n, np.full(n, tau_m), tau_f, c, head_muscle)
    duration = until_the_first_limiter(crawler, tau_m)
    assume(duration > 0.05)
    assert all(turns(course.values) <= 1 for course in courses(crawler, duration, c, head_muscle))


@generated
@crawlers
def test_a_margin_stays_above_its_ends_and_its_first_slope(
    seed: int, n: int, tau_m: float, tau_f: float, c: float, head_muscle: str
) -> None:
    """The corollary by which most nodes need no root finding; by symmetry it holds from above, too."""
    crawler = random_crawler(np.random.default_rng(seed), n, np.full(n, tau_m), tau_f, c, head_muscle)
    duration = until_the_first_limiter(crawler, tau_m)
    assume(duration > 0.05)
    for values, far in courses(crawler, duration, c, head_muscle):
        rounding = ROUNDING * np.max(np.abs(values))
        assert values.min() >= min(values[0], values[-1], far) - rounding
        assert values.max() <= max(values[0], values[-1], far) + rounding


def test_many_margins_do_turn() -> None:
    """So the two tests above look at more than monotone courses."""
    found = []
    for seed in range(40):
        crawler = random_crawler(np.random.default_rng(seed), 6, np.full(6, 1.0), 0.7, 3.5, "reaction")
        found += [turns(course.values) for course in courses(crawler, 3.0, 3.5, "reaction")]
    assert np.mean(np.equal(found, 1)) > 0.2


def test_drives_that_decay_at_different_rates_turn_a_margin_twice() -> None:
    """The lemma needs one tau_m for all muscles; this also shows that a second turn would be seen."""
    found = []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        crawler = random_crawler(rng, 6, np.array([0.1, 1.0, 5.0] * 2), 0.7, 3.5, "reaction")
        found += [turns(course.values) for course in courses(crawler, 6.0, 3.5, "reaction")]
    assert max(found) >= 2


@generated
@given(q=st.floats(-2.0, 2.0), r=st.floats(-2.0, 2.0), tau_m=taus, tau_f=taus)
def test_a_force_turns_where_the_closed_form_says(q: float, r: float, tau_m: float, tau_f: float) -> None:
    """q e_f + r r_f is extreme at the turning time of docs/physics.md, if that is a time at all."""
    assume(abs(r) > 0.01)
    t = np.linspace(0.0, 4.0, INSTANTS)
    e_m, e_f = np.exp(-t / tau_m), np.exp(-t / tau_f)
    if tau_m == tau_f:
        r_f, turn = t / tau_f * e_f, tau_f * (1.0 - q / r)
    else:
        o = 1.0 / (1.0 - tau_f / tau_m)
        r_f, ratio = (e_m - e_f) * o, (q - r * o) / (r * (1.0 - o))
        turn = np.log(ratio) / (1.0 / tau_f - 1.0 / tau_m) if ratio > 0.0 else -1.0
    course = q * e_f + r * r_f
    step = t[1]
    if step < turn < t[-1] - step:
        # A maximum if r > 0: the slope over e_f falls where the drive feeds the force.
        assert abs(t[np.argmax(np.sign(r) * course)] - turn) <= step
    else:
        inside = course[2:-2]
        assert turns(inside) == 0
