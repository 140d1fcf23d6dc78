"""Rollouts: the compiled loop against the environment, starts, noise, and random action."""

import gymnasium as gym
import numpy as np
import pytest
from scipy.stats import chisquare

import crawler_bench
from crawler_bench.gait import rollout as module
from crawler_bench.gait.rollout import rollout
from crawler_bench.physics.parameters import CrawlerParameters
from crawler_bench.runs.policies.table import action_table

N = 10
FIVE = CrawlerParameters(n_segments=5)
WAVE, UNIFORM = np.eye(N), np.full((N, N), 1 / N)
PAIRED = np.eye(N)[[7, 3, 0, 7, 3, 4, 5, 6, 7, 9]]


def crawl(table=WAVE, parameters=None, **changes):
    arguments = {"warm_up": 10, "duration": 20, "noise": 0.0, "start": (1, 2)} | changes
    return rollout(parameters or CrawlerParameters(), table, **arguments)


def assert_same(one, other):
    for name in vars(one):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_samples_are_at_the_ends_of_decisions():
    record = crawl(duration=3, parameters=CrawlerParameters(decision_interval=0.3))
    np.testing.assert_allclose(record.time, 0.3 * np.arange(11))
    assert record.displacement.shape == record.power.shape == (11, N + 1)
    assert record.action.shape == (10,)


@pytest.mark.parametrize("table", [WAVE, UNIFORM])
def test_the_same_seeds_give_the_same_bits(table):
    assert_same(crawl(table, noise=0.1), crawl(table, noise=0.1))


def test_all_policies_meet_the_same_start():
    """The same state and, told by two policies that can be read backwards, the same first observation."""
    order = np.random.default_rng(0).permutation(N)
    one, other, uniform = crawl(WAVE), crawl(np.eye(N)[order]), crawl(UNIFORM)
    for name in ("displacement", "velocity", "force", "power"):
        np.testing.assert_array_equal(getattr(one, name)[0], getattr(other, name)[0])
        np.testing.assert_array_equal(getattr(one, name)[0], getattr(uniform, name)[0])
    assert order[one.action[0]] == other.action[0]
    assert (one.displacement[-1] != other.displacement[-1]).any()


@pytest.mark.parametrize("start", [(1, 3), (2, 2), (1,)])
def test_other_starts_differ(start):
    assert (crawl().displacement[0] != crawl(start=start).displacement[0]).any()


def test_without_a_warm_up_the_body_starts_undeformed():
    record = crawl(warm_up=0)
    for values in (record.displacement, record.velocity, record.force, record.power):
        assert not values[0].any()


@pytest.mark.parametrize(
    ("parameters", "table"),
    [
        (CrawlerParameters(), WAVE),
        (CrawlerParameters(), PAIRED),
        (CrawlerParameters(observation="most_stretched", head_muscle="none"), WAVE),
        (FIVE, np.eye(5)[[1, 0, 3, 2, 4]]),
        (CrawlerParameters(integrator="step"), WAVE),
    ],
)
def test_a_rollout_is_the_environment_stepped(parameters, table):
    """The undeformed body observes at random, so the environment is given the actions of the record.

    That these follow the table is checked wherever one segment alone is the most contracted.
    """
    record = crawl(table, parameters, warm_up=0, duration=60)
    env = gym.make(crawler_bench.ENV_ID, parameters=parameters).unwrapped
    env.reset(seed=0)
    sign = 1 if parameters.observation == "most_contracted" else -1
    decided = 0
    for t, action in enumerate(record.action):
        strain = sign * env.nodes["strain"][:-1]
        if (strain == strain.max()).sum() == 1:
            decided += 1
            assert action == table[strain.argmax()].argmax()
        info = env.step(action)[4]
        np.testing.assert_array_equal(record.displacement[t + 1], env.nodes["displacement"])
        np.testing.assert_array_equal(record.velocity[t + 1], env.nodes["velocity"])
        np.testing.assert_array_equal(record.force[t + 1], env.nodes["force"])
        np.testing.assert_array_equal(record.power[t + 1], info["power"])
    assert decided > 250
    assert record.centroid[-1] != 0


def test_noise_is_sensed_and_nothing_else():
    """A policy that does not look crawls the same under any noise; one that looks does not."""
    blind = np.tile(np.eye(N)[[4]], (N, 1))
    assert_same(crawl(blind), crawl(blind, noise=0.4))
    quiet, noisy = crawl(WAVE), crawl(WAVE, noise=0.4)
    np.testing.assert_array_equal(quiet.displacement[0], noisy.displacement[0])
    assert (quiet.action != noisy.action).any()


def test_little_noise_does_not_reach_beyond_it():
    """Every action taken under noise s answers a segment within 2 s of the most contracted one."""
    record = crawl(WAVE, noise=0.02, duration=100)
    strain = record.strain[1:-1]
    sensed = np.take_along_axis(strain, record.action[1:, None], axis=1)[:, 0]
    lag = strain.max(axis=1) - sensed
    assert 0 < lag.max() <= 0.04
    np.testing.assert_array_equal(crawl(WAVE).strain[1:-1].argmax(axis=1), crawl(WAVE).action[1:])


def test_the_warm_up_is_random_action(monkeypatch):
    """Its actions are uniform and independent of what is observed."""
    calls, original = [], module._crawl

    def watched(memory, observation, cumulative, *rest):
        last = original(memory, observation, cumulative, *rest)
        calls.append((rest[-2], rest[-1]))
        return last

    monkeypatch.setattr(module, "_crawl", watched)
    record = crawl(WAVE, warm_up=1000, duration=2)
    (samples, actions), (_, own) = calls
    assert actions.size == 5263  # 1000 tau at 0.19 each
    np.testing.assert_array_equal(own, record.action)
    observed = np.diff(samples[:-1, 0], axis=1).argmax(axis=1)
    assert chisquare(np.bincount(actions, minlength=N)).pvalue > 1e-3
    for observation in np.flatnonzero(np.bincount(observed, minlength=N) > 200):
        counts = np.bincount(actions[observed == observation], minlength=N)
        assert chisquare(counts).pvalue > 1e-4
    np.testing.assert_array_equal(samples[-1, 0], record.displacement[0])


def test_a_uniform_table_takes_all_actions_alike():
    actions = crawl(UNIFORM, warm_up=0, duration=600).action
    assert chisquare(np.bincount(actions, minlength=N)).pvalue > 1e-3


def test_actions_are_drawn_with_their_probabilities():
    row = np.array([0, 0.5, 0, 0.2, 0.3, 0, 0, 0, 0, 0])
    counts = np.bincount(crawl(np.tile(row, (N, 1)), duration=600).action, minlength=N)
    assert not counts[row == 0].any()
    assert chisquare(counts[row > 0], counts.sum() * row[row > 0]).pvalue > 1e-3


def test_only_a_policy_that_draws_has_a_seed():
    assert_same(crawl(WAVE), crawl(WAVE, policy_seed=1))
    assert (crawl(UNIFORM).action != crawl(UNIFORM, policy_seed=1).action).any()


class Deterministic:
    def predict(self, observation, deterministic):
        assert deterministic
        return (np.asarray(observation) + 1) % 4, None


class Drawing:
    action_probabilities = np.full((3, 3), 1 / 3)


def test_action_tables():
    np.testing.assert_array_equal(action_table(Deterministic(), 4), np.eye(4)[[1, 2, 3, 0]])
    table = action_table(Drawing(), 3)
    np.testing.assert_array_equal(table, Drawing.action_probabilities)
    table[0] = 0
    assert Drawing.action_probabilities.all()
