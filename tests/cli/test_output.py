"""Tables on a terminal or in a pipe: no number is ever cut."""

import io

import numpy as np
import pytest
from rich.console import Console

from mmt_drake.analysis.table import Table
from mmt_drake.cli.main import main
from mmt_drake.cli.output import console, on_terminal, print_json, say
from mmt_drake.errors import BadInput
from mmt_drake.recording import Recording, save

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


CODES = "a\x1b[2J\x1b]0;title\x07b\x9b1m\rc\u202ed\udcff"
SHOWN = r"a\x1b[2J\x1b]0;title\x07b\x9b1m\rc\u202ed\udcff"


def test_codes_for_a_terminal_are_shown_and_not_sent(capsys):
    say(CODES + "\n\tμm – fine")
    console().print(CODES, markup=False)
    console().print(on_terminal(Table(["case"], [[CODES]], CODES)))
    out = capsys.readouterr().out
    assert out.count(SHOWN) == 4 and "\n\tμm – fine" in out and not set(out) & set("\x1b\x07\x9b\r\u202e\udcff")
    assert SHOWN.replace(r"\r", " ") in str(BadInput("a.csv", at=CODES, found="b", expected="c"))


def test_a_message_with_all_of_a_file_in_it_is_cut():
    line = str(BadInput("a.csv", found="x" * 10**6, expected="numbers"))
    assert line.startswith("a.csv: found xxx") and line.endswith("xxx, expected numbers") and len(line) < 4100


def test_names_from_files_reach_no_terminal_as_they_are(tmp_path, capsys):
    source = tmp_path / "\x1b[31mred.csv"
    source.write_text("time,position_x,\x1b[2Jposition_y\n0,1,2\n")
    assert main(["convert", str(source), str(tmp_path / "a.npz")]) == 2
    time = np.arange(10) * 0.01
    save(Recording(time, {f"{name}_{axis}": 0.001 * time for name in ("position", "force") for axis in "xyz"}), source)
    assert main(["convert", str(source), str(tmp_path / "a.npz")]) == 0
    told = capsys.readouterr()
    assert r"\x1b[31mred.csv" in told.out and r"\x1b[2Jposition_y" in told.err
    assert "\x1b" not in told.out + told.err
