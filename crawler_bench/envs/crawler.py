"""The crawler as a Gymnasium environment."""

from dataclasses import asdict
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.envs.registration import EnvSpec
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from crawler_bench.envs.arguments import require_parameters
from crawler_bench.envs.randomness import live_state
from crawler_bench.envs.specification import with_longest_episode
from crawler_bench.envs.transition import RUNNING, begin, decide_and_report, make_task, most_decisions, report
from crawler_bench.physics.crawler import measure
from crawler_bench.physics.parameters import CrawlerParameters
from crawler_bench.physics.state import STATE, layout, make_memory, nodes_of, odometer_of

Info = dict[str, Any]
_COUNTS = ("episode_intervals", "lifetime_intervals", "lifetime_distance", "observation")


class CrawlerEnv(gym.Env[np.int64, np.int64]):
    """A soft-bodied crawler that learns to coordinate its segments.

    ## Description

    The neuromechanical model of a *Drosophila* larva of Mishra, van Rees & Mahadevan 2020 ("Coordinated
    crawling via reinforcement learning", [M20]): N viscoelastic segments in a row on ground that holds them
    back with less friction forward than backward, each contracted by a muscle that one spiking neuron drives.
    The task is to crawl forward. Lengths are in units of the segment length L, times in the neuronal time
    scale tau_theta, forces in k L (k: stiffness of a segment). The constants, and the readings of what the
    paper leaves open, are `CrawlerParameters`.

    ## Action space

    `Discrete(N)`: the one neuron that is ON during the decision interval [M20, eq. 10].

    | action         | neurons ON                   | what contracts                               |
    |----------------|------------------------------|----------------------------------------------|
    | 0              | 0 (head) and N (tail)        | segment N; muscle 0 pushes the head forward  |
    | a = 1 .. N - 1 | a                            | segment a, counted from 1 at the head        |

    ## Observation space

    `Discrete(N)`: the index, from 0 at the head to N - 1 at the tail, of the most contracted segment
    [M20, eq. 9]; ties, as in the undeformed body, are broken at random. Observation o means segment o + 1, so
    the paper's nearest-neighbour wiring is the policy action = observation. With `noise` = s, every strain is
    sensed with an error that is uniform in [-s, s].

    ## Reward

    Displacement of the centroid during the decision interval (L), minus `regularization` times the largest
    |u_{i+1} - 2 u_i + u_{i-1}| at its end [M20, eq. 11].

    ## Starting state

    The undeformed body at rest: no strain, no force, silent neurons.

    ## Episode end

    Crawling is a continuing task, so both ends are truncations and a learner bootstraps through them.

    | `info["end"]` | flag       | when                                                    |
    |---------------|------------|---------------------------------------------------------|
    | 0, RUNNING    | -          | the episode goes on                                     |
    | 1, DISTANCE   | truncation | the centroid has advanced by `episode_distance`         |
    | 2, TIME       | truncation | `time_limit` has passed                                 |

    `spec.max_episode_steps` is the number of decisions within the time limit. With another one in `gym.make`,
    Gymnasium's `TimeLimit` truncates, and `info["end"]` is 0.

    ## Info

    Noise-free physics, after `reset` and `step` alike; arrays are the caller's to keep.

    | key               | shape    | unit           | what                                             |
    |-------------------|----------|----------------|--------------------------------------------------|
    | `time`            | float    | tau_theta      | since the start of the episode                   |
    | `centroid`        | float    | L              | displacement of the centroid since the start     |
    | `displacement`    | float    | L              | of the centroid during this decision             |
    | `strain_gradient` | float    | -              | largest second difference of u, r_2 of eq. 11    |
    | `strain`          | (N,)     | -              | u_i - u_{i-1}, contraction positive              |
    | `muscle_force`    | (N + 1,) | k L            | f_0 .. f_N                                       |
    | `node_velocity`   | (N + 1,) | L/tau_theta    | du/dt, forward positive                          |
    | `power`           | (N + 1,) | k L^2/tau_theta| net muscle force on a node times its speed       |
    | `end`             | int      | -              | how the episode ended, see above                 |

    ## Arguments

    * `parameters`: `CrawlerParameters`, default the readings that `CrawlerParameters()` documents.
    * `regularization`: epsilon of eq. 11, at least 0, default 0.01.
    * `noise`: s, at least 0, default 0.
    * `episode_distance`: L, above 0 (infinity allowed), default 8.83.
    * `time_limit`: tau_theta, above 0 (infinity allowed), default 4000.
    * `render_mode`: `None`, `"rgb_array"` or `"human"`.

    ## Version History

    * v0: first version.
    """

    metadata: dict[str, Any] = {"render_modes": ["human", "rgb_array"], "render_fps": 25}  # noqa: RUF012 (Gymnasium declares it as an attribute of instances)

    def __init__(
        self,
        parameters: CrawlerParameters | None = None,
        regularization: float = 0.01,
        noise: float = 0.0,
        episode_distance: float = 8.83,
        time_limit: float = 4000.0,
        render_mode: str | None = None,
    ) -> None:
        if render_mode is not None and render_mode not in self.metadata["render_modes"]:
            raise ValueError(
                f"render_mode = {render_mode!r} is not possible: it must be None, 'human' or 'rgb_array'"
            )
        self.parameters = require_parameters(CrawlerParameters() if parameters is None else parameters)
        self.render_mode = render_mode
        # As given, in the order in which `make_task` takes them; changing them here changes nothing.
        self.settings = (regularization, noise, episode_distance, time_limit)
        self.task = make_task(self.parameters, *self.settings)
        self.memory = make_memory(self.parameters.n_segments)
        self.observation_space = gym.spaces.Discrete(self.parameters.n_segments)
        self.action_space = gym.spaces.Discrete(self.parameters.n_segments)
        self._views: tuple[Any, Any] | None = None
        self._viewed_generator: np.random.Generator | None = None
        self._generator_state = np.empty(0, dtype=np.uint64)
        self._renderer: Any = None
        self._begun = False

    @property
    def spec(self) -> EnvSpec | None:
        """As `gym.make` has set it, with the longest episode in it."""
        return self._spec

    @spec.setter
    def spec(self, spec: EnvSpec | None) -> None:
        self._spec = with_longest_episode(spec, most_decisions(self.parameters, self.settings[-1]))

    _spec: EnvSpec | None = None

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, Info]:
        """Put the crawler to rest and observe it; `options` has no meaning here."""
        super().reset(seed=seed)
        observation = begin(self.memory, self.task, self.generator_state)
        self._begun = True
        if self.render_mode == "human":
            self.render()
        return observation, self._info(0.0, 0.0, 0.0, RUNNING)

    def step(self, action: Any) -> tuple[Any, float, bool, bool, Info]:
        """Hold one neuron ON for a decision interval.

        Raises:
            ValueError: if the action is not a neuron, 0 to N - 1.
            ResetNeeded: if no episode has begun.
        """
        if not self._begun:
            raise ResetNeeded("the crawler has no episode yet: call reset() before step()")
        if not self.action_space.contains(action) or isinstance(action, bool):
            last = self.parameters.n_segments - 1
            raise ValueError(f"action {action!r} is not possible: it must be a whole number from 0 to {last}")
        observation, reward, displacement, gradient, centroid, end = decide_and_report(
            self.memory, int(action), self.task, self.generator_state
        )
        if self.render_mode == "human":
            self.render()
        info = self._info(displacement, gradient, centroid, end)
        return observation, reward, False, end != RUNNING, info

    @property
    def generator_state(self) -> NDArray[np.uint64]:
        """(4,) live state of `np_random`, for compiled code."""
        generator = self.np_random
        if generator is not self._viewed_generator:
            self._viewed_generator, self._generator_state = generator, live_state(generator)
        return self._generator_state

    @property
    def nodes(self) -> Any:
        """State of every node, (N + 1,) records, see physics/state.py; `report` completes it."""
        return self._named()[0]

    @property
    def odometer(self) -> Any:
        """What is counted over decisions, a record."""
        return self._named()[1]

    def _named(self) -> tuple[Any, Any]:
        """Nodes and odometer, kept: making them takes longer than a decision. A copy makes its own."""
        if self._views is None:
            self._views = nodes_of(self.memory), odometer_of(self.memory)
        return self._views

    def _info(self, displacement: float, gradient: float, centroid: float, end: int) -> Info:
        nodes = self.nodes
        return {
            "time": self._time(),
            "centroid": centroid,
            "displacement": displacement,
            "strain_gradient": gradient,
            "strain": nodes["strain"][:-1].copy(),
            "muscle_force": nodes["force"].copy(),
            "node_velocity": nodes["velocity"].copy(),
            "power": nodes["power"].copy(),
            "end": end,
        }

    def _time(self) -> float:
        return float(self.odometer["episode_intervals"]) * self.parameters.decision_interval

    @property
    def lifetime(self) -> tuple[float, float]:
        """Time (tau_theta) and distance (L) crawled in all episodes so far."""
        odometer = self.odometer
        time = odometer["lifetime_intervals"] * self.parameters.decision_interval
        return float(time), float(odometer["lifetime_distance"])

    def get_state(self) -> dict[str, Any]:
        """Everything that decides the future, as plain values that JSON can hold exactly."""
        report(self.memory, self.task)
        return {
            "state": [self.nodes[name].tolist() for name in STATE],
            "odometer": [float(self.odometer[name]) for name in _COUNTS],
            "memory": self.memory.tolist(),
            "layout": layout(),
            "parameters": asdict(self.parameters),
            "generator": self.np_random.bit_generator.state,
        }

    def set_state(self, snapshot: dict[str, Any]) -> None:
        """Go on from what `get_state` gave, in this or another process.

        With a trajectory of another version, or one of other parameters, the crawler goes on from the state
        alone: to rounding, not to the last bit.

        Raises:
            ValueError: if a part is missing, has another shape or holds a number that is not finite.
        """
        if not isinstance(snapshot, dict):
            raise ValueError(f"a crawler's state is a dictionary, not a {type(snapshot).__name__}")
        state = _finite(snapshot, "state", (len(STATE), self.nodes.size))
        odometer = _finite(snapshot, "odometer", (len(_COUNTS),))
        same_layout = snapshot.get("layout") == layout()
        keeps_trajectory = same_layout and snapshot.get("parameters") == asdict(self.parameters)
        memory = _finite(snapshot, "memory", self.memory.shape) if keeps_trajectory else 0.0
        try:
            np.random.PCG64().state = snapshot["generator"]
        except (KeyError, TypeError, ValueError, OverflowError) as error:
            raise ValueError(f"the crawler's generator is not the state of a PCG64: {error!r}") from None
        self.memory[:] = memory
        if not keeps_trajectory:
            for name, row in zip(STATE, state, strict=True):
                self.nodes[name] = row
            for name, count in zip(_COUNTS, odometer, strict=True):
                self.odometer[name] = count
            self.odometer.centroid, _ = measure(self.nodes)
        self.np_random.bit_generator.state = snapshot["generator"]
        self._begun = True

    def render(self) -> NDArray[np.uint8] | None:
        """Draw the body, each segment coloured by its contraction.

        Returns:
            A picture of shape (height, width, 3) in mode "rgb_array", else None.
        """
        if self.render_mode is None:
            gym.logger.warn('render() needs a render mode: gym.make(..., render_mode="rgb_array")')
            return None
        from crawler_bench.envs.rendering import draw_crawler, show

        picture = draw_crawler(self.nodes["displacement"], self._time())
        if self.render_mode == "rgb_array":
            return picture
        self._renderer = show(picture, self._renderer, self.metadata["render_fps"])
        return None

    def close(self) -> None:
        """Close the window, if there is one."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None

    def __getstate__(self) -> dict[str, Any]:
        own = ("_renderer", "_views", "_viewed_generator", "_generator_state")  # not of a copy
        return self.__dict__ | dict.fromkeys(own)


def _finite(snapshot: dict[str, Any], name: str, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """A part of a snapshot as an array of this shape."""
    try:
        values = np.array(snapshot[name], dtype=np.float64)
    except (KeyError, TypeError, ValueError, OverflowError):
        values = np.empty(0)
    if values.shape != shape or not np.isfinite(values).all():
        raise ValueError(f"the crawler's {name} must be finite numbers of the shape {shape}")
    return values
