"""What happens in a decision of the exact integrator, counted in the Python that is compiled elsewhere."""

import collections
import json
import os
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd

from speed.measure import Effort

SEQUENCES = ("diagonal policy", "random actions")
WHAT = {
    "excite": "spikes, and drives that fall through their limit",
    "switch": "nodes that start or stop sliding",
    "set_course": "nodes whose course is laid anew",
    "exit_time": "limits of nodes that may be reached",
    "_root": "searches for a root",
    "respond": "times at which the responses are evaluated",
}


def of_a_decision(effort: Effort) -> pd.DataFrame:
    """A row for each kind of event or operation: how many a decision holds, for each sequence of actions."""
    n_decisions = 50 if effort.quick else 2000
    words = [sys.executable, "-m", "speed.counts", str(n_decisions)]
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run(words, env=environment, capture_output=True, text=True, check=True)
    return pd.DataFrame(json.loads(done.stdout))


def _count(n_decisions: int) -> list[dict[str, Any]]:
    """Let a crawler decide, with every function of `WHAT` replaced by one that counts its calls."""
    from crawler_bench.physics import course, events, exact, excitation, exits, response
    from speed.crawlers import NO_ACTIONS, body, compiled_crawl, random_actions

    counts: collections.Counter[str] = collections.Counter()

    def counted(function: Callable[..., Any]) -> Callable[..., Any]:
        def wrapper(*arguments: Any) -> Any:
            low, high = arguments[1:3] if function is course.set_course else (0, 0)
            counts[function.__name__] += high - low + 1
            return function(*arguments)

        return wrapper

    places = (exact, events, exits, response)
    originals = (
        excitation.excite,
        events.switch,
        course.set_course,
        exits.exit_time,
        exits._root,
        response.respond,
    )
    for function in originals:
        replacement = counted(function)
        for place in places:
            if getattr(place, function.__name__, None) is function:
                setattr(place, function.__name__, replacement)
    rows: dict[str, dict[str, Any]] = {name: {"what": what} for name, what in WHAT.items()}
    for sequence, actions in zip(SEQUENCES, (NO_ACTIONS, random_actions()), strict=True):
        counts.clear()
        with np.errstate(over="ignore"):  # the generator counts modulo 2^64
            compiled_crawl(body("exact"), actions)(n_decisions)
        for name, row in rows.items():
            row[sequence] = counts[name] / n_decisions
    return list(rows.values())


if __name__ == "__main__":
    print(json.dumps(_count(int(sys.argv[1]))))
