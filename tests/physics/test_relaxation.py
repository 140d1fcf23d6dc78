"""The responses to decays, against the exponential of the matrix whose equations they solve."""

import numpy as np
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from crawler_bench.physics.relaxation import after, relaxation, respond, respond_near


@settings(max_examples=60, deadline=None, derandomize=True, phases=[Phase.generate])
@given(
    time=st.floats(0.0, 30.0),
    taus=st.tuples(*[st.sampled_from([0.05, 0.7, 0.7003, 0.701, 1.0, 1.0 + 1e-9, 1.01, 3.5])] * 3),
)
def test_responses_solve_their_equations(time: float, taus: tuple[float, float, float]) -> None:
    """Against the exponential of the cascade's matrix."""
    tau_m, tau_f, c = taus
    cascade = np.array([[-1 / tau_m, 0, 0], [1 / tau_f, -1 / tau_f, 0], [0, 1 / c, -1 / c]])
    solution = expm(cascade * time)
    now = respond(time, relaxation(tau_m, tau_f, c))
    expected = solution[[0, 1, 1, 2, 2, 2], [0, 1, 0, 2, 1, 0]]
    np.testing.assert_allclose(now[1:], expected, atol=2e-13)


@settings(max_examples=60, deadline=None, derandomize=True, phases=[Phase.generate])
@given(
    times=st.tuples(st.floats(0.0, 5.0), st.floats(-1e-3, 1e-3)),
    taus=st.tuples(*[st.sampled_from([0.6, 0.7, 0.701, 1.0, 1.0 + 1e-9, 3.5])] * 3),
)
def test_responses_are_carried_on_from_one_time_to_another(
    times: tuple[float, float], taus: tuple[float, float, float]
) -> None:
    """From any time to a later one, and without exponentials to one nearby, before or after."""
    (time, step), constants = times, relaxation(*taus)
    known = respond(time, constants)
    np.testing.assert_allclose(
        after(known, respond(0.3, constants)), respond(time + 0.3, constants), atol=2e-13
    )
    near = respond_near(known, time + step, constants)
    np.testing.assert_allclose(near, respond(time + step, constants), atol=2e-13)
