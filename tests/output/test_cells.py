"""Numbers as the cells of a table show them."""

import pytest

from crawler_bench.output.cells import format_number


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0056, "0.0056"), (0.0049321, "0.00493"), (38.25, "38.2"), (123.4, "123"), (-123.6, "-124"),
     (0, "0"), (float("nan"), "-"), ("> 0", "> 0"), ("0.026", "0.026"), ("not given", "not given")],
)  # fmt: skip
def test_short_numbers(value, text):
    assert format_number(value) == text
