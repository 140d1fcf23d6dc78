"""Where the work of the muscles goes: into springs, dampers, friction, and nowhere else.

One step of implicit Euler balances forces at its end, so the books close to rounding once the energy that
the scheme itself loses, dt^2 / 2 times v A v, is entered too; that loss has to vanish with dt. Friction is
entered as its limit times the speed, whichever way a node slides: a node pushed by its own friction shows.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from crawler_bench.physics import CrawlerParameters
from crawler_bench.physics.as_printed import force_on_nodes, laplacian_of_chain
from tests.bodies import former
from tests.physics.crawling import Crawler, held_at_random

Array = NDArray[np.float64]


def energies_of_a_crawl(p: CrawlerParameters, actions: Sequence[int]) -> Array:
    """Per step: muscle work, spring energy gained, damper loss, friction loss, loss of implicit Euler."""
    crawler, laplacian, rows = Crawler(p), laplacian_of_chain(p.n_segments + 1), []
    nodes = crawler.nodes
    for action in np.repeat(actions, p.steps_per_decision):
        u = nodes["displacement"].copy()
        crawler.advance(action, 1)
        v, end = nodes["velocity"], nodes["displacement"]
        stretching = float(v @ laplacian @ v)
        friction = np.where(v > 0.0, p.forward_limit * v, -p.backward_limit * v)
        rows.append(
            (
                p.dt * float(force_on_nodes(0.0 * v, 0.0 * v, nodes["force"], p.damping, p.head_muscle) @ v),
                0.5 * float(end @ laplacian @ end - u @ laplacian @ u),
                p.dt * p.damping * stretching,
                p.dt * float(friction.sum()),
                0.5 * p.dt**2 * stretching,
            )
        )
    return np.array(rows)


@pytest.mark.parametrize("n_segments", [2, 3, 5, 10, 25])
@pytest.mark.parametrize("head_muscle", ["reaction", "external", "none"])
@pytest.mark.parametrize("friction", [(0.35, 9.0), (0.05, 0.05)])
def test_muscle_work_is_stored_or_lost(
    n_segments: int, head_muscle: str, friction: tuple[float, float]
) -> None:
    """With equal limits all nodes often slide at once, some forward and as many backward."""
    weak = min(1.0, 0.9 * (n_segments + 1) * friction[0])
    p = former(
        n_segments=n_segments, head_muscle=head_muscle, friction_forward=friction[0],
        friction_backward=friction[1], muscle_force_max=weak if head_muscle == "external" else 1.0,
    )  # fmt: skip
    muscle, spring, *losses = energies_of_a_crawl(p, held_at_random(p, 8, 8, seed=9)).T
    np.testing.assert_allclose(muscle, spring + np.sum(losses, axis=0), rtol=0.0, atol=1e-10)
    assert np.sum(muscle) > 1e-3
    assert all(np.all(loss >= 0.0) for loss in losses)


def test_the_loss_of_implicit_euler_vanishes_with_dt() -> None:
    p = former()
    actions = held_at_random(p, 8, 8, seed=9)
    numerical = [energies_of_a_crawl(replace(p, dt=dt), actions)[:, -1].sum() for dt in (0.01, 0.005)]
    total = energies_of_a_crawl(p, actions)[:, 0].sum()
    assert numerical[0] < 0.002 * total
    assert numerical[0] / numerical[1] == pytest.approx(2.0, rel=0.05)
