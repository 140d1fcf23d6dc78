"""Train with habits: save and evaluate on the way, write events, and go on after a kill."""

import json
import shutil
import warnings
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from crawler_bench.config.errors import ConfigError
from crawler_bench.config.schema import RunConfig
from crawler_bench.runs import store
from crawler_bench.runs.agent import Agent, agent_class, is_stable_baselines
from crawler_bench.runs.folders import checksums, claims
from crawler_bench.runs.long.checkpoints import EVALUATIONS, recall, restore, save
from crawler_bench.runs.training import LearningRecorder, Progress, learn, make_agent, make_env, train
from crawler_bench.runs.untrusted import require_trust

UNFINISHED = ".unfinished"  # behind the name of the run's folder


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


def finished(folder: Path) -> Path | None:
    """The folder of a run if it is finished and sound; what a kill in the last moment has left is removed.

    Args:
        folder: of the run, with or without ".unfinished" behind its name.
    """
    name = folder.name.removesuffix(UNFINISHED)
    final = folder.with_name(name)
    if not store.is_run(final) or checksums.damage(final, name):
        return None
    shutil.rmtree(folder.with_name(name + UNFINISHED), ignore_errors=True)
    return final


def read_unfinished(folder: Path, trust: bool = False) -> tuple[RunConfig, int, Habits]:
    """An unfinished run: its configuration, its seed, and how often it is saved.

    Args:
        folder: of the run, with or without ".unfinished" behind its name.
        trust: whether the class that the run names may be imported, whoever's it is.

    Raises:
        ConfigError: if there is no such run, or its agent is neither ours nor installed, nor trusted.
        NotARunError: if it is damaged, or its code has changed since.
    """
    name = folder.name.removesuffix(UNFINISHED)
    saved = _saved(folder.with_name(name + UNFINISHED))
    if not saved.is_dir():
        raise ConfigError(f"{folder} has no checkpoint to go on from: train it from the start")
    config, seed = store.read_run(saved)
    require_trust([config.agent], saved / store.CONFIG, [config.agent] if trust else [])
    if store.run_folder(folder.parent, config, seed).name != name:
        raise store.NotARunError(
            f"{folder} was begun by other sources, with which it cannot go on; train it again from the start"
        )
    told = json.loads((saved / store.MANIFEST).read_text()).get("save_every", 0)
    return config, seed, Habits(save_every=int(told))


def _saved(place: Path) -> Path:
    """The last checkpoint of a run; comes back if a kill came between its renaming and that of the next."""
    claims.sweep(place)
    return place / "checkpoint"


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
    saved, evaluations = _saved(place), place / "evaluations" / EVALUATIONS
    done = 0
    if saved.exists():
        restore(saved, agent, env, recorder)
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
                save(saved, self.model, env, recorder, config, seed, habits.save_every, evaluations)
                self.last = self.num_timesteps

    callbacks: list[BaseCallback] = [ConvertCallback(recorder), Saving()]
    if habits.eval_every:
        freq = max(1, habits.eval_every // config.crawlers)
        judge = EvalCallback(
            _monitored(make_env(config), seed), eval_freq=freq, log_path=str(evaluations.parent), verbose=0
        )
        recall(saved, judge, done // config.crawlers)
        callbacks.append(judge)
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
    if habits.eval_every and evaluations.is_file():
        recorder.files[EVALUATIONS] = evaluations.read_bytes()
    return agent, recorder


def _monitored(env: Any, seed: int) -> Any:
    """An environment to evaluate in, with a seed of its own."""
    from stable_baselines3.common.monitor import Monitor
    from stable_baselines3.common.vec_env import DummyVecEnv, VecEnv, VecMonitor

    vector = VecMonitor(env) if isinstance(env, VecEnv) else DummyVecEnv([lambda: Monitor(env)])
    vector.seed(int(np.random.SeedSequence([seed, 1]).generate_state(1)[0] % 2**31))
    return vector
