"""The tables of a benchmark, each formatted once and written as Markdown, CSV and LaTeX.

A cell reads "value [low, high] (n) #hash"; `cell_hash` says what the hash names.
"""

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from crawler_bench.benchmark.ceilings.table import ceilings_table
from crawler_bench.benchmark.families import QUESTIONS, REGULARIZATION
from crawler_bench.benchmark.keyholes import worth_table
from crawler_bench.benchmark.keys import select
from crawler_bench.benchmark.summary import metric
from crawler_bench.output.cells import format_cell, format_interval, format_number, markdown
from crawler_bench.output.csv_files import read_csv
from crawler_bench.output.latex import latex
from crawler_bench.statistics.estimates import RESAMPLES

COMPARISON = (
    "speed", "score", "regret_table", "regret_stochastic", "regret_state", "cycle_duration", "noise_area",
    "stall_share", "off_diagonal", "decisions", "decisions_to_final", "gradient_updates",
)  # fmt: skip
COMPACT = (
    "speed", "cycle_duration", "score", "regret_state", "noise_area", "stall_share", "off_diagonal",
    "decisions_to_final", "gradient_updates",
)  # fmt: skip
KEY = ["regularization", "agent", "mode"]
NOISE = "speed_noise_"
SIGNIFICANT = 0.05
CELL = r"Interquartile mean (of a share the mean) [95~\% interval] (number of independent runs)"
LEGEND = (
    "Only pairs that answer a question are tested: "
    + "; ".join(QUESTIONS.values())
    + ". Holm corrects within a question. A cell is the probability that a run of the row's agent earns more "
    "reward than one of the column's, a tie counting half; `**` where Holm's p is below 0.05, `*` where only "
    "Benjamini and Hochberg's is. "
)
MANY = 1000  # seeds; beyond, the number itself does not matter


def comparison(summary: pd.DataFrame) -> pd.DataFrame:
    """Agents compared: one row per agent, mode and regularization, one column per metric, in full cells."""
    return _wide(summary, COMPARISON)


def noise(summary: pd.DataFrame) -> pd.DataFrame:
    """Speed at each amplitude of noise, in full cells."""
    names = summary["metric"].drop_duplicates()
    return _wide(summary, tuple(names[names.str.startswith(NOISE)]))


def _wide(summary: pd.DataFrame, metrics: tuple[str, ...]) -> pd.DataFrame:
    """One column per metric, under its heading; rows by regularization, otherwise in their order."""
    cells = summary.assign(
        cell=[
            format_cell(row["value"], row["low"], row["high"], row["n"], row["hash"])
            for row in summary.astype({"hash": object}).to_dict("records")
        ]
    )
    shown = cells[cells["metric"].isin(metrics)]
    keys = shown[KEY].drop_duplicates().sort_values("regularization", kind="stable")
    wide = shown.pivot(index=KEY, columns="metric", values="cell")
    wide = wide.reindex(index=pd.MultiIndex.from_frame(keys), columns=list(metrics))
    wide.columns = pd.Index([metric(name).heading for name in metrics])
    flat = wide.fillna("-").reset_index()
    return flat.assign(regularization=flat["regularization"].map("{:g}".format))


def pairs_table(pairs: pd.DataFrame) -> pd.DataFrame:
    """Every pair and metric: difference, probability of improvement, p, crossing, seeds needed."""
    rows = []
    for row in pairs.to_dict("records"):
        improvement = (row["improvement"], row["improvement_low"], row["improvement_high"])
        crossing = (row["crossover"], row["crossover_low"], row["crossover_high"])
        rows.append({
            "question": row["family"],
            "metric": metric(row["metric"]).heading,
            "first": _side(row, "first"),
            "second": _side(row, "second"),
            "first minus second": format_cell(row["difference"], row["low"], row["high"], row["n"]),
            "P(first > second)": _bare(*improvement).removesuffix(" [no spread]"),
            "p": format_number(row["p"]),
            "p, Holm": f"{format_number(row['p_holm'])} ({row['tests']})",
            "p, FDR": format_number(row["p_fdr"]),
            "curves cross at s": _bare(*crossing) + _winner(row["overtakes"]),
            "seeds for 10 %": _seeds(row["seeds_needed"], row["degenerate"]),
            "seeds to pass Holm": _seeds(row["seeds_to_decide"], False),
        })  # fmt: skip
    return pd.DataFrame(rows)


def _side(row: Mapping[Any, Any], side: str) -> str:
    agent, mode, regularization = (row[f"{side}_{name}"] for name in ("agent", "mode", "regularization"))
    return f"{agent}, {mode}, {regularization:g}"


def _winner(overtakes: object) -> str:
    return f", {overtakes} overtakes" if overtakes in ("first", "second") else ""


def _bare(value: float, low: float, high: float) -> str:
    """A cell without its n."""
    return format_cell(value, low, high, 0).removesuffix(" (0)")


def _seeds(needed: float, degenerate: bool) -> str:
    if degenerate and needed == 2:
        return "no spread"
    return f"> {MANY}" if needed > MANY else format_number(needed)


def learned(runs: pd.DataFrame) -> pd.DataFrame:
    """The policy that each agent learned most often, and the share of its runs that did.

    Args:
        runs: one row per run and mode, with `policy` as `metrics.policy_text` gives it.

    Returns:
        One row per agent, mode and regularization; of equally frequent policies the first by name. Policies
        that are no table have no row.
    """
    rows = []
    for (regularization, agent, mode), found in runs.dropna(subset="policy").groupby(KEY, sort=False)[
        "policy"
    ]:
        counts = found.value_counts().sort_index().sort_values(ascending=False, kind="stable")
        rows.append({
            "regularization": f"{regularization:g}", "agent": agent, "mode": mode,
            "most common policy": f"`{counts.index[0]}`", "runs": f"{counts.iloc[0]} of {len(found)}",
            "share": format_number(counts.iloc[0] / len(found)), "different policies": str(len(counts)),
        })  # fmt: skip
    if not rows:
        return pd.DataFrame(columns=["regularization"])
    return pd.DataFrame(rows).sort_values("regularization", kind="stable", ignore_index=True)


def write_tables(summary: pd.DataFrame, pairs: pd.DataFrame, runs: pd.DataFrame, folder: Path) -> None:
    """Write comparison, noise and pairs as .md, .csv and .tex, and learned.md.

    Args:
        summary: what `summarize_benchmark` returns, or its CSV.
        pairs: what `compare` returns, or its CSV.
        runs: one row per run and mode.
        folder: for these tables alone: its pairs.csv is formatted, not the one that `blocks` reads.
    """
    folder.mkdir(parents=True, exist_ok=True)
    tables = {
        "comparison": (comparison(summary), f"Agents compared. {CELL}."),
        "noise": (noise(summary), f"Speed under noise of amplitude s. {CELL}."),
        "pairs": (pairs_table(pairs), f"Agents in pairs, over paired seeds. {CELL}."),
    }
    if pairs.empty:  # nobody asks anything of these agents
        del tables["pairs"]
    for name, (frame, caption) in tables.items():
        (folder / f"{name}.md").write_text(markdown(frame) + "\n")
        frame.to_csv(folder / f"{name}.csv", index=False)
        (folder / f"{name}.tex").write_text(latex(frame, caption, f"tab:{name}", long=name == "pairs"))
    (folder / "learned.md").write_text(markdown(learned(runs)) + "\n")


def compact(summary: pd.DataFrame) -> pd.DataFrame:
    """The comparison in short: only speed has its interval, and one n serves the whole row."""
    rows = []
    for (regularization, agent, mode), found in summary.groupby(KEY, sort=False):
        of = found.set_index("metric").to_dict("index")
        n = of["speed"]["n"]
        row = {"regularization": f"{regularization:g}", "agent": agent, "mode": mode, "n": str(n)}
        for name in (each for each in COMPACT if each in of):
            each = of[name]
            text = format_number(each["value"])
            if name == "speed":
                row |= {
                    metric(name).heading: text,
                    "95 % interval": format_interval(each["low"], each["high"]),
                }
            else:  # fewer runs than the row has: the others have no such number
                row[metric(name).heading] = text if each["n"] in (n, 0) else f"{text} ({each['n']})"
        rows.append(row)
    return pd.DataFrame(rows).sort_values("regularization", kind="stable", ignore_index=True)


def matrix(pairs: pd.DataFrame, regularization: float, name: str = "reward") -> pd.DataFrame:
    """Probability that a run of the row's agent exceeds one of the column's.

    ** marks where Holm's p is below 0.05, * where only Benjamini and Hochberg's is.
    """
    same = {"first_regularization": regularization, "second_regularization": regularization}
    chosen = select(pairs, metric=name, **same)
    cells: dict[str, dict[str, str]] = {}
    for row in chosen.to_dict("records"):
        one, other = (f"{row[f'{side}_agent']}, {row[f'{side}_mode']}" for side in ("first", "second"))
        star = " **" if row["p_holm"] < SIGNIFICANT else " *" if row["p_fdr"] < SIGNIFICANT else ""
        cells.setdefault(one, {})[other] = format_number(row["improvement"]) + star
        cells.setdefault(other, {})[one] = format_number(1 - row["improvement"]) + star
    names = list(cells)
    frame = pd.DataFrame([[cells[one].get(other, "") for other in names] for one in names], columns=names)
    frame.insert(0, f"regularization {regularization:g}", names)
    return frame


def floor(pairs: pd.DataFrame) -> str:
    """One sentence: the least p that this number of seeds and pairs allows."""
    tested = pairs[(pairs["metric"] == "reward") & pairs["p"].notna()]
    seeds, count = int(tested["n"].max()), int(tested["tests"].max())
    least = max(2.0 ** (1 - seeds), 1 / (RESAMPLES + 1))  # over all signs, or over those drawn
    return (
        f"With {seeds} paired seeds p is at least {format_number(least)}, "
        f"and Holm's over {count} pairs at least {format_number(min(1.0, count * least))}."
    )


def against_itself(pairs: pd.DataFrame) -> pd.DataFrame:
    """Each agent without regularization against itself with it: speed, and where the noise curves cross."""
    own = pairs[pairs["family"] == REGULARIZATION]
    table = pairs_table(own)
    excess = [
        _bare(100 * row["relative"], 100 * row["relative_low"], 100 * row["relative_high"])
        for row in own.to_dict("records")
    ]
    table.insert(list(table.columns).index("first minus second") + 1, "excess (%)", excess)
    return table[own["metric"].isin(["speed", "noise_area"]).to_numpy()]


def cost_table(cost: dict[str, dict[str, float]]) -> str:
    """Seconds per run of each agent, in Markdown, below the total."""
    rows = [
        {"agent": agent, "runs": f"{each['runs']:.0f}"}
        | {f"{part} (s a run)": f"{each[part]:.1f}" for part in ("training", "evaluation")}
        for agent, each in sorted(cost.items())
    ]
    return f"{cost_sentence(cost)}\n\n{markdown(pd.DataFrame(rows))}"


def cost_sentence(cost: dict[str, dict[str, float]]) -> str:
    """One sentence: how long all runs took together."""
    seconds = sum(each["runs"] * (each["training"] + each["evaluation"]) for each in cost.values())
    runs = sum(each["runs"] for each in cost.values())
    return (
        f"All {runs:.0f} runs together took {seconds / 60:.0f} minutes in single processes, "
        "half of that on the clock with two at a time."
    )


def _with_families(pairs: pd.DataFrame) -> pd.DataFrame:
    """Pairs as they are written today; files from before there were families have one."""
    if "family" in pairs:
        return pairs
    own = pairs["first_regularization"] != pairs["second_regularization"]
    tests = pairs.groupby(["metric", "first_regularization", "second_regularization"])["n"].transform("size")
    return pairs.assign(
        family=own.map({True: REGULARIZATION, False: "all"}), tests=tests, seeds_to_decide=float("nan")
    )


def blocks(folder: Path) -> dict[str, Callable[[], str]]:
    """Every generated block about the benchmark by name.

    Args:
        folder: that `write_benchmark` wrote.

    Raises:
        ValueError: when a block needs a file that is missing.
    """

    def find(name: str) -> Path:
        path = folder / name
        if not path.is_file():
            raise ValueError(f"{path} is missing; `crawler-bench benchmark` writes it")
        return path

    def read(name: str) -> pd.DataFrame:
        return read_csv(find(f"{name}.csv"))

    def pairs() -> str:
        found = _with_families(read("pairs"))
        levels = sorted({*found["first_regularization"], *found["second_regularization"]})
        frames = [*(matrix(found, level) for level in levels), against_itself(found)]
        return "\n\n".join([LEGEND + floor(found), *(markdown(frame) for frame in frames if len(frame))])

    def cost() -> dict[str, dict[str, float]]:
        content: dict[str, dict[str, float]] = json.loads(find("manifest.json").read_text())["cost"]
        return content

    return {
        "benchmark cost": lambda: cost_table(cost()),
        "benchmark time": lambda: cost_sentence(cost()),
        "benchmark": lambda: markdown(compact(read("summary"))),
        "benchmark pairs": pairs,
        "benchmark keyholes": lambda: markdown(worth_table(read("keyholes"))),
        "benchmark ceilings": lambda: markdown(ceilings_table(read("ceilings"))),
        "agents learned": lambda: markdown(learned(read("runs"))),
    }
