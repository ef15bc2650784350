"""Numbers as people read them."""

import pytest

from mmt_drake.analysis.table import Table
from mmt_drake.analysis.wording import milliseconds, percent, significant


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [(440.123, 2, "440"), (1818.0, 3, "1820"), (12345.6, 4, "12350"), (9.96, 2, "10"), (-2e-7, 2, "-2e-07")],
)
def test_large_numbers_are_rounded_and_have_no_exponent(value: float, digits: int, text: str) -> None:
    assert significant(value, digits) == text


def test_ratios_are_told_in_percent_and_times_in_milliseconds() -> None:
    assert [percent(ratio) for ratio in (0.1234, 18.18, 0.0, None)] == ["12.3 %", "1820 %", "0 %", "unknown"]
    assert [milliseconds(time) for time in (0.8015, -0.0012, None)] == ["801.5 ms", "-1.2 ms", "an unknown time"]


def test_a_table_is_printed_to_four_digits_with_a_dash_for_what_is_not_known() -> None:
    table = Table(["case", "error", "lags", "why"], [["a", 12.34567, 3, None], ["b", None, 12, None]])
    assert table.texts() == [["a", "12.35", "3", "–"], ["b", "–", "12", "–"]]
    assert [table.is_numeric(column) for column in range(4)] == [False, True, True, True]
