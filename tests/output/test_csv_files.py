"""Frames on their way through CSV files."""

import pandas as pd

from crawler_bench.output.csv_files import rounded, write_csv


def test_csv_has_nine_digits(tmp_path):
    write_csv(pd.DataFrame({"x": [1 / 3, 1e-12], "n": [1, 2]}), tmp_path / "x.csv")
    assert (tmp_path / "x.csv").read_text() == "x,n\n0.333333333,1\n1e-12,2\n"


def test_names_policies_and_hashes_come_back_as_text():
    frame = pd.DataFrame({
        "agent": ["NA", "nan", "1"], "policy": ["0123", "01*2", "9999"], "hash": ["1e5", "00001234", "inf"],
        "speed": [1.5, float("nan"), 2.0],
    })  # fmt: skip
    pd.testing.assert_frame_equal(rounded(frame), frame)
