"""Why greedy learners end off the diagonal: what the table believes there, and what each entry is worth.

A greedy learner tries an action only while its value is the highest of its row. While the values come down
from their optimistic start, the nearest-neighbour action of an observation is judged by what the rest of the
table did then. If the rest was poor, its value falls below that of another action and is never looked at
again: eq. 12 updates only what is chosen, so such a table is a fixed point, however long it goes on learning.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from crawler_bench.config.schema import RunConfig
from crawler_bench.gait import metrics
from crawler_bench.readings.catalogue import Reading
from crawler_bench.readings.laboratory import REGULARIZED
from crawler_bench.runs.evaluation import Evaluation, measure
from crawler_bench.runs.phases import Phase, unseen
from crawler_bench.runs.training import learn

MORE = 2  # times the decisions of a run for which a trapped learner goes on


def off_diagonal(
    reading: Reading, bases: Mapping[str, RunConfig], seeds: Sequence[int], phase: Phase = unseen
) -> pd.DataFrame:
    """Every entry at which a regularized run ends off the diagonal.

    Args:
        reading: the reading.
        bases: the run of the default reading for each experiment.
        seeds: of the training runs.
        phase: shows how far it is.

    Returns:
        One row per run and entry off the diagonal: seed, policy, observation, action, its value, the
        neighbour's value (of the nearest-neighbour action), the reward per decision of the policy, with that
        one entry repaired, and of the whole diagonal, and whether the entry is the same after MORE times as
        many decisions.
    """
    config = reading.configure(bases[REGULARIZED])
    n = config.parameters.n_segments
    diagonal = _reward(config, np.arange(n))
    rows: list[dict[str, Any]] = []
    with phase("runs off the diagonal", len(seeds), "runs") as advance:
        for done, seed in enumerate(seeds, 1):
            rows += _entries(config, seed, diagonal)
            advance(done)
    columns = [
        "seed", "policy", "observation", "action", "value", "neighbour_value", "reward", "repaired",
        "diagonal", "stays",
    ]  # fmt: skip
    return pd.DataFrame(rows, columns=columns)


def _entries(config: RunConfig, seed: int, diagonal: float) -> list[dict[str, Any]]:
    """The entries of one run; see `off_diagonal`."""
    n = config.parameters.n_segments
    agent, _ = learn(config, seed, interval=config.decisions)
    table = np.array(getattr(agent, "q_table"))  # noqa: B009 (only the tabular learner has one)
    policy = table.argmax(axis=1)
    off = np.flatnonzero(policy != np.arange(n))
    if not off.size:
        return []
    agent.learn(MORE * config.decisions, callback=None, progress_bar=False)
    later = np.array(getattr(agent, "q_table")).argmax(axis=1)  # noqa: B009
    reward, rows = _reward(config, policy), []
    for o in off:
        repaired = np.where(np.arange(n) == o, o, policy)
        rows.append({
            "seed": seed, "policy": metrics.policy_text(np.eye(n)[policy]), "observation": int(o),
            "action": int(policy[o]), "value": table[o, policy[o]], "neighbour_value": table[o, o],
            "reward": reward, "repaired": _reward(config, repaired), "diagonal": diagonal,
            "stays": bool(later[o] == policy[o]),
        })  # fmt: skip
    return rows


def _reward(config: RunConfig, policy: np.ndarray) -> float:
    """Mean reward per decision of a frozen policy without noise, over the starts of the evaluation."""
    quiet = config.evaluation.model_copy(update={"noise": (0.0,)})
    found: Evaluation = measure(config, 0, np.eye(policy.size)[policy], quiet)
    return float(found.starts["reward"].mean())
