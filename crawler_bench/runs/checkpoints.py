"""Long runs of Stable-Baselines3's agents: saved on the way, evaluated on the way, gone on with after a kill.

A checkpoint holds all that decides the future: the agent, its replay buffer, the crawlers, and the states of
all generators. It is taken between two rollouts, where Stable-Baselines3 holds nothing else; so a run that
goes on gives the numbers of one that was never interrupted.
"""

import json
import random
import shutil
import time
import warnings
import zipfile
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from crawler_bench.config.errors import ConfigError
from crawler_bench.config.schema import RunConfig
from crawler_bench.runs import store
from crawler_bench.runs.agent import Agent, agent_class, is_stable_baselines
from crawler_bench.runs.training import LearningRecorder, Progress, learn, make_agent, make_env, train
from crawler_bench.runs.untrusted import load_weights, require_trust

UNFINISHED = ".unfinished"  # behind the name of the run's folder
BUFFER = ("observations", "next_observations", "actions", "rewards", "dones", "timeouts")
# What Stable-Baselines3's agents count, and where they stand between two rollouts.
COUNTS = ("num_timesteps", "_n_updates", "_episode_num", "_current_progress_remaining", "_n_calls")
POSITION = ("_last_obs", "_last_episode_starts")
CRAWLERS = (
    "memory", "generators", "observation", "outcome", "end", "ended", "_decisions", "view", "final_view",
)  # fmt: skip


@dataclass(frozen=True)
class Habits:
    """What a long run does on the way; none of it changes what is learned.

    Attributes:
        save_every: decisions between two checkpoints, rounded up to whole rollouts; 0 is never.
        eval_every: decisions between two evaluations by Stable-Baselines3's `EvalCallback`, which leaves
            evaluations.npz in the run's folder; 0 is never.
        tensorboard: folder of its event files; None writes none.
    """

    save_every: int = 0
    eval_every: int = 0
    tensorboard: Path | None = None

    @property
    def any(self) -> bool:
        """Whether there is anything to do."""
        return bool(self.save_every or self.eval_every or self.tensorboard)


def train_long(config: RunConfig, seed: int, root: Path, habits: Habits, progress: Progress = None) -> Path:
    """Train as `train` does, with habits; goes on from a checkpoint of the same run, if there is one.

    Raises:
        ConfigError: if the agent is not one of Stable-Baselines3.
    """
    require_possible(config, habits)
    final = store.run_folder(root, config, seed)
    place = final.with_name(final.name + UNFINISHED)

    def learner(config: RunConfig, seed: int, progress: Progress) -> tuple[Agent, LearningRecorder]:
        return _learn(config, seed, place, habits, progress)

    folder = train(config, seed, root, progress, learner)
    shutil.rmtree(place, ignore_errors=True)
    return folder


def read_unfinished(folder: Path, trust: bool = False) -> tuple[RunConfig, int, Habits]:
    """An unfinished run: its configuration, its seed, and how often it is saved.

    Args:
        folder: of the run, with or without ".unfinished" behind its name.
        trust: import its agent, whatever it is.

    Raises:
        ConfigError: if there is no such run, or its agent is not to be imported because a file says so.
        NotARunError: if it is damaged, or its code has changed since.
    """
    name = folder.name.removesuffix(UNFINISHED)
    saved = folder.with_name(name + UNFINISHED) / "checkpoint"
    if not store.is_run(saved):
        raise ConfigError(f"{folder} has no checkpoint to go on from: train it from the start")
    config, seed = store.read_run(saved)
    require_trust([config.agent], saved / store.CONFIG, [config.agent] if trust else ())
    if store.run_folder(folder.parent, config, seed).name != name:
        raise store.NotARunError(
            f"{folder} was begun by other sources, with which it cannot go on; train it again from the start"
        )
    told = json.loads((saved / store.MANIFEST).read_text())
    return config, seed, Habits(save_every=int(told["save_every"]))


def require_possible(config: RunConfig, habits: Habits) -> None:
    """Refuse habits that an agent cannot have, or this installation.

    Raises:
        ConfigError: saying what is missing.
    """
    if not is_stable_baselines(agent_class(config.agent)):
        raise ConfigError(
            f"{config.agent} is no agent of Stable-Baselines3, and only those save, evaluate and log on the "
            "way; a table learns in seconds: train it without --save-every, --eval-every, --tensorboard"
        )
    if habits.tensorboard is not None and find_spec("tensorboard") is None:
        raise ConfigError(
            "--tensorboard needs the package tensorboard: pip install 'crawler-bench[tensorboard]'"
        )


def _learn(
    config: RunConfig, seed: int, place: Path, habits: Habits, progress: Progress
) -> tuple[Agent, LearningRecorder]:
    """Learn as `training.learn` does, from the start or from a checkpoint."""
    if not habits.any and not place.exists():
        return learn(config, seed, progress)
    from stable_baselines3.common.callbacks import BaseCallback, CallbackList, ConvertCallback, EvalCallback

    env = make_env(config)
    agent: Any = make_agent(config, env, seed)
    recorder = LearningRecorder(env, agent, config.decisions, progress=progress)
    saved = place / "checkpoint"
    done = 0
    if (saved / store.MANIFEST).is_file():
        _restore(saved, agent, env)
        curve = pd.read_csv(saved / "learning.csv", dtype={"policy": str}, keep_default_na=False)
        recorder.go_on(curve, json.loads((saved / store.MANIFEST).read_text())["gradient_updates"])
        done = agent.num_timesteps
    else:
        recorder.record(agent)

    class Saving(BaseCallback):
        """Saves between two rollouts."""

        last = done

        def _on_step(self) -> bool:
            return True

        def _on_rollout_start(self) -> None:
            if habits.save_every and self.num_timesteps - self.last >= habits.save_every:
                _save(saved, self.model, env, recorder, config, seed, habits)
                self.last = self.num_timesteps

    callbacks: list[BaseCallback] = [ConvertCallback(recorder), Saving()]
    if habits.eval_every:
        log = place / "evaluations"
        freq = max(1, habits.eval_every // config.crawlers)
        callbacks.append(
            EvalCallback(_monitored(make_env(config), seed), eval_freq=freq, log_path=str(log), verbose=0)
        )
    if habits.tensorboard is not None:
        agent.tensorboard_log = str(habits.tensorboard)
    with warnings.catch_warnings():
        # Rewards are scaled where it learns, and not where it is evaluated: that is meant.
        warnings.filterwarnings("ignore", "Training and eval env are not of the same type")
        agent.learn(
            config.decisions - done, callback=CallbackList(callbacks), progress_bar=False,
            reset_num_timesteps=done == 0, tb_log_name=place.name.removesuffix(UNFINISHED),
        )  # fmt: skip
    recorder.record(agent, last=True)
    if habits.eval_every and (place / "evaluations" / "evaluations.npz").is_file():
        recorder.files["evaluations.npz"] = (place / "evaluations" / "evaluations.npz").read_bytes()
    return agent, recorder


def _monitored(env: Any, seed: int) -> Any:
    """An environment to evaluate in, with a seed of its own."""
    from stable_baselines3.common.monitor import Monitor
    from stable_baselines3.common.vec_env import DummyVecEnv, VecEnv, VecMonitor

    vector = VecMonitor(env) if isinstance(env, VecEnv) else DummyVecEnv([lambda: Monitor(env)])
    vector.seed(int(np.random.SeedSequence([seed, 1]).generate_state(1)[0] % 2**31))
    return vector


def _save(
    saved: Path,
    agent: Any,
    env: Any,
    recorder: LearningRecorder,
    config: RunConfig,
    seed: int,
    habits: Habits,
) -> None:
    """Write a checkpoint, which takes the place of the one before when it is complete."""
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
        (draft / "randomness.json").write_text(json.dumps(_randomness(agent)))
        updates = recorder.gradient_updates
        store.write_manifest(draft, started, gradient_updates=updates, save_every=habits.save_every)


def _restore(saved: Path, agent: Any, env: Any) -> None:
    """Put a new agent and its environment where those of a checkpoint were; nothing is unpickled."""
    load_weights(agent, saved / "agent.zip")
    with zipfile.ZipFile(saved / "agent.zip") as archive:
        plain = json.loads(archive.read("data"))
    for name in COUNTS:
        if name in plain:
            setattr(agent, name, plain[name])
    with np.load(saved / "crawlers.npz") as arrays:
        _place(env, dict(arrays))
    with np.load(saved / "position.npz") as arrays:
        for name in POSITION:
            setattr(agent, name, arrays[name])
    if (saved / "replay_buffer.npz").is_file():
        with np.load(saved / "replay_buffer.npz") as arrays:
            buffer = agent.replay_buffer
            for name in BUFFER:
                getattr(buffer, name)[: len(arrays[name])] = arrays[name]
            buffer.pos, buffer.full = int(arrays["pos"]), bool(arrays["full"])
    if (saved / "lstm.npz").is_file():
        import torch

        with np.load(saved / "lstm.npz") as arrays:
            h, c, value_h, value_c = (torch.from_numpy(arrays[name]) for name in arrays.files)
        agent._last_lstm_states = type(agent._last_lstm_states)((h, c), (value_h, value_c))
    _restore_randomness(agent, json.loads((saved / "randomness.json").read_text()))


def _crawlers(env: Any) -> dict[str, Any]:
    """All of the crawlers of an environment, as arrays."""
    inner = env.unwrapped
    if hasattr(inner, "crawlers"):
        return {name: getattr(inner.crawlers, name) for name in CRAWLERS if hasattr(inner.crawlers, name)}
    return {"memory": inner.memory, "generators": inner.generator_state}


def _place(env: Any, arrays: dict[str, Any]) -> None:
    inner = env.unwrapped
    if hasattr(inner, "crawlers"):
        for name, values in arrays.items():
            getattr(inner.crawlers, name)[:] = values
        inner._seeded = inner.crawlers.begun = True
        return
    env.reset(seed=0)  # wrappers want one before the first step
    inner.memory[:] = arrays["memory"]
    inner.generator_state[:] = arrays["generators"]


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
