"""Frames on their way through CSV files."""

import pandas as pd

from crawler_bench.output.csv_files import write_csv


def test_csv_has_nine_digits(tmp_path):
    write_csv(pd.DataFrame({"x": [1 / 3, 1e-12], "n": [1, 2]}), tmp_path / "x.csv")
    assert (tmp_path / "x.csv").read_text() == "x,n\n0.333333333,1\n1e-12,2\n"
