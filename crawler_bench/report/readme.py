"""The blocks of README that are shorter than those of docs: ten claims, and how many hold of all."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from crawler_bench.output.cells import format_interval, format_number, markdown
from crawler_bench.output.csv_files import read_csv
from crawler_bench.paper.tables import SIGNS
from crawler_bench.paper.verdicts import Verdict

# Ten claims that matter, by name, in a newcomer's words.
KEY_CLAIMS = {
    "nearest_neighbour": "regularized, it learns nearest-neighbour wiring: each switches on the one ahead",
    "wave": "that gait is a wave of contraction from tail to head",
    "speed": "its speed (segment lengths per neuronal period)",
    "wave_speed": "its waves per neuronal period",
    "peak_contraction": "how far a segment contracts (%)",
    "unused_muscles": "unregularized, some muscles are never used",
    "faster_by": "unregularized, the crawler is faster by (%)",
    "slower_high_noise": "but slower when its senses are noisy (difference in speed)",
    "maintains_speed": "regularized, it keeps its speed under noise (relative to none)",
    "learning_pays": "regularized, it is faster than at random (difference in speed; implied)",
}


def blocks(folder: Path) -> dict[str, Callable[[], str]]:
    """Every generated block of README by name.

    Args:
        folder: that `crawler-bench reproduce` wrote.
    """

    def claims() -> pd.DataFrame:
        return read_csv(folder / "claims.csv")

    return {"key claims": lambda: key_claims(claims()), "verdict share": lambda: verdict_share(claims())}


def key_claims(claims: pd.DataFrame) -> str:
    """Ten claims as a Markdown table; one that was not judged is left out."""
    by_name = {str(row["command"]).split("--claim ")[-1].split()[0]: row for row in claims.to_dict("records")}
    rows = [_row(words, by_name[name]) for name, words in KEY_CLAIMS.items() if name in by_name]
    return markdown(pd.DataFrame(rows))


def _row(words: str, row: Mapping[Any, Any]) -> dict[str, str]:
    ours, low, high = (row[name] for name in ("ours", "low", "high"))
    if row["paper"] == "yes":  # a share of runs
        here, interval = f"{ours:.0%} of runs", f"{low:.0%} .. {high:.0%}"
    else:
        here = format_number(ours)
        interval = "all runs alike" if low == high else format_interval(low, high)
    verdict = f"{SIGNS.get(row['verdict'], '')} {row['verdict']}".strip()
    paper = format_number(row["paper"])
    return {
        "the paper says": words,
        "paper": paper,
        "here": here,
        "95 % interval": interval,
        "verdict": verdict,
    }


def verdict_share(claims: pd.DataFrame) -> str:
    """How many claims are reproduced, in words, with a link to all of them."""
    reproduced = int((claims["verdict"] == Verdict.REPRODUCED.value).sum())
    return (
        f"**{reproduced} of {len(claims)}** claims are reproduced: "
        "[all of them, and how they are judged](docs/claims.md)."
    )
