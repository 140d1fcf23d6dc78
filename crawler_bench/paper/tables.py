"""The reproduction as Markdown: claims and their verdicts, runs, and every constant."""

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
    numbers = claims[["claim", "source", "paper", "ours", "n"]].map(format_number)
    numbers.insert(4, "95 % interval", list(map(format_interval, claims["low"], claims["high"])))
    signed = [f"{SIGNS.get(verdict, '')} {verdict}".strip() for verdict in claims["verdict"]]
    return markdown(numbers.assign(verdict=signed))


def verdict_counts(claims: pd.DataFrame) -> str:
    """One sentence: the number of claims with each verdict."""
    counts = claims["verdict"].value_counts()
    parts = [f"{counts[verdict.value]} {verdict.value}" for verdict in Verdict if verdict.value in counts]
    return f"{len(claims)} claim{'s' if len(claims) > 1 else ''}: {', '.join(parts)}."


def not_reproduced(claims: pd.DataFrame) -> str:
    """A list of the claims that are not reproduced, or only partly."""
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
    schedule = paper.run.settings | {"decisions": paper.run.decisions, "seeds": len(paper.seeds)}
    rows += [("configs/paper", name, value) for name, value in schedule.items()]
    return markdown(pd.DataFrame(rows, columns=["where", "name", "default"]))


def runs_table(runs: pd.DataFrame) -> str:
    """Policy and speed of each trained run."""
    trained = runs[runs["experiment"].isin(["regularized", "unregularized"])]
    columns = ["experiment", "seed", "policy", "speed", "speed_moving", "stall_share", "cycle_duration"]
    shown = trained[columns].map(format_number).assign(policy=trained["policy"])
    return markdown(shown)
