"""All that decides the future of a long run, in a folder: written whole or not at all, read without pickle.

A checkpoint holds the agent, its replay buffer, the crawlers, and the states of all generators. It is taken
between two rollouts, where Stable-Baselines3 holds nothing else; so a run that goes on gives the numbers of
one that was never interrupted.
"""

import json
import random
import shutil
import time
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from crawler_bench.config.schema import RunConfig
from crawler_bench.runs import store
from crawler_bench.runs.folders import checksums
from crawler_bench.runs.training import LearningRecorder
from crawler_bench.runs.untrusted import MOST_UNPACKED, load_weights, require_bounded

EVALUATIONS = "evaluations.npz"
BUFFER = ("observations", "next_observations", "actions", "rewards", "dones", "timeouts")
# What Stable-Baselines3's agents count, and where they stand between two rollouts.
COUNTS = ("num_timesteps", "_n_updates", "_episode_num", "_current_progress_remaining", "_n_calls")
POSITION = ("_last_obs", "_last_episode_starts")
CRAWLERS = (
    "memory", "generators", "observation", "outcome", "end", "ended", "_decisions", "view", "final_view",
)  # fmt: skip


def save(
    saved: Path,
    agent: Any,
    env: Any,
    recorder: LearningRecorder,
    config: RunConfig,
    seed: int,
    save_every: int,
    evaluations: Path,
) -> None:
    """Write a checkpoint, which takes the place of the one before when it is complete.

    Args:
        saved: its folder.
        agent: that learns, of Stable-Baselines3.
        env: that it learns in.
        recorder: of its learning curve.
        config: of the run.
        seed: of the run.
        save_every: decisions between two checkpoints.
        evaluations: what has been measured on the way, a file that need not be there.
    """
    started = time.monotonic()
    with store.replace(saved) as draft:
        agent.save(draft / "agent.zip")
        store.write_config(draft, config, seed)
        recorder.curve().to_csv(draft / "learning.csv", index=False)
        np.savez(draft / "crawlers.npz", **_crawlers(env))
        np.savez(draft / "position.npz", **{name: getattr(agent, name) for name in POSITION})
        if (buffer := getattr(agent, "replay_buffer", None)) is not None:
            size = buffer.size()
            arrays = {name: getattr(buffer, name)[:size] for name in BUFFER}
            np.savez(draft / "replay_buffer.npz", pos=buffer.pos, full=buffer.full, **arrays)
        if (states := getattr(agent, "_last_lstm_states", None)) is not None:
            np.savez(draft / "lstm.npz", *(each.numpy() for pair in states for each in pair))
        if evaluations.is_file():
            shutil.copy(evaluations, draft / EVALUATIONS)
        (draft / "randomness.json").write_text(json.dumps(_randomness(agent)))
        updates = recorder.gradient_updates
        store.write_manifest(draft, started, gradient_updates=updates, save_every=save_every)


def restore(saved: Path, agent: Any, env: Any, recorder: LearningRecorder) -> None:
    """Put a new agent, its environment and recorder where those of a checkpoint were; nothing is unpickled.

    Raises:
        NotARunError: if the checkpoint is not as it was written, or does not fit.
    """
    hint = f"remove {saved.parent} and train it from the start"
    if reason := checksums.damage(saved, saved.name):
        raise store.NotARunError(f"{reason}; {hint}")
    try:
        _restore(saved, agent, env)
        curve = pd.read_csv(saved / "learning.csv", dtype={"policy": str}, keep_default_na=False)
        recorder.go_on(curve, int(json.loads((saved / store.MANIFEST).read_text())["gradient_updates"]))
    except Exception as error:  # sealed, but by someone else: it may hold anything
        said = " ".join(str(error).split())
        raise store.NotARunError(
            f"{saved} cannot be gone on from: {type(error).__name__}: {said}; {hint}"
        ) from error


def recall(saved: Path, judge: Any, calls: int) -> None:
    """Put an `EvalCallback` of Stable-Baselines3 where that of a checkpoint was.

    Args:
        saved: the checkpoint, where there is one.
        judge: new.
        calls: how often it has been called.

    Raises:
        NotARunError: if what was measured is no table.
    """
    judge.n_calls = calls
    if not (saved / EVALUATIONS).is_file():
        return
    try:
        found = _arrays(saved / EVALUATIONS)
        judge.evaluations_timesteps = found["timesteps"].tolist()
        judge.evaluations_results = found["results"].tolist()
        judge.evaluations_length = found["ep_lengths"].tolist()
    except (OSError, EOFError, KeyError, ValueError, zipfile.BadZipFile) as error:
        raise store.NotARunError(f"{saved / EVALUATIONS} cannot be read ({type(error).__name__})") from None


def _restore(saved: Path, agent: Any, env: Any) -> None:
    load_weights(agent, saved / "agent.zip")
    with zipfile.ZipFile(saved / "agent.zip") as archive:
        plain = json.loads(archive.read("data"))
    for name in COUNTS:
        if name in plain:
            setattr(agent, name, type(getattr(agent, name))(plain[name]))
    _place(env, _arrays(saved / "crawlers.npz"))
    position = _arrays(saved / "position.npz")
    shapes = ((agent.n_envs, *agent.observation_space.shape), (agent.n_envs,))
    for name, shape in zip(POSITION, shapes, strict=True):
        setattr(agent, name, _of_shape(position[name], shape, name))
    if (buffer := getattr(agent, "replay_buffer", None)) is not None:
        _refill(buffer, saved / "replay_buffer.npz")
    if (states := getattr(agent, "_last_lstm_states", None)) is not None:
        import torch

        arrays = _arrays(saved / "lstm.npz").values()
        flat = [each for pair in states for each in pair]
        h, c, value_h, value_c = (
            torch.from_numpy(_of_shape(array, each.shape, "lstm"))
            for array, each in zip(arrays, flat, strict=True)
        )
        agent._last_lstm_states = type(states)((h, c), (value_h, value_c))
    _restore_randomness(agent, json.loads((saved / "randomness.json").read_text()))


def _refill(buffer: Any, path: Path) -> None:
    whole = {name: getattr(buffer, name) for name in BUFFER}
    arrays = _arrays(path, sum(each.nbytes for each in whole.values()) + 2**16)
    pos, full = int(arrays["pos"]), bool(arrays["full"])
    size = buffer.buffer_size if full else pos
    if not 0 <= pos < buffer.buffer_size:
        raise ValueError(f"pos = {pos} is not in the replay buffer")
    for name, place in whole.items():
        place[:size] = _of_shape(arrays[name], (size, *place.shape[1:]), name)
    buffer.pos, buffer.full = pos, full


def _arrays(path: Path, most: int = MOST_UNPACKED) -> dict[str, Any]:
    require_bounded(path, most)
    with np.load(path) as arrays:
        return dict(arrays)


def _of_shape(values: Any, shape: tuple[int, ...], name: str) -> Any:
    """An array, if it is one of this shape, of finite numbers."""
    if values.shape != tuple(shape) or not np.isfinite(values).all():
        raise ValueError(f"{name} is not {' x '.join(map(str, shape))} finite numbers")
    return values


def _crawlers(env: Any) -> dict[str, Any]:
    """All of the crawlers of an environment, as arrays."""
    inner = env.unwrapped
    if hasattr(inner, "crawlers"):
        return {name: getattr(inner.crawlers, name) for name in CRAWLERS if hasattr(inner.crawlers, name)}
    return {"memory": inner.memory, "generators": inner.generator_state}


def _place(env: Any, arrays: dict[str, Any]) -> None:
    inner = env.unwrapped
    if hasattr(inner, "crawlers"):
        inner._seeded = inner.crawlers.begun = True
    else:
        env.reset(seed=0)  # wrappers want one before the first step
    for name, place in _crawlers(env).items():
        place[:] = _of_shape(arrays[name], place.shape, name)


def _randomness(agent: Any) -> dict[str, Any]:
    """The states of all generators that Stable-Baselines3 draws from."""
    import torch

    kind, keys, *rest = np.random.get_state()  # noqa: NPY002 (it draws from NumPy's global generator)
    version, words, gauss = random.getstate()
    return {
        "torch": torch.get_rng_state().tolist(), "numpy": [kind, np.asarray(keys).tolist(), *rest],
        "python": [version, list(words), gauss], "actions": agent.action_space.np_random.bit_generator.state,
    }  # fmt: skip


def _restore_randomness(agent: Any, states: dict[str, Any]) -> None:
    import torch

    torch.set_rng_state(torch.tensor(states["torch"], dtype=torch.uint8))
    kind, keys, *rest = states["numpy"]
    np.random.set_state((kind, np.array(keys, dtype=np.uint32), *rest))  # noqa: NPY002
    version, words, gauss = states["python"]
    random.setstate((version, tuple(words), gauss))
    for space in (agent.action_space, getattr(agent.env, "action_space", agent.action_space)):
        space.np_random.bit_generator.state = states["actions"]
