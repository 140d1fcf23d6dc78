"""A trained crawler that lives on: decision after decision, with noise that changes and kicks that come."""

from collections import deque
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crawler_bench.config.schema import RunConfig
from crawler_bench.envs.crawler import CrawlerEnv
from crawler_bench.envs.keyhole_envs import KeyholeEnv
from crawler_bench.envs.keyholes import INDEX, NOISE
from crawler_bench.gait.record import Array
from crawler_bench.gait.stepwise import Policy
from crawler_bench.runs import store
from crawler_bench.runs.policies import files as policy_files
from crawler_bench.runs.policies.acting import policy_of
from crawler_bench.runs.training import load_agent

RECENT = 200  # decisions over which the speed is taken
MOST_NOISE = 1.0
KICK = 0.3  # L by which a kick pushes the segments behind a node towards the head


class Live:
    """A crawler that follows a policy for ever.

    Args:
        run: what the policy was trained in.
        policy: a table, (N, N), or what is asked at every decision.
        seed: of its draws, the noise and the kicks.
    """

    def __init__(self, run: RunConfig, policy: Array | Policy, seed: int) -> None:
        keyhole = run.environment.keyhole
        endless: Any = {"episode_distance": np.inf, "time_limit": np.inf}
        self.env: Any = (
            CrawlerEnv(run.parameters, **endless)
            if keyhole == INDEX
            else KeyholeEnv(run.parameters, **endless, keyhole=keyhole)
        )
        self.policy = policy
        self.rng = np.random.default_rng([seed, 2020])
        self.seen, info = self.env.reset(seed=seed)
        self.state: Any = None
        self.begins = np.ones(1, dtype=np.bool_)
        self.displacement: Array = np.zeros(run.parameters.n_segments + 1)
        self.time = float(info["time"])
        self.recent: deque[tuple[float, float]] = deque([(0.0, 0.0)], maxlen=RECENT + 1)

    @property
    def noise(self) -> float:
        """Largest error of a sensed strain."""
        return float(self.env.task[0][NOISE])

    @noise.setter
    def noise(self, level: float) -> None:
        self.env.task[0][NOISE] = min(max(level, 0.0), MOST_NOISE)

    @property
    def speed(self) -> float:
        """Mean speed of the centroid over the last decisions, L / tau_theta."""
        (first, before), (last, now) = self.recent[0], self.recent[-1]
        return (now - before) / (last - first) if last > first else 0.0

    def advance(self) -> None:
        """Decide once."""
        if isinstance(self.policy, np.ndarray):
            action = int(self.rng.choice(len(self.policy), p=self.policy[int(self.seen)]))
        else:
            chosen, self.state = self.policy(np.asarray(self.seen)[None], self.state, self.begins)
            self.begins, action = np.zeros_like(self.begins), int(chosen[0])
        self.seen, _, _, _, info = self.env.step(action)
        self.displacement = self.env.nodes["displacement"].copy()
        self.time = float(info["time"])
        self.recent.append((self.time, float(info["centroid"])))

    def kick(self) -> None:
        """Push all segments behind a random node towards the head: one segment is compressed at once."""
        snapshot = self.env.get_state()
        displacement: NDArray[np.float64] = np.array(snapshot["state"][0])
        displacement[int(self.rng.integers(1, displacement.size)) :] += KICK
        snapshot["state"][0] = displacement.tolist()
        self.env.set_state(snapshot | {"layout": []})  # its trajectory is not that of the body any more
        self.displacement = displacement


def live(path: Path, mode: str, seed: int, trust: bool = False) -> Live:
    """The crawler of a run folder or a policy file, alive.

    Args:
        path: the folder, or the JSON file of a policy.
        mode: "deterministic" or "stochastic".
        seed: of everything that is drawn.
        trust: import and unpickle the agent that the folder names, whoever's it is.

    Raises:
        NotARunError: if it is neither.
    """
    if path.suffix in (".json", ".zip"):
        policy = policy_files.read_policy(path)
        return Live(policy.config, policy.table_of(mode), seed)
    config, _ = store.read_run(path)
    known = "stochastic" if mode == "stochastic" else "deterministic"
    agent = load_agent(path, config, [config.agent] if trust else [])
    acts = policy_of(agent, config.environment.keyhole, known, config.parameters.n_segments, seed)  # type: ignore[arg-type]
    return Live(config, acts, seed)
