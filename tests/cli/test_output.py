"""Tables on a terminal or in a pipe: no number is ever cut."""

import io

import pytest
from rich.console import Console

from mmt_drake.analysis.table import Table
from mmt_drake.cli.output import on_terminal, print_json

HEADERS = ["case", *(f"a rather long name of column {number} [%]" for number in range(10))]


def printed(table: Table, width: int = 120) -> list[str]:
    text = io.StringIO()
    Console(file=text, width=width).print(on_terminal(table))
    return text.getvalue().splitlines()


def test_headers_break_at_words_so_that_no_cell_is_cut():
    cells = [0.0009256, 1818.0, None, 12.34567, 0.5, 1e-3, 99.9, 7.0, 440.0, 801.5]
    lines = printed(Table(HEADERS, [["thesis_rls_without_a", *cells]], "In [brackets]."))
    assert lines[0].startswith("In [brackets].")
    row = next(line for line in lines if line.startswith("thesis_rls_without_a"))
    assert row.split()[1:] == ["0.0009256", "1818", "–", "12.35", "0.5", "0.001", "99.9", "7", "440", "801.5"]
    narrow = "".join(printed(Table(HEADERS, [["a", *cells]]), width=60))
    assert "…" not in "".join(lines) + narrow


def test_numbers_and_dashes_stand_at_the_right_and_text_at_the_left():
    lines = printed(Table(["case", "error", "says"], [["a", 1.5, "yes"], ["longer", None, "no"]]))
    assert [line.rstrip() for line in lines] == ["case    error  says", "a         1.5  yes", "longer      –  no"]


def test_a_column_may_have_no_name():
    lines = printed(Table(["object", "", "m [kg]"], [["48", "true", 1.5], ["", "found", 1.51]]))
    assert lines[0].split() == ["m"] and lines[1].split() == ["object", "[kg]"]
    assert [line.split() for line in lines[2:]] == [["48", "true", "1.5"], ["found", "1.51"]]


def test_what_json_has_no_word_for_is_not_printed(capsys):
    with pytest.raises(ValueError, match="Out of range"):
        print_json({"error": float("nan")})
    assert capsys.readouterr().out == ""
