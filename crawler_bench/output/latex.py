"""A table of text as LaTeX, for a paper."""

import re

import pandas as pd

_HASH = re.compile(r" #(\S+)$")
_SIGNS = re.compile(r"[<>]|(?<![\w-])-(?=\d)")  # in text they come out as other characters
_UNITS = {"(L/tau)": r"($L/\tau$)", "(tau)": r"($\tau$)"}


def latex(frame: pd.DataFrame, caption: str, label: str, *, long: bool = False) -> str:
    r"""A formatted frame as a LaTeX table with booktabs; the hashes of its cells follow as comments.

    Args:
        frame: of text, whose columns before the first hash tell the rows apart.
        caption: in LaTeX.
        label: for \ref.
        long: may break over pages (package longtable); otherwise it is scaled to the line (graphicx).
    """
    texts = frame.map(lambda text: _HASH.sub("", text))
    columns = "l" * frame.shape[1]
    if long:
        table = texts.to_latex(
            index=False, escape=True, column_format=columns, longtable=True, caption=caption, label=label
        )
        body = f"{{\\footnotesize\n{table}}}\n"
    else:
        table = texts.to_latex(index=False, escape=True, column_format=columns)
        body = (
            f"\\begin{{table}}\n\\centering\n\\caption{{{caption}}}\n\\label{{{label}}}\n"
            f"\\resizebox{{\\linewidth}}{{!}}{{%\n{table}}}\n\\end{{table}}\n"
        )
    for plain, mathematics in _UNITS.items():
        body = body.replace(plain, mathematics)
    body = _SIGNS.sub(r"$\g<0>$", body)
    return f"% needs the packages booktabs, {'longtable' if long else 'graphicx'}\n{body}{_hashes(frame)}"


def _hashes(frame: pd.DataFrame) -> str:
    """A comment for every cell that has a hash."""
    lines = []
    for row in frame.to_dict("records"):
        found = {heading: _HASH.search(text) for heading, text in row.items()}
        key = ", ".join(row[heading] for heading, match in found.items() if not match and row[heading] != "-")
        lines += [f"% {key}: {heading}: #{match[1]}\n" for heading, match in found.items() if match]
    return "".join(lines)
