"""The generated blocks of docs/readings.md about the search."""

import json
from collections.abc import Callable
from pathlib import Path

import pandas as pd

from crawler_bench.output.cells import format_number, markdown
from crawler_bench.readings.catalogue import FORMER
from crawler_bench.readings.scoring import CORE, FORMER_CORE, TOLERANCE

NOT_SEARCHED = "Not searched yet: `crawler-bench readings --search`."


def blocks(folder: Path) -> dict[str, Callable[[], str]]:
    """Every generated block about the search by name.

    Args:
        folder: what `crawler-bench readings --search` wrote, or not yet.
    """

    def block(make: Callable[..., str], *names: str) -> Callable[[], str]:
        def text() -> str:
            paths = [folder / f"{name}.csv" for name in names]
            if not all(path.is_file() for path in paths):
                return NOT_SEARCHED
            frames = (pd.read_csv(path, keep_default_na=False, na_values=[""]) for path in paths)
            return make(*frames)

        return text

    return {
        "search summary": block(_summary, "trials", "again", "finals"),
        "search finals": block(_finals, "finals"),
        "search chosen": block(lambda finals: _finals(finals.head(1)), "finals"),
        "search holding": block(_holding, "holding"),
        "search former rule": block(_former_rule, "trials"),
        "search off the diagonal": block(_off_diagonal, "off_diagonal", "finals"),
        "search freeing": block(_freeing, "freeing"),
    }


def _summary(trials: pd.DataFrame, again: pd.DataFrame, finals: pd.DataFrame) -> str:
    stopped = trials["stopped"].fillna("").astype(bool)
    within = trials["within"].map({True: True, "True": True}).fillna(False).astype(bool)
    chosen = finals.iloc[0]
    failures = str(chosen["failures"]) if isinstance(chosen["failures"], str) else ""
    says = f"fails {failures.replace(' ', ', ')}" if failures else "passes every condition"
    return (
        f"{len(trials)} trials, {int(stopped.sum())} of them given up early; {int(within.sum())} within "
        f"tolerance on their own seeds. {len(again)} were run again and {len(finals) - 1} a third time. The "
        f"rule chooses {chosen['reading']}, with {chosen['free']} free constants "
        f"({str(chosen['free_constants']).replace(' ', ', ')}): on {chosen['n']} seeds that no stage used it "
        f"{says}."
    )


def _finals(finals: pd.DataFrame) -> str:
    """One row per finalist, in the order of the rule."""
    rows = pd.DataFrame({
        "reading": [
            f"**{name}**" if name == FORMER.name else name for name in finals["reading"]
        ],
        "values": [_values(each) for each in finals["changes"]],
        "free": finals["free"],
        "score": finals["score"].map(format_number),
        "on the diagonal": finals["on_diagonal"].map(format_number),
        "random / gait": finals["random_ratio"].map(format_number),
        "speed kept": finals["kept"].map(format_number),
        "speed": finals["speed"].map(format_number),
        "waves per tau": finals["waves_per_tau"].map(format_number),
        "peak": finals["peak_contraction"].map(format_number),
        "unregularized": finals["unregularized"].map(format_number),
        "fails": finals["failures"].fillna("").str.replace(" ", ", "),
    })  # fmt: skip
    return markdown(rows)


def _holding(cases: pd.DataFrame) -> str:
    """One row per case of other numerics, intervals and seeds."""
    numbers = {
        "on_diagonal": "on the diagonal", "random_ratio": "random / gait", "kept": "speed kept",
        "speed": "speed", "waves_per_tau": "waves per tau", "peak_contraction": "peak",
        "unregularized": "unregularized",
    }  # fmt: skip
    shown = {name: cases[column].map(format_number) for column, name in numbers.items()}
    fails = cases["failures"].fillna("").str.replace(" ", ", ")
    return markdown(pd.DataFrame({"case": cases["case"], "n": cases["n"], **shown, "fails": fails}))


def _values(changes: str) -> str:
    """The values of a reading in short: words that differ from the plainest, then numbers."""
    values = json.loads(changes)
    plain = {"reaction", "decision", "interval"}
    words = [str(value) for value in values.values() if isinstance(value, str) and value not in plain]
    numbers = [
        f"{key.rpartition('.')[2]} {value:g}" for key, value in values.items() if not isinstance(value, str)
    ]
    return ", ".join(words + numbers)


def _former_rule(trials: pd.DataFrame) -> str:
    """What the rule would choose without the core claims that were added."""
    done = trials[~trials["stopped"].fillna("").astype(bool)]
    failed = done["core_failures"].fillna("").str.split()
    passes = pd.Series([not set(each) & set(FORMER_CORE) for each in failed], index=done.index)
    fine = done[(done["score"] <= TOLERANCE) & passes]
    if fine.empty:
        return "Without them, no trial would be within tolerance."
    first = fine.sort_values(["free", "score"], kind="stable").iloc[0]
    added = [name for name in CORE if name not in FORMER_CORE]
    missed = [name for name in str(first["core_failures"] or "").split() if name in added]
    return (
        f"Without the core claims that were added ({', '.join(added)}), the rule would put "
        f"{first['reading']} first, with {first['free']} free constants and a score of "
        f"{format_number(first['score'])}; of the added claims it fails {', '.join(missed) or 'none'}, and "
        f"random action is at {format_number(first['random_ratio'])} of its gait."
    )


def _off_diagonal(entries: pd.DataFrame, finals: pd.DataFrame) -> str:
    """Entries at which runs of the chosen reading end off the diagonal."""
    runs = int(finals["n"].iloc[0])
    if entries.empty:
        return f"All {runs} runs end on the diagonal."
    by_entry = entries.groupby("observation")
    rows = pd.DataFrame({
        "observation": [str(o) for o in by_entry.groups],
        "runs": by_entry["seed"].nunique().tolist(),
        "actions": [", ".join(sorted({str(a) for a in each})) for _, each in by_entry["action"]],
        "value of the action": by_entry["value"].mean().map(format_number).tolist(),
        "value of the neighbour": by_entry["neighbour_value"].mean().map(format_number).tolist(),
        "stays": by_entry["stays"].mean().map(lambda share: f"{share:.0%}").tolist(),
    })  # fmt: skip
    once = entries.drop_duplicates("seed")
    return (
        f"{entries['seed'].nunique()} of {runs} runs end off the diagonal. Their tables earn "
        f"{format_number(once['reward'].mean())} per decision, the diagonal "
        f"{format_number(once['diagonal'].mean())}.\n\n{markdown(rows)}"
    )


def _freeing(cases: pd.DataFrame) -> str:
    """One row per field: the share on the diagonal at each of its values."""
    cases = cases.assign(field=cases["field"].fillna(""))
    (unchanged,) = cases[cases["field"] == ""].to_dict("records")
    rows = [
        {
            "changed alone": field,
            "to: share on the diagonal": ", ".join(
                f"{value}: {share:.0%}" for value, share in zip(of["value"], of["on_diagonal"], strict=True)
            ),
        }
        for field, of in cases[cases["field"] != ""].groupby("field", sort=False)
    ]
    interval = f"{unchanged['low']:.0%} .. {unchanged['high']:.0%}"
    return (
        f"Unchanged, {unchanged['on_diagonal']:.0%} ({interval}) of {unchanged['n']} runs end on the "
        f"diagonal.\n\n{markdown(pd.DataFrame(rows))}"
    )
