"""The compiled decision: packed and unpacked tasks, and draws that are NumPy's own."""

import copy
import pickle

import numpy as np
import pytest

from crawler_bench.envs.crawler import CrawlerEnv
from crawler_bench.envs.randomness import live_state, random
from crawler_bench.envs.transition import _decide, begin, decide_and_report, make_task, report, unpack
from crawler_bench.physics import CrawlerParameters
from crawler_bench.physics.coefficients import coefficients
from crawler_bench.physics.compiled import kernel
from crawler_bench.physics.state import PAPER_NODES, WORK, make_memory


@pytest.mark.parametrize("parameters", [
    CrawlerParameters(),
    CrawlerParameters(n_segments=30, integrator="step", spike_phase="2pi", tau_f=1.0, head_muscle="external"),
    CrawlerParameters(damping=0.7, observation="most_stretched", friction_law="literal"),
])  # fmt: skip
def test_a_packed_task_is_the_task(parameters: CrawlerParameters) -> None:
    task = unpack(make_task(parameters, 0.01, 0.2, 2.0, 1000.0))
    assert task.k == coefficients(parameters)
    assert task[:-1] == (parameters.steps_per_decision, 0.01, 0.2, 2.0, 1000.0 / parameters.decision_interval)


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


@kernel
def _decide_knowing_no_size(memory, actions, packed, rng, outcomes):  # type: ignore[no-untyped-def]
    for i in range(actions.size):
        made = _decide(memory, actions[i], packed, rng)
        outcomes[i, 0], outcomes[i, 1] = made.observation, made.reward


@pytest.mark.parametrize("integrator", ["exact", "step"])
def test_what_is_compiled_for_the_size_of_the_paper_gives_the_same_bits(integrator: str) -> None:
    parameters = CrawlerParameters(integrator=integrator)
    task = make_task(parameters, regularization=0.01, noise=0.05)
    known, unknown = make_memory(parameters.n_segments), make_memory(parameters.n_segments)
    assert known.shape[1] == PAPER_NODES
    actions = np.random.default_rng(2).integers(parameters.n_segments, size=2000)
    generators = [np.random.default_rng(3) for _ in range(2)]  # whose states live as long as they do
    rng = live_state(generators[0])
    begin(known, task, rng)
    made = [decide_and_report(known, a, task, rng) for a in actions]
    rng, two = live_state(generators[1]), np.empty((actions.size, 2))
    begin(unknown, task, rng)
    _decide_knowing_no_size(unknown, actions, task, rng, two)
    report(unknown, task)
    np.testing.assert_array_equal([(each.observation, each.reward) for each in made], two)
    np.testing.assert_array_equal(known[:WORK], unknown[:WORK])
    assert abs(known[0]).max() > 0.1  # they moved
