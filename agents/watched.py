"""Learning that is watched: the callbacks and loggers of Stable-Baselines3, around every single decision.

Its own classes do the work and are imported only where one of them is asked for, as they load torch.
"""

import time
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Union

import gymnasium as gym
import numpy as np
from rich.progress import track

from agents.stepping import Environment, Step

if TYPE_CHECKING:
    from stable_baselines3.common.callbacks import BaseCallback
    from stable_baselines3.common.logger import Logger
    from stable_baselines3.common.vec_env import VecEnv, VecNormalize

FunctionCallback = Callable[[dict[str, Any], dict[str, Any]], bool | None]
Callback = Union[FunctionCallback, "BaseCallback", "list[BaseCallback]", None]
EPISODES_AVERAGED = 100  # in the log, as Stable-Baselines3 does


class Watched:
    """What a learner needs to be watched: attributes and methods that callbacks of Stable-Baselines3 use.

    Attributes:
        num_timesteps: decisions learned from so far.
        n_envs: 1.
        verbose: 1 logs on the screen.
        tensorboard_log: folder to log to, or None.
        ep_info_buffer: return "r", length "l" and seconds "t" of the last episodes that were watched whole.
    """

    CALLBACK_INTERVAL: int
    env: Environment | None
    num_timesteps: int
    n_envs = 1

    def __init__(self, verbose: int, tensorboard_log: str | None) -> None:
        self.verbose, self.tensorboard_log = verbose, tensorboard_log
        self.ep_info_buffer: deque[dict[str, float]] = deque(maxlen=EPISODES_AVERAGED)
        self._logger: Logger | None = None
        self._custom_logger = False
        self._vec_env: VecEnv | None = None
        self._episode_num = 0
        self._started = (time.time(), 0)  # when the present learning began, and from how many decisions

    def get_env(self) -> "VecEnv | None":
        """The environment as Stable-Baselines3 has it, a vector of one; None if there is none."""
        if self.env is None or not isinstance(self.env, gym.Env):
            return self.env
        if self._vec_env is None:
            from stable_baselines3.common.vec_env import DummyVecEnv

            single: Any = self.env
            self._vec_env = DummyVecEnv([lambda: single])
        return self._vec_env

    def get_vec_normalize_env(self) -> "VecNormalize | None":
        """The wrapper that normalizes, if the environment has one."""
        from stable_baselines3.common.vec_env import unwrap_vec_normalize

        vec_env = self.get_env()
        return None if vec_env is None else unwrap_vec_normalize(vec_env)

    @property
    def logger(self) -> "Logger":
        """Where numbers are recorded; without outputs until `learn` or `set_logger` gives it some."""
        if self._logger is None:
            from stable_baselines3.common.logger import Logger

            self._logger = Logger(folder=None, output_formats=[])
        return self._logger

    def set_logger(self, logger: "Logger") -> None:
        """Log there in place of screen and `tensorboard_log`."""
        self._logger, self._custom_logger = logger, True

    def dump_logs(self) -> None:
        """Write the present point of the log, under the names that Stable-Baselines3 has for it."""
        logger, (began, already) = self.logger, self._started
        elapsed = max(time.time() - began, 1e-9)
        if self.ep_info_buffer:
            for name, key in (("rew", "r"), ("len", "l")):
                values = [episode[key] for episode in self.ep_info_buffer]
                logger.record(f"rollout/ep_{name}_mean", float(np.mean(values)))
        logger.record("time/episodes", self._episode_num, exclude="tensorboard")
        logger.record("time/fps", int((self.num_timesteps - already) / elapsed))
        logger.record("time/time_elapsed", int(elapsed), exclude="tensorboard")
        logger.record("time/total_timesteps", self.num_timesteps, exclude="tensorboard")
        logger.dump(step=self.num_timesteps)

    def _is_watched(self, callback: Callback) -> bool:
        """Whether somebody wants to see every decision."""
        of_sb3 = isinstance(callback, list) or hasattr(callback, "init_callback")
        return of_sb3 or self.verbose > 0 or self.tensorboard_log is not None or self._custom_logger

    def _learn_watched(
        self,
        total_timesteps: int,
        callback: Callback,
        log_interval: int | None,
        tb_log_name: str,
        reset_num_timesteps: bool,
        progress_bar: bool,
        in_mid_episode: bool,
    ) -> None:
        from stable_baselines3.common.utils import configure_logger

        if not self._custom_logger:
            self._logger = configure_logger(
                self.verbose,
                self.tensorboard_log,
                tb_log_name,
                reset_num_timesteps or self.num_timesteps == 0,
            )
        if reset_num_timesteps:
            self._episode_num = 0
            self.ep_info_buffer.clear()
        self._started = time.time(), self.num_timesteps
        episode = _Episode(whole=not in_mid_episode)
        callback = self._as_sb3(callback, self.num_timesteps + total_timesteps)
        total_timesteps += self.num_timesteps  # as callbacks of Stable-Baselines3 expect it
        callback.on_training_start(locals(), globals())
        callback.on_rollout_start()
        for _ in track(range(self.num_timesteps, total_timesteps), "learning", disable=not progress_bar):
            action, made = self._decide()
            self.num_timesteps += 1
            actions, new_obs = np.array([action]), np.array([made.observation])
            rewards, dones = np.array([made.reward]), np.array([made.terminated or made.truncated])
            infos = [episode.count(made)]
            callback.update_locals(locals())
            if not callback.on_step():
                break
            if dones[0]:
                self._episode_num += 1
                self.ep_info_buffer.extend([infos[0]["episode"]] if "episode" in infos[0] else [])
                if log_interval is not None and self._episode_num % log_interval == 0:
                    self.dump_logs()
        callback.on_rollout_end()
        callback.on_training_end()

    def _decide(self) -> tuple[int, Step]:
        """Act once and learn from it."""
        raise NotImplementedError

    def _as_sb3(self, callback: Callback, last: int) -> "BaseCallback":
        """One callback of Stable-Baselines3; a function is called as often as if nobody watched."""
        from stable_baselines3.common.callbacks import BaseCallback, CallbackList, ConvertCallback

        if isinstance(callback, list):
            callback = CallbackList(callback)
        if not isinstance(callback, BaseCallback):
            function = callback

            def now_and_then(local: dict[str, Any], global_: dict[str, Any]) -> bool:
                due = self.num_timesteps % self.CALLBACK_INTERVAL == 0 or self.num_timesteps == last
                return not (due and function is not None and function(local, global_) is False)

            callback = ConvertCallback(now_and_then)
        callback.init_callback(self)  # type: ignore[arg-type]
        return callback


class _Episode:
    """Return and length of the present episode, if it is watched from its beginning."""

    def __init__(self, whole: bool) -> None:
        self._whole, self._return, self._length, self._began = whole, 0.0, 0, time.time()

    def count(self, made: Step) -> dict[str, Any]:
        """Count a decision, and return its info as `DummyVecEnv` and `Monitor` give it."""
        self._return += made.reward
        self._length += 1
        if not (made.terminated or made.truncated):
            return made.info
        end = {"terminal_observation": made.outcome, "TimeLimit.truncated": made.truncated}
        if self._whole:
            seconds = time.time() - self._began
            end["episode"] = {"r": round(self._return, 6), "l": self._length, "t": round(seconds, 6)}
        self._whole, self._return, self._length, self._began = True, 0.0, 0, time.time()
        return end | made.info  # a monitor's own report counts
