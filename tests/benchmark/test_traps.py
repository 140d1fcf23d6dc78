"""Known answers of traps: where policies stop, and how drawing leads out."""

from itertools import groupby

import numpy as np
import pytest

from crawler_bench.benchmark.traps import TRAP, absorptions, escapes, stuck_observations, traps
from crawler_bench.config.schema import EvaluationConfig
from crawler_bench.gait.rollout import rollout
from tests.benchmark.frames import tables
from tests.bodies import former

N = 10
PARAMETERS = former()
CONFIG = EvaluationConfig(starts=2, warm_up=50, duration=200)


@pytest.fixture(scope="module")
def trap_shares():
    return traps(PARAMETERS, CONFIG)


def test_traps_lie_beside_the_wave(trap_shares):
    np.testing.assert_array_equal(np.diag(trap_shares), 0)
    assert (np.diag(trap_shares, 1) >= TRAP).all()  # neuron o + 1 leaves segment o contracted


def test_stuck_observations_are_counted(trap_shares):
    one_trap = np.arange(N)
    one_trap[4] = 5
    learned = tables(
        wave={"deterministic": np.eye(N)},
        almost={"deterministic": np.eye(N)[one_trap]},
        random={"stochastic": np.full((N, N), 1 / N)},
    )
    stuck = stuck_observations(learned, trap_shares).set_index("agent")["stuck"]
    assert stuck.to_dict() == {"wave": 0, "almost": 1}


def test_a_constant_policy_is_absorbed_and_the_diagonal_is_not():
    still = np.tile(np.eye(N)[5], (N, 1))
    ends = absorptions(
        tables(still={"deterministic": still}, wave={"deterministic": np.eye(N)}), PARAMETERS, CONFIG
    ).set_index("agent")
    assert ends.loc["still", ["absorbed", "stalled"]].to_numpy().all()
    assert (ends.loc["still", ["observation", "action"]].to_numpy() == [4, 5]).all()
    assert (ends.loc["still", "time"] < 100).all()
    assert not ends.loc["wave", ["absorbed", "stalled"]].to_numpy().any()
    assert ends.loc["wave", "time"].isna().all()


def test_most_tables_end_in_the_traps_of_the_map(trap_shares):
    rng = np.random.default_rng(5)
    random = {f"random{i}": {"deterministic": np.eye(N)[rng.integers(N, size=N)]} for i in range(30)}
    ends = absorptions(tables(**random), PARAMETERS, EvaluationConfig(starts=2))
    assert ends["absorbed"].mean() > 0.8
    absorbed = ends[ends["absorbed"]]
    assert absorbed["stalled"].mean() > 0.95
    foretold = trap_shares[absorbed["observation"], absorbed["action"]] >= TRAP
    assert foretold.mean() > 0.8


def test_a_drawing_policy_leaves_the_trap_that_absorbs_its_favourite_actions():
    still = np.tile(np.eye(N)[5], (N, 1))
    mixed = 0.2 * still + 0.8 / N
    learned = tables(
        drawn={"deterministic": still, "stochastic": mixed}, sure={"deterministic": still},
        wave={"deterministic": np.eye(N), "stochastic": mixed},
    )  # fmt: skip
    ends = absorptions(learned, PARAMETERS, CONFIG)
    (row,) = escapes(ends, learned, PARAMETERS, CONFIG).to_dict("records")
    assert (row["agent"], row["observation"], row["action"], row["starts"]) == ("drawn", 4, 5, 1)
    assert row["other_action"] == pytest.approx(0.72)
    crawls = [observed(mixed, start) for start in range(CONFIG.starts)]
    left = sum([observation for observation, _ in groupby(seen)][:-1].count(4) for seen in crawls)
    spent = sum((seen[:-1] == 4).sum() for seen in crawls) * PARAMETERS.decision_interval
    assert row["leaving_rate"] == pytest.approx(left / spent)
    assert row["occupancy"] == pytest.approx(spent / CONFIG.starts / CONFIG.duration)


def observed(table, start):
    record = rollout(
        PARAMETERS, table, warm_up=CONFIG.warm_up, duration=CONFIG.duration, noise=0.0,
        start=(CONFIG.seed, start), policy_seed=3,
    )  # fmt: skip
    return record.strain.argmax(axis=1)
