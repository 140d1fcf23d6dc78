"""The ceilings as a table."""

import pandas as pd

from crawler_bench.output.cells import format_number


def ceilings_table(ceilings: pd.DataFrame) -> pd.DataFrame:
    """The ceilings, and what is known of each, in words."""
    return pd.DataFrame({
        "regularization": ceilings["regularization"].map("{:g}".format),
        "noise": ceilings["noise"].map("{:g}".format),
        "best": ceilings["kind"],
        "reward per decision (L)": ceilings["reward"].map("{:.4g}".format),
        "speed (L/tau)": ceilings["speed"].map(format_number),
        "policy": [f"`{text}`" if len(text) <= 40 else "a table" for text in ceilings["policy"].fillna("-")],
        "known": ceilings["proof"],
    })  # fmt: skip
