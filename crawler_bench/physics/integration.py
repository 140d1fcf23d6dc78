"""One decision of the crawler, by the integrator that its parameters name."""

from crawler_bench.physics.coefficients import Coefficients, Stepping
from crawler_bench.physics.compiled import inline_kernel
from crawler_bench.physics.exact.integrator import cross_decision
from crawler_bench.physics.state import Array, Clock, Nodes, dtype_of
from crawler_bench.physics.stepped import advance

STEPPING = dtype_of(Stepping)


@inline_kernel
def act(nodes: Nodes, clock: Clock, action: int, k: Coefficients, steps: Array | None) -> None:
    """Hold one neuron ON for a decision interval.

    Args:
        nodes: changed in place: where the body is; `trajectory.write_state` writes the rest of the state.
        clock: moved on.
        action: the neuron that is ON, 0 to N - 1; neuron N (tail) is ON whenever neuron 0 is [M20, eq. 10].
        k: coefficients.
        steps: `Stepping` as a row of floats, or None: then the stepped integrator is not even compiled.

    Raises:
        ArithmeticError: if the exact integrator gives up and there are no steps to take instead.
    """
    if steps is None:
        if not cross_decision(nodes, clock, action, k):
            raise ArithmeticError("the exact integrator gives up: more events than it follows in a decision")
    elif not (k.exact and cross_decision(nodes, clock, action, k)):
        s = steps.view(STEPPING)[0]
        advance(nodes, action, s.steps, k, s)
