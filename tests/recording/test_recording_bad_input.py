"""What breaks the contract is refused in one line that names the file, the place, what is there and what should be."""

import os
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from table_samples import TIME, WAVE, Columns, changed, csv_text, good, with_cell

from mmt_drake.cli.convert import convert
from mmt_drake.errors import BadInput
from mmt_drake.model.parameters import TANGENTIAL_THETA
from mmt_drake.recording import load
from mmt_drake.recording.column_map import ColumnMap

DRIVEN = {"time": TIME, "input": WAVE}

# Wrong contents, the same whatever the format, and what the message says after the file's name.
CONTENTS: list[tuple[Columns, str]] = [
    (with_cell("force_y", 7, np.nan), "row 7, column 'force_y': found nan, expected a finite number"),
    (with_cell("position_x", 50, -np.inf), "row 50, column 'position_x': found -inf"),
    (with_cell("time", 3, np.nan), "row 3, column 'time': found nan"),
    (with_cell("time", 20, 0.1), "row 20, column 'time': found time going back, 0.1 s after 0.18 s"),
    (with_cell("time", 20, 0.18), "row 20, column 'time': found the same time again"),
    (changed(time=1e3 * TIME), r"column 'time': found a median step of 10 s, .* is this ms, us or ns\?"),
    (changed(time=1e9 * TIME), r"found a median step of 1e\+07 s"),
    (changed(time=np.append(TIME[:-1], 1e100)), r"column 'time': found 1e\+100, expected at most 1e\+12 s"),
    (changed(time=1e-7 * TIME), "found a median step of 1e-09 s"),
    (changed(position_y=300.0 * WAVE), r"column 'position_y': found .*expected at most 5 m, is it in mm"),
    (changed(force_z=5000.0 + WAVE), r"column 'force_z': found .*expected at most 1000 N, is it in mN"),
    (
        changed(**{f"velocity_{a}": 1e3 * np.gradient(good()[f"position_{a}"], TIME) for a in "xyz"}),
        r"column 'velocity_x': found (1e\+03|99\d) times the rate",
    ),
    (changed(force_x=None, force_y=None, force_z=None), "expected also force_x, force_y, force_z"),
    (changed(force_y=None), "columns: found time, .*, expected also force_y"),
    (changed(position_z=None), "expected also position_z"),
    (changed(velocity_x=WAVE), "expected also velocity_y, velocity_z"),
    (changed(theta_m=WAVE, theta_k1=WAVE), "expected also theta_k2, theta_b1, theta_b2, theta_Fc"),
    (changed(force_zz=WAVE), r"unknown column 'force_zz', .*did you mean 'force_z'"),
    (changed(temperature=WAVE), "unknown column 'temperature', expected a column of a contact recording"),
    (changed(input=WAVE), "unknown column 'position_x', expected a column of a driven body recording"),
    (changed(in_contact=0.5 + 0 * WAVE), "row 1, column 'in_contact': found 0.5, expected 0 or 1"),
    ({name: values[:2] for name, values in good().items()}, "found 2 samples, expected at least 3"),
    (DRIVEN | {"output": 1e307 * WAVE}, r"column 'output': found .*expected at most 1e\+100 in any unit"),
    (DRIVEN, "expected also output"),
    ({"time": TIME, "position": WAVE}, "expected also force"),
    ({"time": TIME, "position": WAVE, "force": 1e5 * WAVE}, "expected at most 20000 N"),
    (changed(**{f"theta_{name}": np.inf * TIME**0 for name in TANGENTIAL_THETA}), "row 1, column 'theta_m': found inf"),
]


def write_csv(path: Path, columns: Columns) -> Path:
    path.write_text(csv_text(columns))
    return path


def write_npz(path: Path, columns: Columns) -> Path:
    np.savez(path, **columns)
    return path


@pytest.mark.parametrize(("columns", "message"), CONTENTS)
@pytest.mark.parametrize(("name", "write"), [("a.csv", write_csv), ("a.npz", write_npz)])
def test_wrong_contents(
    columns: Columns, message: str, name: str, write: Callable[[Path, Columns], Path], tmp_path: Path
) -> None:
    refused(write(tmp_path / name, columns), message)


def refused(path: Path, message: str) -> None:
    """One line that begins with the file and matches; conversion writes nothing."""
    with pytest.raises(BadInput, match=message) as caught:
        load(path)
    assert str(caught.value).startswith(str(path)) and "\n" not in str(caught.value)
    before = sorted(os.listdir(path.parent)) if path.parent.is_dir() else []
    with pytest.raises(BadInput):
        convert(str(path), str(path.parent / "out.npz"), {})
    assert (sorted(os.listdir(path.parent)) if path.parent.is_dir() else []) == before


GOOD = csv_text(good())
LINES = GOOD.splitlines()


def with_first_cell(row: int, cell: str) -> str:
    """The first cell after the time replaced."""
    return GOOD.replace(LINES[row].split(",")[1], cell, 1)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (with_first_cell(4, "lots"), "row 4 (line 5), column 'position_x': found 'lots', expected a number"),
        (with_first_cell(6, ""), "row 6 (line 7), column 'position_x': found ''"),
        ("\n".join([*LINES[:9], "0.5,0.1"]), "row 9 (line 10): found 2 cells, expected 7"),
        ("\n".join([*LINES[:9], LINES[9] + ",1"]), "row 9 (line 10): found 8 cells, expected 7"),
        (GOOD[:-30], "row 50 (line 51)"),
        ("\n".join([LINES[0], *(line + ",1" for line in LINES[1:])]), "row 1 (line 2): found 8 cells"),
        (with_first_cell(4, "1_0"), "row 4 (line 5), column 'position_x': found '1_0'"),
        (GOOD.replace(",", ";").replace(".", ",", 9), "found numbers with a comma and with a point in lines from 2 on"),
        ("\n".join(LINES[1:]), "header: found a row of numbers, expected column names"),
        (GOOD.replace("time", "zeit", 1), "expected column names, 'time' among them"),
        (GOOD.replace("force_y", "force_x", 1), "found column 'force_x' twice"),
        (LINES[0] + "\n\n", "found a header and no rows"),
        (GOOD.replace("\n", "\n# made up\n", 1), "row 1 (line 2)"),
    ],
)
def test_csv_that_is_no_table(text: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(text)
    refused(tmp_path / "a.csv", re.escape(message))


@pytest.mark.parametrize(
    ("row", "found"), [("0,01,1,5,2,0,up", "7 cells"), ("0.01,1.5", "2 cells"), ("0.01,1.5,2.0,up,up", "5 cells")]
)
def test_a_ragged_row_is_refused_where_not_all_columns_are_read_too(row: str, found: str, tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(f"time,x,F,phase\n0.00,1.0,2.0,up\n{row}\n0.02,2.0,2.0,up\n")
    with pytest.raises(BadInput, match=rf"a\.csv: row 2 \(line 3\): found {found}, expected 4, one per column"):
        load(tmp_path / "a.csv", columns=ColumnMap({"position": "x", "force": "F"}))


def with_last_column(cells: list[str]) -> str:
    """The first lines of good contents, their last cells replaced; no line end after the last."""
    lines = zip(LINES[1 : 1 + len(cells)], cells, strict=True)
    return "\n".join([LINES[0], *(f"{line.rpartition(',')[0]},{cell}" for line, cell in lines)])


@pytest.mark.parametrize(
    ("column", "cut"),
    [
        (["0.0", "0.0", "0.0", "0.0"], "0."),
        (["0.0", "0.0", "0.0", "0.0"], "0"),
        (["0.1250", "-0.5000", "12.2500", "0.0000"], "-12.250"),
        (["0.1250", "-0.5000", "12.2500", "0.0000"], "1"),
        (["0.4967141530112327", "-0.13826430117118466", "0.6476885381006925", "1.52"], "-0.2341533747"),
        (["1.25e-05", "3.75e-05", "-2.50e-06", "0.00e+00"], "1.25e-0"),
        (["1.25e-05", "3.75e-05", "-2.50e-06", "0.00e+00"], "1.25"),
        (["0.12345", "0.23456", "0.34567", "1.23456e-05"], "1.23456e-0"),
        (["124", "-125", "126", "123"], "10"),
    ],
)
def test_csv_cut_in_its_last_number(column: list[str], cut: str, tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text(with_last_column([*column, cut]))
    refused(
        path, rf"row 5 \(line 6\), column 'force_z': found '{cut}' without a line end, .* expected a whole last row"
    )
    path.write_text(with_last_column([*column, cut]) + "\n")
    assert load(path)["force_z"][-1] == float(cut)  # whoever ended the line has written the number to its end


@pytest.mark.parametrize(
    ("column", "last"),
    [
        (["0.0", "0.0", "0.0"], "0.0"),
        (["9.50", "-9.75", "10.00"], "-0.25"),
        (["0.5", "0.125", "-0.25"], "0.75"),
        (["1.25e-05", "3.75e-05", "0.00e+00"], "-1.25e-07"),
        (["0", "1", "0"], "1"),
    ],
)
@pytest.mark.parametrize("line_end", ["\n", "\r\n"])
def test_csv_whose_whole_last_row_has_no_line_end_is_read_and_noted(
    line_end: str, column: list[str], last: str, tmp_path: Path
) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(with_last_column([*column, last]).replace("\n", line_end).encode())
    read = load(path)
    assert read["force_z"].tolist() == [float(cell) for cell in [*column, last]]
    assert any(note.startswith("row 4, the last, has no line end") for note in read.notes)
    path.write_bytes(path.read_bytes() + line_end.encode() * 2)
    assert not any("line end" in note for note in load(path).notes)


def test_csv_of_this_package_cut_anywhere_in_its_last_row_is_refused_or_right(tmp_path: Path) -> None:
    """Shortest-form numbers: what is taken for whole may lack no more than its very last digits."""
    text = csv_text(good())
    last = float(text.rpartition(",")[2])
    path, accepted = tmp_path / "a.csv", 0
    for length in range(text.rindex("\n", 0, -1) + 2, len(text)):
        path.write_text(text[:length])
        try:
            read = load(path)
        except BadInput:
            continue
        accepted += 1
        assert abs(read["force_z"][-1] - last) < 1e-14
    assert 1 <= accepted <= 5


def text(path: Path) -> None:
    path.write_text(GOOD)


def npz(**arrays: np.ndarray) -> Callable[[Path], None]:
    return lambda path: np.savez(path, **arrays)


def truncated(path: Path) -> None:
    path.write_bytes(write_npz(path, good()).read_bytes()[:-100])


def damaged(path: Path) -> None:
    data = bytearray(write_npz(path, good()).read_bytes())
    data[300] ^= 0xFF
    path.write_bytes(bytes(data))


@pytest.mark.parametrize(
    ("name", "make", "message"),
    [
        ("a.csv", lambda path: None, "found no such file"),
        ("a.csv", Path.touch, "found an empty file"),
        ("a.mcap", Path.touch, "found an empty file"),
        ("a.npz", Path.touch, "found an empty file"),
        ("a.txt", text, r"found ending '\.txt', expected \.mcap \.csv \.npz \.bag \.db3"),
        ("a", text, "found ending ''"),
        ("a", Path.mkdir, r"found a folder without metadata\.yaml"),
        ("a.csv", lambda path: path.write_bytes(b"time,\xff\xfe\x00"), "found bytes that are no text at 5"),
        ("a.mcap", text, "found another beginning, expected an MCAP file"),
        ("a.npz", text, "found a file that cannot be read"),
        ("a.bag", text, "found a bag that cannot be read"),
        ("a.db3", text, "found a bag that cannot be read"),
        ("a.npz", truncated, "found a file that cannot be read"),
        ("a.npz", damaged, "found a file that cannot be read"),
        ("a.npz", npz(time=np.array(["a", "b"])), "time: found type <U1, expected numbers"),
        ("a.npz", npz(time=np.array([None, {}])), "time: found type object, expected numbers"),
        ("a.npz", npz(**changed(force_y=WAVE[:-1])), "force_y: found 49 values, expected 50, as many as times"),
        ("a.npz", npz(**changed(force=np.zeros((50, 3)))), r"force: found shape \(50, 3\)"),
        ("a.npz", npz(t=TIME, y=WAVE), "found arrays t, y, expected 'time' .* known data set .*emps"),
        ("a.npz", npz(**changed(cloud_time=TIME)), r"clouds: found cloud_time \(50,\)"),
        ("a.mcap", lambda path: path.write_bytes(b"\x89MCAP0\r\n"), "found no message on any known topic"),
    ],
)
def test_files_that_are_no_recording(name: str, make: Callable[[Path], object], message: str, tmp_path: Path) -> None:
    make(tmp_path / name)
    refused(tmp_path / name, message)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_a_file_that_may_not_be_read(tmp_path: Path) -> None:
    path = write_csv(tmp_path / "a.csv", good())
    path.chmod(0)
    refused(path, "found no permission to read it")


@pytest.mark.parametrize(
    ("target", "message"),
    [
        ("a.bag", r"a\.bag: found ending '\.bag', expected one that can be written: \.mcap \.csv \.npz"),
        ("none/a.csv", r"none/a\.csv: found no folder .*none, expected an existing folder"),
        ("folder.csv", r"folder\.csv: found a folder, expected a name for a file"),
    ],
)
def test_targets_that_cannot_be_written(target: str, message: str, tmp_path: Path) -> None:
    source = write_csv(tmp_path / "a.csv", good())
    (tmp_path / "folder.csv").mkdir()
    with pytest.raises(BadInput, match=message):
        convert(str(source), str(tmp_path / target), {})
    assert sorted(os.listdir(tmp_path)) == ["a.csv", "folder.csv"]


def test_topics_mean_nothing_to_a_table(tmp_path: Path) -> None:
    source = write_csv(tmp_path / "a.csv", good())
    with pytest.raises(BadInput, match=r"--topic force=/ft: found a \.csv file, without topics"):
        load(source, {"force": "/ft"})


def test_negative_times_cannot_become_mcap(tmp_path: Path) -> None:
    source = write_csv(tmp_path / "a.csv", changed(time=TIME - 0.2))
    with pytest.raises(BadInput, match=r"b\.mcap: row 1: found time -0\.2 s, expected 0 s or later"):
        convert(str(source), str(tmp_path / "b.mcap"), {})
    assert os.listdir(tmp_path) == ["a.csv"]
