"""Numbers as the cells of a table show them."""

import pandas as pd
import pytest

from crawler_bench.output.cells import format_number, markdown


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0056, "0.0056"), (0.0049321, "0.00493"), (38.25, "38.2"), (123.4, "123"), (-123.6, "-124"),
     (0, "0"), (float("nan"), "-"), ("> 0", "> 0"), ("0.026", "0.026"), ("not given", "not given")],
)  # fmt: skip
def test_short_numbers(value, text):
    assert format_number(value) == text


def test_a_name_breaks_out_of_no_table():
    names = [
        "<script>x</script>",
        "[here](http://elsewhere)",
        "a|b",
        "a\n\n# b",
        "**bold** `a`",
        "1 < 2 [0, 1] (5)",
    ]
    table = markdown(pd.DataFrame({"agent": names, "n": range(len(names))})).splitlines()
    assert len(table) == len(names) + 2
    assert not [row for row in table if "<s" in row or "](" in row or row.replace(r"\|", "").count("|") != 3]
    assert "**bold** `a`" in table[6]
    assert "1 < 2 [0, 1] (5)" in table[7]
