"""The vector environment against the single one: the same crawlers, however they are stepped."""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from gymnasium.wrappers import vector as wrappers
from numpy.typing import NDArray

import crawler_bench
from crawler_bench.envs.crawler import CrawlerEnv
from crawler_bench.envs.transition import DISTANCE, RUNNING, TIME
from crawler_bench.envs.vector import CrawlerVectorEnv
from crawler_bench.physics import CrawlerParameters

TICKS = CrawlerParameters(decision_interval=0.2)
BODIES = [
    CrawlerParameters(),
    CrawlerParameters(damping=2.0, tau_f=0.5),
    CrawlerParameters(head_muscle="external", spike_phase="2pi"),
    CrawlerParameters(observation="most_stretched", decision_interval=0.3),
]
# Goals near enough, and times short enough, that some episodes end in either way.
SETTINGS: dict[str, list[float]] = {
    "regularization": [0.0, 0.01, 0.02, 0.1],
    "noise": [0.0, 0.05, 0.1, 0.2],
    "episode_distance": [0.5, 0.1, 2.0, 0.05],
    "time_limit": [1000.0, 40.0, 90.0, 33.0],
}


def half_at_random(rng: np.random.Generator, observation: NDArray[np.int64]) -> NDArray[np.int64]:
    """Crawl, and stray from it."""
    stray = rng.integers(10, size=observation.size)
    return np.where(rng.random(observation.size) < 0.3, stray, observation)


def synchronous(
    mode: AutoresetMode, bodies: list[CrawlerParameters], limit: int | None = None
) -> SyncVectorEnv:
    def maker(i: int) -> Callable[[], gym.Env[Any, Any]]:
        arguments = {name: values[i] for name, values in SETTINGS.items()}
        return lambda: gym.make(
            crawler_bench.ENV_ID, parameters=bodies[i], max_episode_steps=limit, **arguments
        )

    return SyncVectorEnv([maker(i) for i in range(len(bodies))], autoreset_mode=mode)


def assert_same(ours: Any, theirs: Any) -> None:
    """Equal types, shapes and values, whatever is nested in what; numbers to rounding."""
    if isinstance(theirs, dict):
        assert ours.keys() == theirs.keys()
        for key in theirs:
            assert_same(ours[key], theirs[key])
    elif theirs.dtype == object:
        assert ours.tolist() == theirs.tolist()
    else:
        assert (ours.dtype, ours.shape) == (theirs.dtype, theirs.shape)
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("integrator", "mode", "limit"),
    [
        ("exact", AutoresetMode.NEXT_STEP, None),
        ("step", AutoresetMode.NEXT_STEP, None),
        ("exact", AutoresetMode.SAME_STEP, None),
        ("exact", AutoresetMode.NEXT_STEP, 45),
        ("exact", AutoresetMode.SAME_STEP, 45),
        ("exact", AutoresetMode.DISABLED, None),
    ],
)
def test_it_is_gymnasiums_vector_of_single_crawlers(
    integrator: str, mode: AutoresetMode, limit: int | None
) -> None:
    """1000 steps of 4 crawlers, each with its own body, task and seed, through ends of every kind."""
    bodies = [replace(body, integrator=integrator) for body in BODIES]
    ours = CrawlerVectorEnv(4, bodies, **SETTINGS, autoreset_mode=mode, max_episode_steps=limit)
    theirs = synchronous(mode, bodies, limit)
    results = ours.reset(seed=[11, 5, 7, 5]), theirs.reset(seed=[11, 5, 7, 5])
    rng, ends = np.random.default_rng(0), set()
    for _ in range(1000):
        for mine, other in zip(*results, strict=True):
            assert_same(mine, other)
        truncated = results[1][3] if len(results[1]) == 5 else np.zeros(4, dtype=bool)
        infos = results[1][-1].get("final_info", results[1][-1])
        ends |= set(infos["end"][truncated].tolist())
        if mode == AutoresetMode.DISABLED and truncated.any():
            results = tuple(env.reset(options={"reset_mask": truncated.copy()}) for env in (ours, theirs))
            continue
        actions = half_at_random(rng, results[1][0])
        results = ours.step(actions), theirs.step(actions)
    assert ends >= ({TIME} if limit is None else {RUNNING})
    assert ends >= {DISTANCE} or limit is not None


def test_crawlers_are_reset_by_a_mask_and_keep_their_neighbours() -> None:
    vector = CrawlerVectorEnv(3, TICKS, autoreset_mode="Disabled")
    first, _ = vector.reset(seed=[0, 1, 2])
    for _ in range(3):
        before, *_ = vector.step([1, 2, 3])
    mask = np.array([True, True, False])
    after, infos = vector.reset(seed=[0, 1, 0], options={"reset_mask": mask})
    assert after.tolist() == [first[0], first[1], before[2]]
    assert infos["_time"].tolist() == mask.tolist()
    assert vector.step([1, 2, 3])[4]["time"].tolist() == pytest.approx([0.2, 0.2, 0.8])


def test_an_ended_crawler_must_be_reset_where_nothing_else_does_it() -> None:
    vector = CrawlerVectorEnv(2, TICKS, time_limit=[0.4, 9.0], autoreset_mode=AutoresetMode.DISABLED)
    vector.reset(seed=0)
    vector.step([0, 0])
    assert vector.step([0, 0])[3].tolist() == [True, False]
    with pytest.raises(ResetNeeded, match=r"crawlers \[0\] have ended"):
        vector.step([0, 0])
    vector.reset(options={"reset_mask": np.array([True, False])})
    vector.step([0, 0])


def test_a_step_before_a_reset_is_refused() -> None:
    with pytest.raises(ResetNeeded, match="call reset"):
        CrawlerVectorEnv(2).step([0, 0])
    with pytest.raises(ResetNeeded, match="the first reset must be of all crawlers"):
        CrawlerVectorEnv(2).reset(options={"reset_mask": np.array([True, False])})


@pytest.mark.parametrize(
    ("mask", "kind", "message"),
    [
        ([True, True], TypeError, "must be a numpy array, got <class 'list'>"),
        (np.array([True]), ValueError, r"must have shape `\(2,\)`, got \(1,\)"),
        (np.array([1, 0]), TypeError, "must have `dtype=np.bool_`, got int64"),
        (np.array([False, False]), ValueError, "at least one True value"),
    ],
)
def test_an_impossible_mask_is_refused(mask: Any, kind: type[Exception], message: str) -> None:
    vector = CrawlerVectorEnv(2)
    vector.reset(seed=0)
    with pytest.raises(kind, match=message):
        vector.reset(options={"reset_mask": mask})


def test_it_is_drawn_as_single_crawlers_are() -> None:
    vector, single = CrawlerVectorEnv(2, render_mode="rgb_array"), CrawlerEnv(render_mode="rgb_array")
    vector.reset(seed=0)
    single.reset(seed=1)
    for action in [*range(9, -1, -1)] * 5:
        vector.step([0, action])
        single.step(action)
    pictures = vector.render()
    assert pictures is not None
    assert len(pictures) == 2
    np.testing.assert_array_equal(pictures[1], single.render())
    assert (pictures[0] != pictures[1]).any()


def test_the_longest_episode_is_in_the_specification() -> None:
    """Of the crawler with the longest time limit, or of the given number of decisions; remaking keeps it."""
    for arguments, longest in (
        ({"time_limit": [4.0, 1.0]}, 20), ({"time_limit": math.inf}, None),
        ({"time_limit": 4.0, "max_episode_steps": 7}, 7),
        ({"time_limit": math.inf, "max_episode_steps": 7}, 7),
    ):  # fmt: skip
        vector = gym.make_vec(crawler_bench.ENV_ID, num_envs=2, parameters=TICKS, **arguments)
        assert vector.spec is not None
        assert vector.spec.max_episode_steps == longest
        assert gym.make_vec(vector.spec).spec == vector.spec


BOTH = (AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP)
WRAPPERS: list[tuple[Any, tuple[AutoresetMode, ...]]] = [
    (wrappers.RecordEpisodeStatistics, BOTH), (wrappers.NormalizeReward, BOTH),
    (wrappers.DictInfoToList, BOTH),
    (lambda env: wrappers.ClipReward(env, -0.001, 0.001), BOTH),
    # Gymnasium does not allow wrappers of observations with SAME_STEP.
    (wrappers.FlattenObservation, BOTH[:1]),
    (lambda env: wrappers.DtypeObservation(env, np.float32), BOTH[:1]),
    (lambda env: wrappers.NormalizeObservation(wrappers.FlattenObservation(env)), BOTH[:1]),
]  # fmt: skip


@pytest.mark.parametrize(("wrapper", "mode"), [(each, mode) for each, modes in WRAPPERS for mode in modes])
def test_gymnasiums_wrappers_work(wrapper: Any, mode: AutoresetMode) -> None:
    """On this class as on Gymnasium's own of single crawlers."""
    ours = wrapper(CrawlerVectorEnv(4, BODIES, **SETTINGS, autoreset_mode=mode))
    theirs = wrapper(synchronous(mode, BODIES))
    results: Any = ours.reset(seed=3)[:1], theirs.reset(seed=3)[:1]
    ended = 0
    for action in np.random.default_rng(0).integers(10, size=(200, 4)):
        for mine, other in zip(*results, strict=True):
            np.testing.assert_allclose(np.asarray(mine), np.asarray(other), rtol=0, atol=1e-9)
        results = ours.step(action)[:4], theirs.step(action)[:4]
        ended += int(np.sum(np.asarray(results[0][3])))
    assert ended > 3


@pytest.mark.parametrize("num_envs", [1, 3, 8, 13])
def test_the_number_of_crawlers_changes_none_of_them(num_envs: int) -> None:
    body = CrawlerParameters(integrator="step")
    few, many = CrawlerVectorEnv(num_envs, body, noise=0.1), CrawlerVectorEnv(16, body, noise=0.1)
    one, all_ = few.reset(seed=3)[0], many.reset(seed=3)[0]
    for _ in range(200):
        one, all_ = few.step(one)[0], many.step(all_)[0]
        np.testing.assert_array_equal(one, all_[:num_envs])


def test_one_seed_stands_for_successive_ones() -> None:
    one, other = CrawlerVectorEnv(3), CrawlerVectorEnv(3)
    np.testing.assert_array_equal(one.reset(seed=8)[0], other.reset(seed=[8, 9, 10])[0])
    np.testing.assert_array_equal(one.reset()[0], other.reset(seed=[None, None, None])[0])
    assert [CrawlerEnv().reset(seed=8 + i)[0] for i in range(3)] == one.reset(seed=8)[0].tolist()


def test_without_a_seed_crawlers_differ() -> None:
    starts = [tuple(CrawlerVectorEnv(20).reset()[0]) for _ in range(3)]
    assert len(set(starts)) == 3


def test_gymnasium_makes_it() -> None:
    vector = gym.make_vec(crawler_bench.ENV_ID, num_envs=5, regularization=0.1, noise=[0.0] * 5)
    assert isinstance(vector.unwrapped, CrawlerVectorEnv)
    assert vector.metadata["autoreset_mode"] == gym.make_vec("CartPole-v1").metadata["autoreset_mode"]
    same_step = gym.make_vec(crawler_bench.ENV_ID, num_envs=5, autoreset_mode="SameStep")
    assert same_step.metadata["autoreset_mode"] == AutoresetMode.SAME_STEP
    assert vector.single_action_space == gym.spaces.Discrete(10)
    observation, _ = vector.reset(seed=0)
    assert vector.observation_space.contains(observation)
    observation, rewards, _, truncated, _ = vector.step(vector.action_space.sample())
    assert vector.observation_space.contains(observation)
    assert (rewards.dtype, truncated.dtype) == (np.float64, np.bool_)


def test_results_are_the_callers_to_keep() -> None:
    vector = CrawlerVectorEnv(2)
    observation, infos = vector.reset(seed=0)
    observation, rewards, _, _, infos = vector.step(observation)
    kept = observation.copy(), rewards.copy(), infos["power"].copy(), infos["strain"].copy()
    for _ in range(20):
        vector.step([4, 7])
    for mine, copy in zip((observation, rewards, infos["power"], infos["strain"]), kept, strict=True):
        np.testing.assert_array_equal(mine, copy)


@pytest.mark.parametrize(
    "actions", [[0, 10], [-1, 0], [0], [[0, 1]], [0.5, 1.0], [np.nan, 0], [True, False], ["1", "2"], None, 3]
)
def test_impossible_actions_are_refused_in_one_line(actions: Any) -> None:
    vector = CrawlerVectorEnv(2)
    vector.reset(seed=0)
    before = vector.crawlers.memory.copy()
    with pytest.raises(ValueError, match=r"^actions are not possible: 2 whole numbers from 0 to 9 .*$"):
        vector.step(actions)
    np.testing.assert_array_equal(before, vector.crawlers.memory)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"num_envs": 0}, "num_envs = 0 is not possible"),
        ({"noise": [0.1]}, "noise has 1 values for 2 crawlers"),
        ({"noise": [0.1, -0.1]}, "noise = -0.1 is not possible"),
        ({"time_limit": 0.0}, "time_limit = 0.0 is not possible"),
        ({"parameters": [CrawlerParameters(), CrawlerParameters(n_segments=3)]}, "the same n_segments"),
        ({"render_mode": "human"}, "render_mode = 'human' is not possible: .*HumanRendering"),
        ({"num_envs": 2.5}, "num_envs = 2.5 is not possible"),
        ({"regularization": "0.1"}, "regularization = '0.1' is not possible"),
        ({"episode_distance": [1.0, None]}, "episode_distance = None is not possible"),
        ({"max_episode_steps": 0}, "max_episode_steps = 0 is not possible"),
        ({"autoreset_mode": "never"}, "autoreset_mode = 'never' is not possible: .* 'NextStep', 'SameStep'"),
    ],
)
def test_impossible_arguments_are_refused(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        CrawlerVectorEnv(**({"num_envs": 2} | arguments))


def test_a_wrong_number_of_seeds_is_refused() -> None:
    with pytest.raises(ValueError, match="3 seeds for 2 crawlers"):
        CrawlerVectorEnv(2).reset(seed=[1, 2, 3])
