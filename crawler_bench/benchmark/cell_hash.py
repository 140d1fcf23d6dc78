"""The hash that names a table cell, or a single run.

It is made of the configuration, the mode, the seeds and the metric, not of the code: so what the code once
made of a cell can be compared with what it makes of it now.
"""

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass

from crawler_bench.config.schema import Experiment, RunConfig, override, to_mapping

WHOLE_RUN = "run"  # in place of a metric


def cell_hash(entry: str, config: RunConfig, mode: str, seeds: Sequence[int], metric: str) -> str:
    """Eight hexadecimal digits that name a cell."""
    content = to_mapping(override(config, {"evaluation.mode": mode}, "cell"))
    content |= {"entry": entry, "seeds": list(seeds), "metric": metric}
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:8]


@dataclass(frozen=True)
class Hasher:
    """Hashes of the cells and runs of these experiments, by name."""

    entries: dict[str, Experiment]

    def __call__(self, agent: str, mode: str, regularization: float, metric: str) -> str:
        """Hash of a table cell; empty of what was not run from an entry."""
        if agent not in self.entries:
            return ""
        return cell_hash(agent, self._run(agent, regularization), mode, self.entries[agent].seeds, metric)

    def of_run(self, agent: str, mode: str, regularization: float, seed: int) -> str:
        """Hash of a single run; empty of what was not run from an entry."""
        if agent not in self.entries:
            return ""
        return cell_hash(agent, self._run(agent, regularization), mode, [seed], WHOLE_RUN)

    def _run(self, agent: str, regularization: float) -> RunConfig:
        return override(self.entries[agent].run, {"regularization": regularization}, agent)
