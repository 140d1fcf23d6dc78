"""Tables as CSV and Markdown, and the generated blocks of the documentation.

A block stands in a Markdown file between `<!-- begin NAME -->` and `<!-- end NAME -->`; everything between is
made from results/, so that no number in the documentation is typed by hand.

    python -m crawler_bench.report.blocks README.md docs/*.md
"""

import re
import sys
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path

import pandas as pd

from crawler_bench.benchmark import tables as benchmark_tables
from crawler_bench.config.files import config_folder, load_experiment
from crawler_bench.config.schema import EnvironmentConfig, EvaluationConfig
from crawler_bench.output.cells import interval as interval
from crawler_bench.output.cells import short as short
from crawler_bench.paper.verdicts import Verdict
from crawler_bench.physics.parameters import CrawlerParameters
from crawler_bench.readings import tables as readings_tables
from crawler_bench.report import speed

SIGNS = {Verdict.REPRODUCED.value: "✔", Verdict.PARTLY.value: "◐", Verdict.NOT.value: "✘"}


def claims_table(claims: pd.DataFrame) -> str:
    """The claims as a Markdown table: claim, source, paper, ours with its interval, n, verdict."""
    rows = pd.DataFrame({
        "claim": claims["claim"],
        "source": claims["source"],
        "paper": claims["paper"].map(short),
        "ours": claims["ours"].map(short),
        "95 % interval": list(map(interval, claims["low"], claims["high"])),
        "n": claims["n"],
        "verdict": [f"{SIGNS.get(verdict, '')} {verdict}".strip() for verdict in claims["verdict"]],
    })  # fmt: skip
    return rows.to_markdown(index=False, disable_numparse=True)


def verdict_counts(claims: pd.DataFrame) -> str:
    """One sentence: how many claims fare how."""
    counts = claims["verdict"].value_counts()
    parts = [f"{counts[verdict.value]} {verdict.value}" for verdict in Verdict if verdict.value in counts]
    return f"{len(claims)} claim{'s' if len(claims) > 1 else ''}: {', '.join(parts)}."


def not_reproduced(claims: pd.DataFrame) -> str:
    """A list of what does not hold, or only partly."""
    failing = claims[claims["verdict"].isin([Verdict.NOT.value, Verdict.PARTLY.value])]
    lines = [
        f"* {SIGNS[row['verdict']]} **{row['verdict']}**: {row['claim']}: paper {short(row['paper'])}, "
        f"ours {short(row['ours'])} ({interval(row['low'], row['high'])})."
        for row in failing.to_dict("records")
    ]
    return "\n".join(lines) or "Everything is reproduced."


def parameters_table() -> str:
    """Every constant of the model, the task, the evaluation and the learner."""
    rows = [("CrawlerParameters", field.name, field.default) for field in fields(CrawlerParameters)]
    for model in (EnvironmentConfig, EvaluationConfig):
        rows += [(model.__name__, name, field.default) for name, field in model.model_fields.items()]
    paper = load_experiment(config_folder() / "paper" / "regularized.yaml")
    rows += [("configs/paper", name, value) for name, value in paper.run.settings.items()]
    rows += [
        ("configs/paper", "decisions", paper.run.decisions),
        ("configs/paper", "seeds", len(paper.seeds)),
    ]
    frame = pd.DataFrame(rows, columns=["where", "name", "default"])
    return frame.to_markdown(index=False, disable_numparse=True)


def runs_table(runs: pd.DataFrame) -> str:
    """The trained runs: policy and speed of each."""
    trained = runs[runs["experiment"].isin(["regularized", "unregularized"])]
    columns = ["experiment", "seed", "policy", "speed", "speed_moving", "stall_share", "cycle_duration"]
    shown = trained[columns].map(short).assign(policy=trained["policy"])
    return shown.to_markdown(index=False, disable_numparse=True)


def blocks(results: Path) -> dict[str, Callable[[], str]]:
    """Every generated block by name.

    Args:
        results: the folder that `crawler-bench reproduce` wrote; speeds are beside it, in `speed`,
            and the comparison of agents in `benchmark`.
    """

    def claims() -> pd.DataFrame:
        return pd.read_csv(results / "claims.csv")

    return {
        "claims": lambda: claims_table(claims()),
        "verdicts": lambda: verdict_counts(claims()),
        "not reproduced": lambda: not_reproduced(claims()),
        "runs": lambda: runs_table(pd.read_csv(results / "runs.csv", dtype={"policy": str})),
        "parameters": parameters_table,
        **speed.blocks(results.parent / "speed", short),
        **readings_tables.blocks(results.parent / "readings"),
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
