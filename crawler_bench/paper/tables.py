"""The reproduction as Markdown tables: claims and their verdicts, runs, and every constant."""

from dataclasses import fields

import pandas as pd

from crawler_bench.config.files import config_folder, load_experiment
from crawler_bench.config.schema import EnvironmentConfig, EvaluationConfig
from crawler_bench.output.cells import format_interval, format_number, markdown
from crawler_bench.paper.verdicts import Verdict
from crawler_bench.physics.parameters import CrawlerParameters

SIGNS = {Verdict.REPRODUCED.value: "✔", Verdict.PARTLY.value: "◐", Verdict.NOT.value: "✘"}


def claims_table(claims: pd.DataFrame) -> str:
    """The claims as a Markdown table: claim, source, paper, ours with its format_interval, n, verdict."""
    rows = pd.DataFrame({
        "claim": claims["claim"],
        "source": claims["source"],
        "paper": claims["paper"].map(format_number),
        "ours": claims["ours"].map(format_number),
        "95 % interval": list(map(format_interval, claims["low"], claims["high"])),
        "n": claims["n"],
        "verdict": [f"{SIGNS.get(verdict, '')} {verdict}".strip() for verdict in claims["verdict"]],
    })  # fmt: skip
    return markdown(rows)


def verdict_counts(claims: pd.DataFrame) -> str:
    """One sentence: how many claims fare how."""
    counts = claims["verdict"].value_counts()
    parts = [f"{counts[verdict.value]} {verdict.value}" for verdict in Verdict if verdict.value in counts]
    return f"{len(claims)} claim{'s' if len(claims) > 1 else ''}: {', '.join(parts)}."


def not_reproduced(claims: pd.DataFrame) -> str:
    """A list of what does not hold, or only partly."""
    failing = claims[claims["verdict"].isin([Verdict.NOT.value, Verdict.PARTLY.value])]
    lines = [
        f"* {SIGNS[row['verdict']]} **{row['verdict']}**: {row['claim']}: "
        f"paper {format_number(row['paper'])}, "
        f"ours {format_number(row['ours'])} ({format_interval(row['low'], row['high'])})."
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
    return markdown(frame)


def runs_table(runs: pd.DataFrame) -> str:
    """The trained runs: policy and speed of each."""
    trained = runs[runs["experiment"].isin(["regularized", "unregularized"])]
    columns = ["experiment", "seed", "policy", "speed", "speed_moving", "stall_share", "cycle_duration"]
    shown = trained[columns].map(format_number).assign(policy=trained["policy"])
    return markdown(shown)
