"""The specification that Gymnasium keeps of an environment, with the longest episode in it."""

import copy

from gymnasium.envs.registration import EnvSpec


def with_longest_episode(
    spec: EnvSpec | None, decisions: int | None, in_kwargs: bool = False
) -> EnvSpec | None:
    """Say in `max_episode_steps` how many decisions an episode has at the most, unless it says so already.

    The crawler counts time, not decisions, and ends its own episodes. So it is registered without a limit,
    and those who read the limit from the specification, to size a buffer say, would not find one.

    Args:
        spec: as `gym.make` or `gym.make_vec` gives it to the environment that it has made.
        decisions: the limit, or None where there is none.
        in_kwargs: put it among the arguments, too, as `gym.make_vec` does when it makes one from the result.
    """
    if spec is None or decisions is None or spec.max_episode_steps is not None:
        return spec
    limited = copy.copy(spec)
    limited.max_episode_steps = decisions
    if in_kwargs:
        limited.kwargs = {"max_episode_steps": decisions} | spec.kwargs
    return limited
