"""Trained policies as files to share: what was trained, and the whole policy as tables.

A JSON file holds everything that evaluating or filming the policy needs; a network lies beside it, under the
same name, as the archive that Stable-Baselines3 wrote.
"""

import json
import shutil
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from crawler_bench.config.schema import RunConfig, build, to_mapping
from crawler_bench.runs.policies.table import probabilities
from crawler_bench.runs.store import NotARunError

LARGEST = 500_000  # bytes of a network's archive that is still shared


@dataclass(frozen=True)
class Policy:
    """A trained policy.

    Attributes:
        config: the run that trained it.
        seed: of that run.
        tables: (N, N) action probabilities at each observation, by mode.
    """

    config: RunConfig
    seed: int
    tables: dict[str, NDArray[np.float64]]

    def table_of(self, mode: str) -> NDArray[np.float64]:
        """The table of a mode; where there is only one, it is that in every mode."""
        return self.tables[mode] if mode in self.tables else next(iter(self.tables.values()))


def write_policy(policy: Policy, path: Path, agent: Path | None = None) -> None:
    """Write a policy as JSON and, if it is a small archive, the saved agent beside it."""
    content = {
        "seed": policy.seed,
        "run": to_mapping(policy.config),
        "tables": {mode: table.tolist() for mode, table in policy.tables.items()},
    }
    path.write_text(json.dumps(content, indent=1) + "\n")
    if agent is not None and agent.suffix == ".zip" and agent.stat().st_size <= LARGEST:
        shutil.copyfile(agent, path.with_suffix(".zip"))


def read_policy(path: Path) -> Policy:
    """Read what `write_policy` wrote.

    Args:
        path: the JSON file, or the archive beside it.

    Raises:
        NotARunError: if there is no such policy.
    """
    path = path.with_suffix(".json")
    try:
        content = json.loads(path.read_text())
        config = build(RunConfig, content["run"], "run")
        n = config.parameters.n_segments
        tables = {str(mode): probabilities(table, n) for mode, table in content["tables"].items()}
        if not tables:
            raise ValueError("it holds no table")
        return Policy(config, int(content["seed"]), tables)
    except FileNotFoundError:
        raise NotARunError(f"{path} does not exist: a policy's JSON file lies beside its archive") from None
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise NotARunError(f"{path} is not a policy: {' '.join(str(error).split())}") from None
