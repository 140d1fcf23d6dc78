"""Deep agents as the benchmark uses them: what is ours about them; the rest is their libraries'."""

import gymnasium as gym
import numpy as np
import pytest
import sb3_contrib
import stable_baselines3
import torch

import crawler_bench
from agents.deep import A2C, DQN, PPO, QRDQN, REWARD_SCALE, RecurrentPPO, ScaledRewards
from crawler_bench.envs.crawler import CrawlerEnv
from crawler_bench.envs.sb3 import CrawlerVecEnv

OFF_POLICY, ON_POLICY = (
    {"learning_starts": 32, "train_freq": 1},
    {"n_steps": 16, "batch_size": 16, "n_epochs": 1},
)
SHORT = {PPO: ON_POLICY, DQN: OFF_POLICY, A2C: {"n_steps": 16}, QRDQN: OFF_POLICY, RecurrentPPO: ON_POLICY}
KINDS = pytest.mark.parametrize("kind", [DQN, PPO], ids=lambda kind: kind.__name__)
ALL = pytest.mark.parametrize("kind", SHORT, ids=lambda kind: kind.__name__)


def weights(agent) -> torch.Tensor:
    return torch.nn.utils.parameters_to_vector(agent.policy.parameters()).detach()


def trained(kind, seed: int = 0, crawlers: int = 4, **settings):
    return kind(CrawlerVecEnv(crawlers), seed=seed, **SHORT[kind] | settings).learn(256)


@KINDS
def test_the_same_seed_gives_the_same_agent(kind):
    one, same, other = (weights(trained(kind, seed)) for seed in (0, 0, 1))
    assert torch.equal(one, same)
    assert not torch.equal(one, other)


@KINDS
def test_rewards_are_scaled_while_learning(kind):
    seen = {}
    for scale in (1.0, REWARD_SCALE):
        agent = kind(CrawlerVecEnv(2), seed=0, reward_scale=scale, **SHORT[kind])
        agent.env.seed(0)
        agent.env.reset()
        seen[scale] = np.array([agent.env.step(np.array([i % 10, 3]))[1] for i in range(50)])
    assert np.abs(seen[1.0]).max() > 0
    np.testing.assert_allclose(seen[REWARD_SCALE], REWARD_SCALE * seen[1.0], rtol=1e-6)
    assert 0.1 < np.abs(seen[REWARD_SCALE]).max() < 1  # of order one, as the defaults assume


@ALL
def test_nothing_but_what_is_said_differs_from_the_defaults(kind):
    ours = kind(CrawlerVecEnv(2), seed=0)
    library = getattr(stable_baselines3, kind.__name__, None) or getattr(sb3_contrib, kind.__name__)
    default = library(kind.USUAL_POLICY, CrawlerVecEnv(2), seed=0)
    assert ours.gamma == 0.95
    told = {"gamma", "reward_scale", "env", "_last_obs", "seed", "replay_buffer", "rollout_buffer"}
    told.add("_last_lstm_states")  # tensors, all zero
    for name, value in vars(default).items():
        if name not in told and isinstance(value, int | float | str | tuple | None):
            assert vars(ours)[name] == value, name
    assert ours.policy_kwargs == default.policy_kwargs
    assert [str(each) for each in ours.policy.children()] == [str(each) for each in default.policy.children()]
    optimizers = [each.policy.optimizer for each in (ours, default)]
    assert type(optimizers[0]) is type(optimizers[1])
    assert optimizers[0].defaults == optimizers[1].defaults  # epsilon is not torch's everywhere
    schedules = [(each.lr_schedule(1), each.lr_schedule(0.5)) for each in (ours, default)]
    assert schedules[0] == schedules[1]


def test_zeros_and_ones_are_what_the_network_makes_of_the_index():
    """So nothing is lost, or won, by code that knows only Box."""
    learned = []
    for keyhole in ("index", "one-hot"):
        env = gym.make(crawler_bench.KEYHOLE_IDS[keyhole])
        learned.append(weights(A2C(env, seed=0).learn(100)))
    assert torch.equal(*learned)


@KINDS
def test_a_loaded_agent_decides_alike_and_learns_on(kind, tmp_path):
    agent = trained(kind)
    agent.save(tmp_path / "agent.zip")
    loaded = kind.load(tmp_path / "agent.zip", env=CrawlerVecEnv(4))
    assert isinstance(loaded.env, ScaledRewards)
    assert torch.equal(weights(agent), weights(loaded))
    observations = np.arange(10)
    np.testing.assert_array_equal(
        agent.predict(observations, deterministic=True)[0],
        loaded.predict(observations, deterministic=True)[0],
    )
    before = weights(loaded).clone()
    loaded.learn(128, reset_num_timesteps=False)
    assert not torch.equal(before, weights(loaded))
    assert loaded.num_timesteps >= 256 + 128


@KINDS
def test_one_thread_and_a_single_environment_will_do(kind):
    agent = kind(CrawlerEnv(), seed=0, **SHORT[kind]).learn(64)
    assert torch.get_num_threads() == 1
    assert agent.num_timesteps == 64


def test_neighbouring_seeds_share_no_crawler():
    """Stable-Baselines3 seeds crawler i with seed + i."""
    envs = []
    for seed in (0, 1):
        agent = DQN(CrawlerVecEnv(8), seed=seed)
        agent.env.reset()
        envs.append({tuple(row) for row in agent.env.unwrapped.crawlers.generators.tolist()})
    assert not envs[0] & envs[1]
