"""Known answers of softened policies."""

import numpy as np
import pytest

from crawler_bench.benchmark.temperature import soften, speed_against_temperature
from crawler_bench.config.schema import EvaluationConfig
from crawler_bench.gait import metrics
from crawler_bench.gait.rollout import rollout
from crawler_bench.physics.parameters import CrawlerParameters
from tests.benchmark.frames import tables

N = 10
PARAMETERS = CrawlerParameters()
CONFIG = EvaluationConfig(starts=2, warm_up=50, duration=200)


def random_table(seed=0):
    table = np.random.default_rng(seed).random((N, N))
    return table / table.sum(axis=1, keepdims=True)


def test_temperature_one_returns_the_table():
    np.testing.assert_array_equal(soften(random_table(), 1), random_table())


@pytest.mark.parametrize("temperature", [0, 1e-6])
def test_without_temperature_the_favourite_action_is_sure(temperature):
    sure = soften(random_table(), temperature)
    np.testing.assert_allclose(sure, np.eye(N)[random_table().argmax(axis=1)], atol=1e-12)


@pytest.mark.parametrize("temperature", [1e6, np.inf])
def test_at_infinite_temperature_action_is_random(temperature):
    np.testing.assert_allclose(soften(random_table(), temperature), 1 / N, atol=1e-5)


def test_even_actions_that_are_never_taken_are_random_at_infinity():
    np.testing.assert_allclose(soften(np.eye(N), np.inf), 1 / N)


@pytest.mark.parametrize("temperature", [0, 0.25, 3])
def test_a_random_policy_and_a_sure_one_stay_what_they_are(temperature):
    for table in (np.full((N, N), 1 / N), np.eye(N)):
        np.testing.assert_allclose(soften(table, temperature), table)


def test_half_the_temperature_squares_the_odds():
    table = np.array([[0.8, 0.2], [0.5, 0.5]])
    np.testing.assert_allclose(soften(table, 0.5), [[16 / 17, 1 / 17], [0.5, 0.5]])


@pytest.mark.parametrize("temperature", [-1, np.nan])
def test_impossible_temperatures(temperature):
    with pytest.raises(ValueError, match="at least 0"):
        soften(random_table(), temperature)


def test_speed_at_temperature_one_is_the_evaluations():
    learned = tables(
        drawn={"deterministic": np.eye(N), "stochastic": random_table()}, sure={"deterministic": np.eye(N)}
    )
    speeds = speed_against_temperature(learned, PARAMETERS, CONFIG, [0, 1])
    assert speeds["agent"].tolist() == ["drawn"] * 2
    assert list(speeds) == ["agent", "regularization", "seed", "temperature", "speed", "stall_share"]
    crawl = {"warm_up": 50, "duration": 200, "noise": 0, "policy_seed": 3}
    records = [rollout(PARAMETERS, random_table(), start=(2020, start), **crawl) for start in range(2)]
    expected = [metrics.speed(record) for record in records]
    assert speeds["speed"][1] == np.mean(expected)
