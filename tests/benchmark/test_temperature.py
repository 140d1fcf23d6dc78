"""Known answers of softened policies and of traps."""

import numpy as np
import pandas as pd
import pytest

from crawler_bench.benchmark import temperature as module
from crawler_bench.config.schema import EvaluationConfig
from crawler_bench.gait import metrics
from crawler_bench.gait.rollout import rollout
from crawler_bench.physics.parameters import CrawlerParameters

N = 10
PARAMETERS = CrawlerParameters()
CONFIG = EvaluationConfig(starts=2, warm_up=50, duration=200)


def random_table(seed=0):
    table = np.random.default_rng(seed).random((N, N))
    return table / table.sum(axis=1, keepdims=True)


def frame(**by_agent):
    """Tables as the benchmark holds them: agent=(mode, table)."""
    return pd.concat(
        pd.DataFrame(table, columns=[f"p_{action}" for action in range(N)]).assign(
            agent=agent, mode=mode, regularization=0.0, seed=3, observation=range(N)
        )
        for agent, modes in by_agent.items()
        for mode, table in modes.items()
    )


@pytest.fixture(scope="module")
def trap_shares():
    return module.traps(PARAMETERS, CONFIG)


def test_temperature_one_returns_the_table():
    np.testing.assert_array_equal(module.soften(random_table(), 1), random_table())


@pytest.mark.parametrize("temperature", [0, 1e-6])
def test_without_temperature_the_favourite_action_is_sure(temperature):
    sure = module.soften(random_table(), temperature)
    np.testing.assert_allclose(sure, np.eye(N)[random_table().argmax(axis=1)], atol=1e-12)


@pytest.mark.parametrize("temperature", [1e6, np.inf])
def test_at_infinite_temperature_action_is_random(temperature):
    np.testing.assert_allclose(module.soften(random_table(), temperature), 1 / N, atol=1e-5)


def test_even_actions_that_are_never_taken_are_random_at_infinity():
    np.testing.assert_allclose(module.soften(np.eye(N), np.inf), 1 / N)


@pytest.mark.parametrize("temperature", [0, 0.25, 3])
def test_a_random_policy_and_a_sure_one_stay_what_they_are(temperature):
    for table in (np.full((N, N), 1 / N), np.eye(N)):
        np.testing.assert_allclose(module.soften(table, temperature), table)


def test_half_the_temperature_squares_the_odds():
    table = np.array([[0.8, 0.2], [0.5, 0.5]])
    np.testing.assert_allclose(module.soften(table, 0.5), [[16 / 17, 1 / 17], [0.5, 0.5]])


@pytest.mark.parametrize("temperature", [-1, np.nan])
def test_impossible_temperatures(temperature):
    with pytest.raises(ValueError, match="at least 0"):
        module.soften(random_table(), temperature)


def test_speed_at_temperature_one_is_the_evaluations():
    tables = frame(
        drawn={"deterministic": np.eye(N), "stochastic": random_table()}, sure={"deterministic": np.eye(N)}
    )
    speeds = module.speed_against_temperature(tables, PARAMETERS, CONFIG, [0, 1])
    assert speeds["agent"].tolist() == ["drawn"] * 2
    assert list(speeds) == ["agent", "regularization", "seed", "temperature", "speed", "stall_share"]
    crawl = {"warm_up": 50, "duration": 200, "noise": 0, "policy_seed": 3}
    records = [rollout(PARAMETERS, random_table(), start=(2020, start), **crawl) for start in range(2)]
    expected = [metrics.speed(record) for record in records]
    assert speeds["speed"][1] == np.mean(expected)


def test_traps_lie_beside_the_wave(trap_shares):
    np.testing.assert_array_equal(np.diag(trap_shares), 0)
    assert (np.diag(trap_shares, 1) >= module.TRAP).all()  # neuron o + 1 leaves segment o contracted


def test_stuck_observations_are_counted(trap_shares):
    one_trap = np.arange(N)
    one_trap[4] = 5
    tables = frame(
        wave={"deterministic": np.eye(N)},
        almost={"deterministic": np.eye(N)[one_trap]},
        random={"stochastic": np.full((N, N), 1 / N)},
    )
    stuck = module.stuck_observations(tables, trap_shares).set_index("agent")["stuck"]
    assert stuck.to_dict() == {"wave": 0, "almost": 1}


def test_a_constant_policy_is_absorbed_and_the_diagonal_is_not():
    still = np.tile(np.eye(N)[5], (N, 1))
    ends = module.absorptions(
        frame(still={"deterministic": still}, wave={"deterministic": np.eye(N)}), PARAMETERS, CONFIG
    ).set_index("agent")
    assert ends.loc["still", ["absorbed", "stalled"]].to_numpy().all()
    assert (ends.loc["still", ["observation", "action"]].to_numpy() == [4, 5]).all()
    assert (ends.loc["still", "time"] < 100).all()
    assert not ends.loc["wave", ["absorbed", "stalled"]].to_numpy().any()
    assert ends.loc["wave", "time"].isna().all()


def test_most_tables_end_in_the_traps_of_the_map(trap_shares):
    rng = np.random.default_rng(5)
    random = {f"random{i}": {"deterministic": np.eye(N)[rng.integers(N, size=N)]} for i in range(30)}
    ends = module.absorptions(frame(**random), PARAMETERS, EvaluationConfig(starts=2))
    assert ends["absorbed"].mean() > 0.8
    absorbed = ends[ends["absorbed"]]
    assert absorbed["stalled"].mean() > 0.95
    foretold = trap_shares[absorbed["observation"], absorbed["action"]] >= module.TRAP
    assert foretold.mean() > 0.8


def test_a_drawing_policy_leaves_the_trap_that_absorbs_its_favourite_actions():
    still = np.tile(np.eye(N)[5], (N, 1))
    mixed = 0.2 * still + 0.8 / N
    tables = frame(
        drawn={"deterministic": still, "stochastic": mixed}, sure={"deterministic": still},
        wave={"deterministic": np.eye(N), "stochastic": mixed},
    )  # fmt: skip
    ends = module.absorptions(tables, PARAMETERS, CONFIG)
    (row,) = module.escapes(ends, tables, PARAMETERS, CONFIG).to_dict("records")
    assert (row["agent"], row["observation"], row["action"], row["starts"]) == ("drawn", 4, 5, 1)
    assert row["other_action"] == pytest.approx(0.72)
    assert row["leaving_rate"] > 1 / CONFIG.duration
    assert 0 < row["occupancy"] < 1
