"""Data of docs/playground: the constants that the page starts from, and trajectories that it is held to.

The page has its own physics, written in JavaScript. Its constants come from here, so that page and package
cannot drift apart; the trajectories are what the package's physics made of the same actions.
"""

import importlib
import inspect
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from crawler_bench import ENV_ID
from crawler_bench.physics.parameters import CHOICES, CrawlerParameters
from crawler_bench.physics.state import STATE

# One digit per observation: the neuron that is switched on. "unregularized" is a table that the paper's
# learner found with epsilon = 0, "fastest" the best that `search_fastest` has found so far.
POLICIES = {"regularized": "0123456789", "unregularized": "4902305788", "fastest": "6650073678"}

# The page steps in its own way, and decides at every interval.
OF_THE_ENGINE = ("dt", "integrator", "decide_on", "longest_hold")

# What the recorded trajectories vary: each entry goes on top of the defaults.
READINGS: tuple[dict[str, Any], ...] = (
    {}, {}, {}, {"spike_phase": "every_pi"},
    {"friction_law": "literal"}, {"head_muscle": "external"}, {"head_muscle": "none"},
    {"spike_phase": "2pi"}, {"observation": "most_stretched"},
    {"tau_f": 1.0, "tau_m": 1.0}, {"tau_f": 1.0, "neuron_rate": 4.0, "spike_gain": 1.0},
    {"tau_f": 0.674, "neuron_rate": 2.579, "spike_gain": 1.354, "decision_interval": 0.25},
    {"neuron_rate": 3.0, "spike_gain": 1.2, "decision_interval": 0.3}, {"decision_interval": 2.0},
    {"n_segments": 4}, {"n_segments": 7, "damping": 1.0}, {"muscle_force_max": 2.0},
    {"friction_backward": 0.6}, {"friction_forward": 0.1, "friction_backward": 0.3}, {"tau_m": 2.5},
)  # fmt: skip


def defaults() -> dict[str, Any]:
    """Constants, choices, settings of the learner and policies that the page starts from."""
    parameters = {
        name: value for name, value in asdict(CrawlerParameters()).items() if name not in OF_THE_ENGINE
    }
    learner = _default_arguments(importlib.import_module("agents.qlearning").QLearning)
    task = _default_arguments(importlib.import_module("crawler_bench.envs.crawler").CrawlerEnv)
    settings = {name: learner[name] for name in ("learning_rate", "discount", "initial_q")}
    settings |= {name: task[name] for name in ("regularization", "episode_distance", "time_limit")}
    return {
        "parameters": parameters,
        "choices": {name: values for name, values in CHOICES.items() if name not in OF_THE_ENGINE},
        "learner": settings,
        "policies": POLICIES,
    }


def _default_arguments(of: type) -> dict[str, Any]:
    return {name: each.default for name, each in inspect.signature(of).parameters.items()}


def defaults_script() -> str:
    """`defaults` as the text of docs/playground/defaults.js."""
    head = (
        '"use strict";\n// Written by crawler_bench/report/playground.py from the package\'s own defaults.\n'
    )
    return f"{head}const DEFAULTS = {json.dumps(defaults(), indent=2)};\n"


def record_trajectories(decisions: int = 250, seed: int = 0) -> list[dict[str, Any]]:
    """Crawl once with each of READINGS, following a table that errs now and then.

    Args:
        decisions: of each trajectory.
        seed: of the errors.

    Returns:
        For each: "parameters"; "actions" and "observations", (decisions,); "displacement" of each node after
        each decision, L, (decisions, N + 1); "spikes", pairs of a neuron and a time (tau_theta), in order.
    """
    rng = np.random.default_rng(seed)
    tables = [POLICIES["regularized"], POLICIES["unregularized"]]
    return [
        _record(CrawlerParameters(**reading), tables[i % 2], decisions, rng)
        for i, reading in enumerate(READINGS)
    ]


def write_trajectories(path: Path, decisions: int = 250, seed: int = 0) -> None:
    """Write `record_trajectories` as JSON."""
    path.write_text(json.dumps(record_trajectories(decisions, seed)), encoding="utf-8")


def _record(p: CrawlerParameters, table: str, decisions: int, rng: np.random.Generator) -> dict[str, Any]:
    parts = _parts(p)
    in_parts = replace(p, decision_interval=p.decision_interval / parts)
    env = gym.make(ENV_ID, parameters=in_parts, episode_distance=math.inf, time_limit=math.inf)
    crawler: Any = env.unwrapped
    observation, _ = env.reset(seed=int(rng.integers(2**31)))
    actions, observations, displacement, spikes = [], [], [], []
    drive = np.zeros(p.n_segments + 1)
    for _ in range(decisions):
        errs = rng.random() < 0.2
        action = int(rng.integers(p.n_segments)) if errs else int(table[observation]) % p.n_segments
        for _ in range(parts):
            observation, _, _, _, info = env.step(action)
            drive, before = np.array(crawler.get_state()["state"][STATE.index("drive")]), drive
            spikes += _spikes(in_parts, before, drive, info["time"])
        actions.append(action)
        observations.append(int(observation))
        displacement.append(_displacement(info).tolist())
    env.close()
    parameters = {name: value for name, value in asdict(p).items() if name not in OF_THE_ENGINE}
    spikes.sort(key=lambda spike: spike[1])
    return {
        "parameters": parameters, "actions": actions, "observations": observations,
        "displacement": displacement, "spikes": spikes,
    }  # fmt: skip


def _parts(p: CrawlerParameters) -> int:
    """Parts of a decision interval, each shorter than the time between two spikes of a neuron that is ON."""
    steps, turn = p.steps_per_decision, math.pi / (2 if p.spike_phase == "every_pi" else 1)
    return next(m for m in range(1, steps + 1) if steps % m == 0 and steps / m * p.dt < turn / p.neuron_rate)


def _displacement(info: Mapping[str, Any]) -> NDArray[np.float64]:
    """(N + 1,) displacement of each node, L, from strains and centroid."""
    shape = np.concatenate(([0.0], np.cumsum(info["strain"])))
    return np.asarray(shape - shape.mean() + info["centroid"], dtype=np.float64)


def _spikes(
    p: CrawlerParameters, before: NDArray[np.float64], after: NDArray[np.float64], now: float
) -> list[tuple[int, float]]:
    """Spikes of the decision interval that ends now, told from what they left in the drives of eq. 5.

    A neuron spikes at most once in it, see `_parts`.
    """
    left = after - before * math.exp(-p.decision_interval / p.tau_m)
    return [(int(i), now + p.tau_m * math.log(left[i] / p.spike_gain)) for i in np.flatnonzero(left > 1e-9)]


def mean_speeds(
    tables: Sequence[Sequence[int]], starts: int = 6, duration: float = 400.0, noise: float = 0.0
) -> list[float]:
    """Mean speed (L/tau_theta) of each table over the same starts, with the default constants.

    Args:
        tables: one action per observation, 0 to N - 1.
        starts: number of starts, each after 100 tau_theta of random action.
        duration: time over which a speed is taken, tau_theta, after 100 tau_theta to settle.
        noise: largest error of a sensed strain.
    """
    p = CrawlerParameters()
    envs = gym.make_vec(
        ENV_ID, num_envs=len(tables) * starts, vectorization_mode="vector_entry_point",
        parameters=p, noise=noise, episode_distance=math.inf, time_limit=math.inf,
    )  # fmt: skip
    seeds: Any = list(range(starts)) * len(tables)
    observations, _ = envs.reset(seed=seeds)
    policy = np.repeat(np.array(tables), starts, axis=0)
    rng, rows = np.random.default_rng(1), np.arange(len(policy))
    settle = round(100 / p.decision_interval)
    for _ in range(settle):
        envs.step(np.tile(rng.integers(p.n_segments, size=starts), len(tables)))
    begin = np.zeros(len(policy))
    info: Mapping[str, Any] = {}
    for decision in range(settle + round(duration / p.decision_interval)):
        observations, _, _, _, info = envs.step(policy[rows, observations])
        begin = info["centroid"] if decision == settle - 1 else begin
    envs.close()
    speeds = (info["centroid"] - begin) / duration
    return [float(speed) for speed in speeds.reshape(len(tables), starts).mean(axis=1)]


def search_fastest(start: str, rounds: int = 60, seed: int = 0) -> tuple[str, float]:
    """Look for a faster table: climb entry by entry, then change three entries of the best and climb again.

    Args:
        start: the table to begin with, one digit per observation.
        rounds: number of climbs; one takes some five seconds.
        seed: of the changes.

    Returns:
        The fastest table and its mean speed, L/tau_theta.
    """
    rng = np.random.default_rng(seed)
    best, speed = _climb([int(digit) for digit in start])
    for _ in range(rounds - 1):
        changed = list(best)
        for o in rng.choice(len(best), size=3, replace=False):
            changed[o] = int(rng.integers(len(best)))
        found, found_speed = _climb(changed)
        if found_speed > speed:
            best, speed = found, found_speed
    return "".join(map(str, best)), speed


def _climb(table: list[int]) -> tuple[list[int], float]:
    """The table at the top: no change of a single entry makes it faster."""
    speed = mean_speeds([table])[0]
    while True:
        neighbours = [
            [*table[:o], action, *table[o + 1 :]]
            for o in range(len(table)) for action in range(len(table)) if action != table[o]
        ]  # fmt: skip
        speeds = mean_speeds(neighbours)
        if max(speeds) <= speed:
            return table, speed
        speed = max(speeds)
        table = neighbours[speeds.index(speed)]
