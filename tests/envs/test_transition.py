"""The compiled decision: packed and unpacked tasks, and draws that are NumPy's own."""

import copy
import pickle
from dataclasses import replace

import numpy as np
import pytest

from crawler_bench.envs.crawler import CrawlerEnv
from crawler_bench.envs.randomness import live_state, random
from crawler_bench.envs.transition import TASK, make_task
from crawler_bench.physics import CrawlerParameters
from crawler_bench.physics.coefficients import as_record, coefficients, stepping
from crawler_bench.physics.integration import STEPPING
from tests.bodies import former


@pytest.mark.parametrize(("parameters", "takes_steps"), [
    (former(), False),
    (former(n_segments=30), True),  # 30 nodes that slide forward balance one that slides backward
    (former(integrator="step", spike_phase="2pi", tau_f=1.0, head_muscle="external"), True),
    (former(damping=0.7, observation="most_stretched", friction_law="literal"), False),
])  # fmt: skip
def test_a_task_holds_what_was_asked(parameters: CrawlerParameters, takes_steps: bool) -> None:
    task, steps = make_task(parameters, 0.01, 0.2, 2.0, 1000.0)
    record = task.view(TASK)[0]
    assert record.k == as_record(coefficients(parameters))
    asked = (0.01, 0.0, 0.2, 2.0, 1000.0 / parameters.decision_interval, 1)
    assert record.item()[:6] == asked
    assert (steps is not None) == takes_steps
    if steps is not None:
        assert steps.view(STEPPING)[0] == as_record(stepping(parameters))


def test_a_penalty_per_time_is_one_per_decision_times_its_interval() -> None:
    rewards = []
    for penalty, epsilon in (("decision", 0.05), ("rate", 0.25)):
        env = CrawlerEnv(former(penalty=penalty, decision_interval=0.2), regularization=epsilon)
        env.reset(seed=0)
        rewards.append([env.step(a)[1] for a in (3, 3, 4, 5, 5, 5, 5)])
    np.testing.assert_allclose(*rewards, atol=1e-15)
    assert min(rewards[0]) < 0


def test_an_action_is_held_until_the_observation_changes() -> None:
    """As long as the same actions, taken at every interval, leave the observation as it was."""
    p = former(decision_interval=0.1, longest_hold=0.7)
    held, twin = CrawlerEnv(replace(p, decide_on="change")), CrawlerEnv(p)
    before, _ = held.reset(seed=1)
    twin.reset(seed=1)
    lengths = []
    for action in [int(a) for a in np.random.default_rng(0).integers(10, size=60)]:
        seen, reward, _, _, info = held.step(action)
        displacement, length = 0.0, 0
        while True:
            now, _, _, _, told = twin.step(action)
            displacement, length = displacement + told["displacement"], length + 1
            if now != before or length == 7:
                break
        assert (seen, info["time"]) == (now, told["time"])
        assert info["displacement"] == pytest.approx(displacement, abs=1e-12)
        assert reward == pytest.approx(displacement - 0.01 * told["strain_gradient"], abs=1e-12)
        before = seen
        lengths.append(length)
    assert {1, 7} < set(lengths)


@pytest.mark.parametrize(("interval", "limit", "decisions"), [
    (0.2, 1.0, 5), (0.2, 1.1, 6), (0.1, 0.3, 3), (0.2, 0.6, 3), (0.7, 2.1, 3), (0.2, 1.0 + 1e-9, 6),
])  # fmt: skip
def test_no_decision_begins_at_the_time_limit(interval: float, limit: float, decisions: int) -> None:
    """0.3 / 0.1 and 0.6 / 0.2 are not whole numbers in floating point; the number of decisions is."""
    task, _ = make_task(former(decision_interval=interval), time_limit=limit)
    assert task.view(TASK)[0].episode_intervals == decisions


@pytest.mark.parametrize("seed", range(5))
def test_draws_are_those_of_numpy_and_move_it_on(seed: int) -> None:
    generator, twin = np.random.default_rng(seed), np.random.default_rng(seed)
    state = live_state(generator)
    np.testing.assert_array_equal([random(state) for _ in range(2000)], twin.random(2000))
    assert generator.bit_generator.state == twin.bit_generator.state
    assert generator.random() == twin.random()


def test_another_bit_generator_is_refused() -> None:
    with pytest.raises(TypeError, match="a PCG64 generator is needed, not MT19937"):
        live_state(np.random.Generator(np.random.MT19937(0)))


@pytest.mark.parametrize("duplicate", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
def test_a_copy_draws_its_own_numbers(duplicate: "object") -> None:
    env = CrawlerEnv(noise=0.1)
    env.reset(seed=0)
    env.step(1)
    twin = duplicate(env)  # type: ignore[operator]
    before = twin.np_random.bit_generator.state
    for action in range(10):
        env.step(action)
    assert twin.np_random.bit_generator.state == before
    assert env.np_random.bit_generator.state != before


def test_the_generator_may_be_replaced() -> None:
    """Gymnasium lets anyone assign np_random."""
    one, other = CrawlerEnv(noise=0.1), CrawlerEnv(noise=0.1)
    for env in (one, other):
        env.reset(seed=1)
        env.np_random = np.random.default_rng(5)
    assert [one.step(a)[0] for a in range(10)] == [other.step(a)[0] for a in range(10)]
