"""The generated blocks of the documentation.

A block is what a Markdown file has between `<!-- begin NAME -->` and `<!-- end NAME -->`. It is generated
from results/, so that nobody types a number of the documentation by hand.

    python -m crawler_bench.report.blocks README.md docs/*.md
"""

import re
import sys
from collections.abc import Callable
from pathlib import Path

import pandas as pd

from crawler_bench.benchmark import tables as benchmark_tables
from crawler_bench.paper import tables as paper_tables
from crawler_bench.readings import tables as readings_tables
from crawler_bench.readings.search import tables as search_tables
from crawler_bench.report import readme, speed


def blocks(results: Path) -> dict[str, Callable[[], str]]:
    """Every generated block by name.

    Args:
        results: the folder that `crawler-bench reproduce` wrote; speeds are beside it, in `speed`,
            and the comparison of agents in `benchmark`.
    """

    def claims() -> pd.DataFrame:
        return pd.read_csv(results / "claims.csv")

    return {
        "claims": lambda: paper_tables.claims_table(claims()),
        "verdicts": lambda: paper_tables.verdict_counts(claims()),
        "not reproduced": lambda: paper_tables.not_reproduced(claims()),
        "runs": lambda: paper_tables.runs_table(pd.read_csv(results / "runs.csv", dtype={"policy": str})),
        "parameters": paper_tables.parameters_table,
        **readme.blocks(results),
        **speed.blocks(results.parent / "speed"),
        **readings_tables.blocks(results.parent / "readings"),
        **search_tables.blocks(results.parent / "search"),
        **benchmark_tables.blocks(results.parent / "benchmark"),
    }


def regenerate(document: str, results: Path) -> str:
    """Fill every generated block of a Markdown document.

    Raises:
        ValueError: if a block has no generator, or the results that it shows are not there.
    """
    known = blocks(results)
    begun, ended = (re.findall(rf"<!-- {word} ([\w ]+) -->", document) for word in ("begin", "end"))
    if begun != ended:
        raise ValueError(f"blocks begin ({', '.join(begun)}) that do not end ({', '.join(ended)})")

    def fill(match: re.Match[str]) -> str:
        name = match["name"]
        if name not in known:
            raise ValueError(f"no generator is called {name!r}; there are {', '.join(known)}")
        return f"<!-- begin {name} -->\n{known[name]()}\n<!-- end {name} -->"

    return re.sub(
        r"<!-- begin (?P<name>[\w ]+) -->.*?<!-- end (?P=name) -->", fill, document, flags=re.DOTALL
    )


if __name__ == "__main__":
    for name in sys.argv[1:]:
        try:
            Path(name).write_text(regenerate(Path(name).read_text(), Path("results/paper")))
        except ValueError as error:
            sys.exit(f"{name}: {error}")
