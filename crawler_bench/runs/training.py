"""Train one agent once, and keep everything that is needed to understand it."""

import inspect
import time
from collections.abc import Callable, Collection
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pandas as pd

import crawler_bench
from crawler_bench.config.errors import ConfigError, nearest
from crawler_bench.config.schema import RunConfig
from crawler_bench.gait.metrics import policy_text
from crawler_bench.runs import store
from crawler_bench.runs.agent import Agent, agent_class, is_stable_baselines
from crawler_bench.runs.policies.table import greedy_policy
from crawler_bench.runs.untrusted import load_weights, require_trust

Progress = Callable[[float], None] | None
Learner = Callable[[RunConfig, int, Progress], tuple[Agent, "LearningRecorder"]]

CURVE_INTERVAL = 1000  # decisions between two points of the learning curve
SNAPSHOTS = 80  # of the table of values, along the run


def make_env(config: RunConfig) -> Any:
    """The environment that a run learns in: one crawler or, for Stable-Baselines3, several.

    Raises:
        ConfigError: if the agent learns from one crawler alone.
    """
    arguments, keyhole = config.environment.task, config.environment.keyhole
    if config.crawlers == 1:
        return gym.make(crawler_bench.KEYHOLE_IDS[keyhole], parameters=config.parameters, **arguments)
    if not is_stable_baselines(agent_class(config.agent)):
        raise ConfigError(
            f"crawlers = {config.crawlers}: {config.agent} learns from one crawler; "
            "only agents of Stable-Baselines3 learn from several"
        )
    # Both load torch.
    from crawler_bench.envs.keyhole_sb3 import KeyholeVecEnv
    from crawler_bench.envs.sb3 import CrawlerVecEnv

    if keyhole == "index":
        return CrawlerVecEnv(config.crawlers, config.parameters, **arguments)
    return KeyholeVecEnv(config.crawlers, config.parameters, **arguments, keyhole=keyhole)


def make_agent(config: RunConfig, env: Any, seed: int) -> Agent:
    """Build the agent of a run; one of Stable-Baselines3 gets its usual network, on the CPU.

    Raises:
        ConfigError: if its class does not know one of the settings.
    """
    kind = agent_class(config.agent)
    known = inspect.signature(kind).parameters
    if not any(parameter.kind is parameter.VAR_KEYWORD for parameter in known.values()):
        names = [name for name in known if name not in ("env", "seed")]
        for key in config.settings:
            if key not in known:
                hint = nearest(key, names) if names else "; it takes no settings"
                raise ConfigError(f"settings: {kind.__name__} knows no {key!r}{hint}")
    usual = _usual_settings(kind) if is_stable_baselines(kind) else {}
    usual = {key: value for key, value in usual.items() if key in known}
    try:
        return kind(env=env, seed=seed, **usual | config.settings)
    except (TypeError, AssertionError) as error:
        raise ConfigError(
            f"{kind.__name__}(env, seed={seed}, **{config.settings}) cannot be made: {error}"
        ) from None


def _usual_settings(kind: Any) -> dict[str, Any]:
    """The network for plain numbers, under the name that an algorithm of Stable-Baselines3 has for it."""
    networks = [name for name in getattr(kind, "policy_aliases", {}) if name.startswith("Mlp")]
    return {"policy": networks[0] if networks else "MlpPolicy", "device": "cpu"}


def load_agent(folder: Path, config: RunConfig, trusted: Collection[str] = ()) -> Agent:
    """Read the agent of a finished run; of one of Stable-Baselines3 the weights, which needs no pickle.

    Args:
        folder: the run.
        config: of the run, as the folder holds it.
        trusted: names of agents that may be imported, and unpickled where they cannot be read otherwise.

    Raises:
        ConfigError: if its class is not to be imported because a file says so.
        NotARunError: if its file is missing or damaged.
    """
    path = agent_file(folder)
    require_trust([config.agent], folder / store.CONFIG, trusted)
    kind = agent_class(config.agent)
    env = make_env(config)
    try:
        if is_stable_baselines(kind):
            try:
                agent = make_agent(config, env, 0)
                load_weights(agent, path)
                return agent
            except Exception as error:
                if config.agent not in trusted:
                    hint = (
                        "its weights alone cannot be read; with --trust it is unpickled, which runs its code"
                    )
                    raise ValueError(f"{' '.join(str(error).split())}: {hint}") from error
        return kind.load(path, env=env)
    except Exception as error:  # the agent may be anyone's, and so is how it fails
        reason = str(error).removeprefix(f"{path} ") if isinstance(error, ValueError) else repr(error)
        raise store.NotARunError(
            f"{path} cannot be loaded: {' '.join(reason.split())}; remove the run {folder} and train it again"
        ) from error


def agent_file(folder: Path) -> Path:
    """The saved agent of a run; one of Stable-Baselines3 is an archive."""
    archive = folder / "agent.zip"
    return archive if archive.is_file() else folder / "agent.json"


def train(
    config: RunConfig,
    seed: int,
    root: Path,
    progress: Callable[[float], None] | None = None,
    learner: Learner | None = None,
    *,
    wait: bool = True,
    say: Callable[[str], None] = store.complain,
) -> Path:
    """Train a run, unless it is there already, and sound.

    Args:
        config: the run.
        seed: of agent and environment.
        root: folder of run folders.
        progress: is told the number of decisions that are done, as often as the agent calls back.
        learner: how to learn; by default `learn`.
        wait: for another process that trains the same run.
        say: told if the run was there, but damaged.

    Returns:
        The run's folder: config.yaml, command.txt, manifest.json, learning.csv, the saved agent and, for an
        agent with a table of values, snapshots.npz (decisions, and the table at each).
    """
    folder = store.run_folder(root, config, seed)

    def write(draft: Path) -> None:
        started = time.monotonic()
        agent, recorder = (learner or learn)(config, seed, progress)
        store.write_config(draft, config, seed)
        store.write_command(draft)
        # Stable-Baselines3 saves an archive, and wants a name that says so.
        agent.save(draft / ("agent.zip" if is_stable_baselines(type(agent)) else "agent.json"))
        recorder.curve().to_csv(draft / "learning.csv", index=False)
        if recorder.snapshots:
            decisions, tables = zip(*recorder.snapshots, strict=True)
            np.savez_compressed(draft / "snapshots.npz", decisions=decisions, q_table=np.array(tables))
        for name, content in recorder.files.items():
            (draft / name).write_bytes(content)
        store.write_manifest(draft, started, seed=seed, agent=config.agent)

    store.make(folder, write, wait=wait, say=say)
    return folder


def learn(
    config: RunConfig,
    seed: int,
    progress: Callable[[float], None] | None = None,
    interval: int = CURVE_INTERVAL,
) -> tuple[Agent, "LearningRecorder"]:
    """Train a run in memory.

    Args:
        config: the run.
        seed: of agent and environment.
        progress: is told the number of decisions that are done, as often as the agent calls back.
        interval: decisions between two points of the learning curve.

    Returns:
        The agent, and the recorder that holds its learning curve.
    """
    env = make_env(config)
    agent = make_agent(config, env, seed)
    recorder = LearningRecorder(env, agent, config.decisions, interval, progress)
    recorder.record(agent)
    agent.learn(config.decisions, callback=recorder, progress_bar=False)
    recorder.record(agent, last=True)
    return agent, recorder


class LearningRecorder:
    """A callback that keeps the learning curve: how far the crawlers have come, and what the agent believes.

    Works with our agents, which call it now and then, and with Stable-Baselines3's, which call it at every
    decision.
    """

    def __init__(
        self,
        env: Any,
        agent: Agent,
        decisions: int,
        interval: int = CURVE_INTERVAL,
        progress: Callable[[float], None] | None = None,
    ) -> None:
        self._progress = progress
        self._crawler: Any = env.unwrapped
        space = env.observation_space
        # Of a table; 0 where there is none.
        self._n = int(space.n) if isinstance(space, gym.spaces.Discrete) else 0
        self._gradient_updates = 0
        optimizer = getattr(getattr(agent, "policy", None), "optimizer", None)
        if optimizer is not None:
            optimizer.register_step_post_hook(self._count_update)
        self._rows: list[tuple[int, int, float, float, str]] = []
        self.snapshots: list[tuple[int, np.ndarray[Any, Any]]] = []
        self.files: dict[str, bytes] = {}  # what else a run's folder shall hold
        self._interval = interval
        self._snapshot_interval = max(interval, decisions // SNAPSHOTS)

    def __call__(self, local: dict[str, Any], _global: dict[str, Any]) -> bool:
        """Record, if it is time; never stops the learning."""
        done = local["self"].num_timesteps
        if not self._rows or done - self._rows[-1][0] >= self._interval:
            self.record(local["self"])
            if self._progress is not None:
                self._progress(done)
        return True

    def _count_update(self, *_: Any) -> None:
        self._gradient_updates += 1

    def record(self, agent: Agent, last: bool = False) -> None:
        """Keep a point of the curve, unless this one is kept already; the last with its table of values."""
        done, table = getattr(agent, "num_timesteps", 0), getattr(agent, "q_table", None)
        if table is not None and last and self.snapshots and self.snapshots[-1][0] != done:
            self.snapshots.append((done, table.copy()))
        if self._rows and done == self._rows[-1][0]:
            return
        greedy = greedy_policy(agent, self._n) if self._n else None
        policy = "" if greedy is None else policy_text(greedy)
        self._rows.append((done, self._gradient_updates, *self._crawler.lifetime, policy))
        if table is not None and (
            not self.snapshots or done - self.snapshots[-1][0] >= self._snapshot_interval
        ):
            self.snapshots.append((done, table.copy()))

    def go_on(self, curve: pd.DataFrame, gradient_updates: int) -> None:
        """Go on from a curve, as `curve` gave it, and a number of gradient updates."""
        self._rows = list(curve.itertuples(index=False, name=None))
        self._gradient_updates = gradient_updates

    @property
    def gradient_updates(self) -> int:
        """Gradient updates so far."""
        return self._gradient_updates

    def curve(self) -> pd.DataFrame:
        """One row per recorded point: decisions, gradient_updates, time, distance, policy (in digits)."""
        return pd.DataFrame(
            self._rows, columns=["decisions", "gradient_updates", "time", "distance", "policy"]
        )
