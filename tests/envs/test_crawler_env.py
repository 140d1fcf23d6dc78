"""Laws that every Gymnasium environment obeys, and what this one promises beyond them."""

import math
import pickle
import subprocess
import sys
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from stable_baselines3.common.env_checker import check_env as check_env_sb3

import crawler_bench
from crawler_bench.envs.crawler import CrawlerEnv
from crawler_bench.envs.transition import DISTANCE, RUNNING, TIME
from crawler_bench.physics import CrawlerParameters


def make(**arguments: Any) -> gym.Env[Any, Any]:
    return gym.make(crawler_bench.ENV_ID, **arguments)


def roll(env: gym.Env[Any, Any], seed: int, steps: int) -> list[tuple[Any, ...]]:
    observation, info = env.reset(seed=seed)
    trail: list[tuple[Any, ...]] = [(observation, info)]
    actions = np.random.default_rng(seed)
    for _ in range(steps):
        step = env.step(int(actions.integers(env.action_space.n)))  # type: ignore[attr-defined]
        trail.append(step)
        if step[2] or step[3]:
            trail.append(env.reset())
    return trail


def assert_same(one: list[tuple[Any, ...]], other: list[tuple[Any, ...]]) -> None:
    for a, b in zip(one, other, strict=True):
        assert a[:-1] == b[:-1]
        for key in a[-1]:
            np.testing.assert_array_equal(a[-1][key], b[-1][key])


@pytest.mark.parametrize("arguments", [{}, {"noise": 0.2}, {"parameters": CrawlerParameters(n_segments=3)}])
def test_both_checkers_pass_without_a_warning(
    arguments: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    check_env(make(**arguments, render_mode="rgb_array").unwrapped)
    check_env_sb3(CrawlerEnv(**arguments))


@pytest.mark.parametrize("noise", [0.0, 0.1])
def test_two_seeded_rollouts_are_identical_to_the_bit(noise: float) -> None:
    assert_same(
        roll(make(noise=noise, time_limit=30), 3, 400), roll(make(noise=noise, time_limit=30), 3, 400)
    )


def test_a_seed_then_no_seed_repeats() -> None:
    """The second, unseeded episode follows from the first seed too."""
    firsts = [[env.reset(seed=5)[0], *(env.reset()[0] for _ in range(20))] for env in (make(), make())]
    assert firsts[0] == firsts[1]
    assert len(set(firsts[0])) > 1


def test_a_pickled_environment_goes_on_as_the_original() -> None:
    env = CrawlerEnv(noise=0.05)
    roll(env, 1, 57)
    twin = pickle.loads(pickle.dumps(env))
    for action in [0, 9, 4, 4, 2] * 20:
        assert env.step(action)[:4] == twin.step(action)[:4]


def test_a_snapshot_brings_another_environment_to_the_same_future() -> None:
    env, twin = CrawlerEnv(noise=0.05), CrawlerEnv(noise=0.05)
    roll(env, 1, 57)
    twin.set_state(env.get_state())
    for action in [0, 9, 4, 4, 2] * 20:
        assert env.step(action)[:4] == twin.step(action)[:4]


@pytest.mark.parametrize("lost", [["memory", "layout", "parameters"], ["a name"]])
def test_a_snapshot_of_the_state_alone_will_do(lost: list[str]) -> None:
    """Agents that earlier versions saved hold no trajectory, or one that was written otherwise."""
    env, twin = CrawlerEnv(), CrawlerEnv()
    roll(env, 1, 57)
    snapshot = env.get_state()
    if lost == ["a name"]:
        snapshot["layout"].pop()
    snapshot = {name: value for name, value in snapshot.items() if name not in lost}
    twin.set_state(snapshot)
    for action in [0, 9, 4, 4, 2] * 20:
        np.testing.assert_allclose(env.step(action)[1], twin.step(action)[1], atol=1e-12)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("state", [[float("nan")] * 11] * 6), ("state", [[0.0] * 10] * 6), ("state", 5),
        ("state", [[0.0], []]), ("odometer", [0.0, float("inf"), 0.0, 0.0]), ("odometer", [0.0] * 9),
        ("memory", None), ("memory", []), ("generator", {}), ("generator", {"bit_generator": "MT19937"}),
    ],
)  # fmt: skip
def test_a_snapshot_that_is_none_is_refused_and_changes_nothing(name: str, value: Any) -> None:
    env = CrawlerEnv()
    roll(env, 1, 57)
    before = env.get_state()
    with pytest.raises(ValueError, match=f"the crawler's {name}") as caught:
        env.set_state(before | {name: value})
    assert "\n" not in str(caught.value)
    assert env.get_state() == before
    with pytest.raises(ValueError, match="a crawler's state is a dictionary"):
        env.set_state([])  # type: ignore[arg-type]


@pytest.mark.parametrize("other", [{"integrator": "step"}, {"tau_f": 0.7}, {"damping": 2.0}])
def test_a_snapshot_of_one_body_goes_on_in_another(other: dict[str, Any]) -> None:
    """A course holds for the parameters for which it was laid; the state holds for all."""
    env = CrawlerEnv()
    roll(env, 1, 57)
    snapshot, twin, fresh = env.get_state(), *(CrawlerEnv(CrawlerParameters(**other)) for _ in range(2))
    twin.set_state(snapshot)
    fresh.set_state({name: snapshot[name] for name in ("state", "odometer", "generator")})
    for action in [0, 9, 4, 4, 2] * 20:
        one, two = twin.step(action), fresh.step(action)
        assert one[:4] == two[:4]
        np.testing.assert_array_equal(one[4]["muscle_force"], two[4]["muscle_force"])
        assert one[4]["muscle_force"].max() > 0


def test_info_holds_fresh_arrays_and_plain_floats() -> None:
    env = CrawlerEnv()
    env.reset(seed=0)
    *_, first = env.step(3)
    kept = {key: np.copy(value) for key, value in first.items() if isinstance(value, np.ndarray)}
    for action in range(10):
        env.step(action)
    for key, value in kept.items():
        np.testing.assert_array_equal(first[key], value)
    assert {key: value.shape for key, value in kept.items()} == {
        "strain": (10,), "muscle_force": (11,), "node_velocity": (11,), "power": (11,),
    }  # fmt: skip
    for key in ("time", "centroid", "displacement", "strain_gradient"):
        assert type(first[key]) is float, key
    assert type(first["end"]) is int  # writers of HDF5 take numbers, not None


def test_step_returns_plain_python_values() -> None:
    env = CrawlerEnv()
    env.reset(seed=0)
    observation, reward, terminated, truncated, _ = env.step(np.int64(2))
    assert [type(value) for value in (observation, reward, terminated, truncated)] == [int, float, bool, bool]


def test_reward_is_equation_11() -> None:
    env = CrawlerEnv(regularization=0.3)
    env.reset(seed=0)
    before = 0.0
    for action in [9, 8, 7, 6, 5, 4, 3, 2, 1, 0] * 10:
        _, reward, _, _, info = env.step(action)
        u = np.concatenate([[0.0], np.cumsum(info["strain"])])
        gradient = np.abs(np.diff(u, 2)).max()
        assert info["displacement"] == pytest.approx(info["centroid"] - before, abs=1e-15)
        assert info["strain_gradient"] == pytest.approx(gradient, abs=1e-12)
        assert reward == pytest.approx(info["displacement"] - 0.3 * gradient, abs=1e-12)
        before = info["centroid"]


def test_power_is_net_force_times_speed() -> None:
    env = CrawlerEnv()
    env.reset(seed=0)
    greatest = 0.0
    for action in [9, 8, 7, 6, 5, 4, 3, 2, 1, 0] * 10:
        *_, info = env.step(action)
        greatest = max(greatest, info["power"].max())
        f = np.append(info["muscle_force"], 0.0)
        net = f[:-1] - f[1:]
        net[1] -= f[0]  # the reaction of the head muscle
        np.testing.assert_allclose(info["power"], np.abs(net * info["node_velocity"]), atol=1e-15)
    assert greatest > 0.01


def test_the_observation_is_the_most_contracted_segment() -> None:
    env, literal = CrawlerEnv(), CrawlerEnv(CrawlerParameters(observation="most_stretched"))
    env.reset(seed=0)
    literal.reset(seed=0)
    for action in np.random.default_rng(0).integers(10, size=200):
        observation, *_, info = env.step(int(action))
        stretched, *_, same = literal.step(int(action))
        np.testing.assert_array_equal(info["strain"], same["strain"])
        if not info["strain"].any():
            continue  # before the first spike all segments tie
        assert observation == info["strain"].argmax()
        assert stretched == info["strain"].argmin()


def test_a_tie_is_broken_evenly() -> None:
    """The undeformed body is observed as every segment alike."""
    env = CrawlerEnv()
    env.reset(seed=0)
    counts = np.bincount([env.reset()[0] for _ in range(5000)], minlength=10)
    assert counts.min() > 400
    assert counts.max() < 600


def test_noise_changes_what_is_sensed_and_nothing_else() -> None:
    quiet, noisy = CrawlerEnv(), CrawlerEnv(noise=0.1)
    quiet.reset(seed=0)
    noisy.reset(seed=0)
    differ = 0
    for action in [9, 8, 7, 6, 5, 4, 3, 2, 1, 0] * 30:
        one, other = quiet.step(action), noisy.step(action)
        assert one[1] == other[1]
        np.testing.assert_array_equal(one[4]["strain"], other[4]["strain"])
        differ += one[0] != other[0]
        assert other[4]["strain"][other[0]] >= one[4]["strain"].max() - 0.2
    assert differ > 30


@pytest.mark.parametrize(("arguments", "end"), [
    ({"episode_distance": 0.05, "time_limit": math.inf}, DISTANCE),
    ({"episode_distance": math.inf, "time_limit": 7.6}, TIME),
])  # fmt: skip
def test_both_ends_truncate(arguments: dict[str, Any], end: int) -> None:
    env = CrawlerEnv(**arguments)
    env.reset(seed=0)
    actions = np.random.default_rng(0)
    for _ in range(5000):
        *_, terminated, truncated, info = env.step(int(actions.integers(10)))
        assert not terminated
        assert truncated == (info["end"] != RUNNING)
        if truncated:
            break
    assert info["end"] == end
    if end == TIME:
        assert info["time"] == pytest.approx(7.6)
    else:
        assert info["centroid"] >= 0.05 > info["centroid"] - info["displacement"]
    env.reset()
    assert env.get_state()["odometer"][0] == 0
    assert np.abs(env.get_state()["state"]).max() == 0


def test_the_diagonal_policy_crawls_forward_and_a_held_neuron_does_not() -> None:
    env = CrawlerEnv(episode_distance=math.inf)
    observation, _ = env.reset(seed=0)
    for _ in range(1000):
        observation, *_, info = env.step(observation)
    assert 0.8 < info["centroid"] < 1.4
    env.reset()
    for _ in range(1000):
        *_, info = env.step(4)
    assert info["centroid"] < 0.2


@pytest.mark.parametrize("action", [-1, 10, 2.5, "3", None, True, np.True_])
def test_an_impossible_action_is_refused_in_one_line(action: Any) -> None:
    env = CrawlerEnv()
    env.reset(seed=0)
    with pytest.raises(
        ValueError, match=r"^action .* is not possible: it must be a whole number from 0 to 9$"
    ):
        env.step(action)


@pytest.mark.parametrize("arguments", [
    {"regularization": -0.1}, {"regularization": math.nan}, {"noise": -1.0}, {"noise": math.inf},
    {"episode_distance": 0.0}, {"episode_distance": math.nan}, {"time_limit": -3.0}, {"render_mode": "ansi"},
    {"regularization": "0.1"}, {"noise": None}, {"time_limit": True}, {"episode_distance": [2.0]},
])  # fmt: skip
def test_an_impossible_argument_is_refused_in_one_line(arguments: dict[str, Any]) -> None:
    (name, _value), *_ = arguments.items()
    with pytest.raises(ValueError, match=rf"^{name} = .* is not possible: it must be [^\n]*$"):
        CrawlerEnv(**arguments)


def test_a_worker_process_finds_it_by_module_and_name() -> None:
    code = (
        "import gymnasium as gym; env = gym.make('crawler_bench:crawler_bench/Crawler-v0');"
        "env.reset(seed=0); print(env.step(1)[0])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip().isdigit()


def test_a_step_before_a_reset_is_refused() -> None:
    with pytest.raises(gym.error.ResetNeeded, match="call reset"):
        CrawlerEnv().step(0)


@pytest.mark.parametrize(
    ("arguments", "longest"),
    [
        ({"time_limit": 6.0, "parameters": CrawlerParameters(decision_interval=0.2)}, 30),
        ({"time_limit": 6.0, "parameters": CrawlerParameters(decision_interval=0.3)}, 20),
        ({"time_limit": math.inf}, None),
    ],
)
def test_the_longest_episode_is_in_the_specification(arguments: dict[str, Any], longest: int | None) -> None:
    env = make(episode_distance=math.inf, **arguments)
    assert env.spec is not None
    assert env.spec.max_episode_steps == longest
    remade = gym.make(env.spec)
    assert remade.spec == env.spec
    if longest is not None:
        for each in (env, remade):
            each.reset(seed=0)
            assert [each.step(0)[3] for _ in range(longest)] == [False] * (longest - 1) + [True]


def test_a_limit_that_is_given_to_gymnasium_counts() -> None:
    env = make(max_episode_steps=7)
    env.reset(seed=0)
    assert [env.step(0)[3] for _ in range(7)] == [False] * 6 + [True]
    assert env.spec is not None
    assert env.spec.max_episode_steps == 7


def test_registration_is_idempotent() -> None:
    import importlib

    importlib.reload(crawler_bench)
    assert crawler_bench.ENV_ID in gym.registry
