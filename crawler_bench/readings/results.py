"""Write results/readings/, all or nothing; and re-run rows of it."""

import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from crawler_bench.config.errors import ConfigError
from crawler_bench.output import style
from crawler_bench.output.cells import markdown
from crawler_bench.output.csv_files import DIGITS, write_csv
from crawler_bench.output.latex import latex
from crawler_bench.readings import figures, identifiability
from crawler_bench.readings.catalogue import Reading
from crawler_bench.readings.fields import FIELDS, GIVEN
from crawler_bench.readings.frames import claims_of, read_reading, runs_of, summarize
from crawler_bench.readings.laboratory import Laboratory, Scored
from crawler_bench.readings.scoring import rescored
from crawler_bench.readings.study import Study
from crawler_bench.readings.tables import ranking
from crawler_bench.runs import store

CAPTION = "Readings of what the paper leaves open, by rank; variations of what it gives follow without one."


def write(study: Study, folder: Path, started: float, say: Callable[[str], None]) -> pd.DataFrame:
    """Write tables and figures.

    Returns:
        The readings, a row each.
    """
    with store.replace(folder) as draft:
        readings = summarize(study.scored)
        frames = {
            "readings": readings,
            "claims": claims_of(study.scored),
            "runs": runs_of(study.scored),
            "fields": identifiability.profiles(study.scored, FIELDS),
            "given": identifiability.profiles(study.scored, GIVEN),
            "telling": identifiability.most_discriminating(study.scored),
            "ends": identifiability.ends(study.scored),
            "conclusions": identifiability.conclusions(study.scored),
            "confirmation": study.confirmation(),
            "confirmation_claims": claims_of(study.confirmed),
            "rules": rescored(readings[readings["rank"].notna()], claims_of(study.scored)),
        }
        for name, frame in frames.items():
            write_csv(frame, draft / f"{name}.csv")
        table = ranking(readings)
        (draft / "readings.md").write_text(markdown(table) + "\n")
        plain = table.astype(str).map(lambda text: text.replace("**", ""))
        (draft / "readings.tex").write_text(latex(plain, CAPTION, "tab:readings", long=True))
        (draft / "indistinct.txt").write_text(_indistinct(study.scored) + "\n")
        say("drawing the figures")
        for name, figure in figures.all_figures(study.scored).items():
            style.save(figure, draft, name)
        store.write_command(draft)
        store.write_manifest(
            draft, started, seeds=study.size.seeds, fresh_seeds=study.size.fresh, trials=study.size.trials
        )
    return readings


def _indistinct(scored: Sequence[Scored]) -> str:
    alike, of, names = identifiability.indistinct(scored)
    if not of:
        return "No reading is within tolerance."
    listed = f": {', '.join(names)}" if names else ""
    return f"Of {of} readings within tolerance the score cannot tell {alike} from the best of them{listed}."


def read_readings(folder: Path) -> tuple[Reading, ...]:
    """The readings of a table, those of the search too; none if there is no table."""
    path = folder / "readings.csv"
    if not path.is_file():
        return ()
    return tuple(
        read_reading({str(k): v for k, v in row.items()}) for row in pd.read_csv(path).to_dict("records")
    )


def check(laboratory: Laboratory, folder: Path, seeds: Sequence[int], number: int) -> pd.DataFrame:
    """Re-run rows of the table, drawn at random, and compare their scores.

    Returns:
        reading, score (in the table), again, same.

    Raises:
        ConfigError: if there is no table.
    """
    known = read_readings(folder)
    if not known:
        raise ConfigError(f"{folder} holds no readings.csv; `crawler-bench readings` makes one")
    scores = pd.read_csv(folder / "readings.csv").set_index("reading")["score"].to_dict()
    picked = np.random.default_rng(time.time_ns()).choice(len(known), min(number, len(known)), replace=False)
    rerun = laboratory.run([known[i] for i in picked], seeds)
    rows = [(each.reading.name, scores[each.reading.name], each.score.value) for each in rerun]
    same = [f"{score:.{DIGITS}g}" == f"{again:.{DIGITS}g}" for _, score, again in rows]
    return pd.DataFrame(rows, columns=["reading", "score", "again"]).assign(same=same)
