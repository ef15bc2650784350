"""What breaks the contract is refused in one line that names the file, the place, what is there and what should be."""

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from samples import csv_text, motion_rows

from mmt_drake.cli.convert import convert
from mmt_drake.errors import BadInput
from mmt_drake.recording import load

Columns = dict[str, np.ndarray]


def changed(**values: np.ndarray | None) -> Columns:
    """The rows of a good recording with columns replaced, added, or (None) taken away."""
    columns = motion_rows() | values
    return {name: column for name, column in columns.items() if column is not None}


def with_cell(name: str, row: int, value: float) -> Columns:
    """One cell of a good recording changed; rows count from 1."""
    columns = motion_rows()
    columns[name][row - 1] = value
    return columns


TIME = motion_rows()["time"]
WAVE = np.sin(5.0 * TIME)

# Wrong contents, the same whatever the format: what the message says after the file's name.
CONTENTS: dict[str, tuple[Columns, str]] = {
    "NaN": (with_cell("force_y", 7, np.nan), "row 7, column 'force_y': found nan, expected a finite number"),
    "infinite": (with_cell("position_x", 50, -np.inf), "row 50, column 'position_x': found -inf"),
    "NaN in time": (with_cell("time", 3, np.nan), "row 3, column 'time': found nan"),
    "time goes back": (with_cell("time", 20, 0.1), "row 20, column 'time': found time going back, 0.1 s after 0.18 s"),
    "time twice": (with_cell("time", 20, 0.18), "row 20, column 'time': found the same time again"),
    "time in ms": (changed(time=1e3 * TIME), r"column 'time': found a median step of 10 s, .* is this ms, us or ns\?"),
    "time in ns": (changed(time=1e9 * TIME), r"found a median step of 1e\+07 s"),
    "a time beyond all": (
        changed(time=np.append(TIME[:-1], 1e100)),
        r"column 'time': found 1e\+100, expected at most 1e\+12 s",
    ),
    "time in ks": (changed(time=1e-7 * TIME), "found a median step of 1e-09 s"),
    "positions in mm": (
        changed(position_y=300.0 * WAVE),
        r"column 'position_y': found .*expected at most 5 m, is it in mm",
    ),
    "forces in mN": (changed(force_z=5000.0 + WAVE), r"column 'force_z': found .*expected at most 1000 N, is it in mN"),
    "velocities in mm/s": (
        changed(**{f"velocity_{a}": 1e3 * np.gradient(motion_rows()[f"position_{a}"], TIME) for a in "xyz"}),
        r"column 'velocity_x': found 1e\+03 times the rate|column 'velocity_x': found 99\d times the rate",
    ),
    "no force": (changed(force_x=None, force_y=None, force_z=None), "expected also force_x, force_y, force_z"),
    "one force missing": (changed(force_y=None), "columns: found time, .*, expected also force_y"),
    "one position missing": (changed(position_z=None), "expected also position_z"),
    "half a velocity": (changed(velocity_x=WAVE), "expected also velocity_y, velocity_z"),
    "half a theta": (changed(theta_m=WAVE, theta_k1=WAVE), "expected also theta_k2, theta_b1, theta_b2, theta_Fc"),
    "typing error": (changed(force_zz=WAVE), r"unknown column 'force_zz', .*did you mean 'force_z'"),
    "no such column": (
        changed(temperature=WAVE),
        "unknown column 'temperature', expected a column of a contact recording",
    ),
    "two kinds at once": (
        changed(input=WAVE),
        "unknown column 'position_x', expected a column of a driven body recording",
    ),
    "a flag of one half": (
        changed(in_contact=0.5 + 0 * WAVE),
        "row 1, column 'in_contact': found 0.5, expected 0 or 1",
    ),
    "two samples": (
        {name: values[:2] for name, values in motion_rows().items()},
        "found 2 samples, expected at least 3",
    ),
    "a number no unit gives": (
        {"time": TIME, "input": WAVE, "output": 1e307 * WAVE},
        r"column 'output': found .*expected at most 1e\+100 in any unit",
    ),
    "driven body without output": ({"time": TIME, "input": WAVE}, "expected also output"),
    "one axis without force": ({"time": TIME, "position": WAVE}, "expected also force"),
    "one axis, tons": ({"time": TIME, "position": WAVE, "force": 1e5 * WAVE}, "expected at most 20000 N"),
    "infinite theta": (
        changed(**{f"theta_{name}": np.full(50, np.inf) for name in ("m", "k1", "k2", "b1", "b2", "Fc")}),
        "row 1, column 'theta_m': found inf",
    ),
}


def write_csv(path: Path, columns: Columns) -> Path:
    path.write_text(csv_text(columns))
    return path


def write_npz(path: Path, columns: Columns) -> Path:
    np.savez(path, **columns)
    return path


@pytest.mark.parametrize("case", CONTENTS)
@pytest.mark.parametrize(("name", "write"), [("a.csv", write_csv), ("a.npz", write_npz)])
def test_wrong_contents(case: str, name: str, write: Callable[[Path, Columns], Path], tmp_path: Path) -> None:
    columns, message = CONTENTS[case]
    path = write(tmp_path / name, columns)
    refused(path, message)


def refused(path: Path, message: str) -> None:
    """One line that begins with the file and matches; conversion writes nothing."""
    with pytest.raises(BadInput, match=message) as caught:
        load(path)
    assert str(caught.value).startswith(str(path)) and "\n" not in str(caught.value)
    before = sorted(os.listdir(path.parent)) if path.parent.is_dir() else []
    with pytest.raises(BadInput):
        convert(str(path), str(path.parent / "out.npz"), {})
    assert (sorted(os.listdir(path.parent)) if path.parent.is_dir() else []) == before


GOOD = csv_text(motion_rows())
LINES = GOOD.splitlines()

TEXTS: dict[str, tuple[str, str]] = {
    "a word": (
        GOOD.replace(LINES[4].split(",")[1], "lots", 1),
        "row 4 (line 5), column 'position_x': found 'lots', expected a number",
    ),
    "an empty cell": (
        "\n".join([*LINES[:6], LINES[6].replace(LINES[6].split(",")[2], "", 1)]),
        "row 6 (line 7), column 'force_x': found ''",
    ),
    "a short row": ("\n".join([*LINES[:9], "0.5,0.1"]), "row 9 (line 10): found 2 cells, expected 7"),
    "a long row": ("\n".join([*LINES[:9], LINES[9] + ",1"]), "row 9 (line 10): found 8 cells, expected 7"),
    "a cut last row": (GOOD[:-30], "row 50 (line 51)"),
    "every row longer than the header": (
        "\n".join([LINES[0], *(line + ",1" for line in LINES[1:])]),
        "row 1 (line 2): found 8 cells",
    ),
    "digits with underscores": (
        GOOD.replace(LINES[4].split(",")[1], "1_0", 1),
        "row 4 (line 5), column 'position_x': found '1_0'",
    ),
    "decimal commas": (
        "\n".join(line.replace(",", ";").replace(".", ",") for line in LINES),
        "found columns separated by ';', expected commas",
    ),
    "tabs": (GOOD.replace(",", "\t"), r"found columns separated by '\t'"),
    "no header": ("\n".join(LINES[1:]), "header: found a row of numbers, expected column names"),
    "no time": (GOOD.replace("time", "zeit", 1), "expected column names, 'time' among them"),
    "a column twice": (GOOD.replace("force_y", "force_x", 1), "found column 'force_x' twice"),
    "a header alone": (LINES[0] + "\n\n", "found a header and no rows"),
    "a comment": (GOOD.replace("\n", "\n# made up\n", 1), "row 1 (line 2)"),
}


@pytest.mark.parametrize("case", TEXTS)
def test_csv_that_is_no_table(case: str, tmp_path: Path) -> None:
    import re

    text, message = TEXTS[case]
    (tmp_path / "a.csv").write_text(text)
    refused(tmp_path / "a.csv", re.escape(message))


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
    text = csv_text(motion_rows())
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


def truncated_npz(path: Path) -> None:
    write_npz(path, motion_rows())
    path.write_bytes(path.read_bytes()[:-100])


def damaged_npz(path: Path) -> None:
    write_npz(path, motion_rows())
    data = bytearray(path.read_bytes())
    data[300] ^= 0xFF
    path.write_bytes(bytes(data))


FILES: dict[str, tuple[str, Callable[[Path], object], str]] = {
    "missing": ("a.csv", lambda path: None, "found no such file"),
    "empty csv": ("a.csv", lambda path: path.touch(), "found an empty file"),
    "empty mcap": ("a.mcap", lambda path: path.touch(), "found an empty file"),
    "empty npz": ("a.npz", lambda path: path.touch(), "found an empty file"),
    "another ending": (
        "a.txt",
        lambda path: path.write_text(GOOD),
        r"found ending '\.txt', expected \.mcap \.csv \.npz \.bag \.db3",
    ),
    "no ending": ("a", lambda path: path.write_text(GOOD), "found ending ''"),
    "a folder that is no bag": ("a", lambda path: path.mkdir(), r"found a folder without metadata\.yaml"),
    "binary csv": ("a.csv", lambda path: path.write_bytes(b"time,\xff\xfe\x00"), "found bytes that are no text at 5"),
    "csv called mcap": ("a.mcap", lambda path: path.write_text(GOOD), "found another beginning, expected an MCAP file"),
    "csv called npz": ("a.npz", lambda path: path.write_text(GOOD), "found a file that cannot be read"),
    "csv called bag": ("a.bag", lambda path: path.write_text(GOOD), "found a bag that cannot be read"),
    "csv called db3": ("a.db3", lambda path: path.write_text(GOOD), "found a bag that cannot be read"),
    "truncated npz": ("a.npz", truncated_npz, "found a file that cannot be read"),
    "damaged npz": ("a.npz", damaged_npz, "found a file that cannot be read"),
    "words in npz": (
        "a.npz",
        lambda path: np.savez(path, time=np.array(["a", "b"])),
        "time: found type <U1, expected numbers",
    ),
    "objects in npz": (
        "a.npz",
        lambda path: np.savez(path, time=np.array([None, {}])),
        "time: found type object, expected numbers",
    ),
    "columns of two lengths": (
        "a.npz",
        lambda path: np.savez(path, **changed(force_y=WAVE[:-1])),
        "force_y: found 49 values, expected 50, as many as times",
    ),
    "a table as a column": (
        "a.npz",
        lambda path: np.savez(path, **changed(force=np.zeros((50, 3)))),
        r"force: found shape \(50, 3\)",
    ),
    "an unknown set": (
        "a.npz",
        lambda path: np.savez(path, t=TIME, y=WAVE),
        "found arrays t, y, expected 'time' .* known data set .*emps",
    ),
    "half a cloud": (
        "a.npz",
        lambda path: np.savez(path, **changed(cloud_time=TIME)),
        r"clouds: found cloud_time \(50,\)",
    ),
    "an mcap header alone": (
        "a.mcap",
        lambda path: path.write_bytes(b"\x89MCAP0\r\n"),
        "found no message on any known topic",
    ),
}


@pytest.mark.parametrize("case", FILES)
def test_files_that_are_no_recording(case: str, tmp_path: Path) -> None:
    name, make, message = FILES[case]
    make(tmp_path / name)
    refused(tmp_path / name, message)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_a_file_that_may_not_be_read(tmp_path: Path) -> None:
    path = write_csv(tmp_path / "a.csv", motion_rows())
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
    source = write_csv(tmp_path / "a.csv", motion_rows())
    (tmp_path / "folder.csv").mkdir()
    with pytest.raises(BadInput, match=message):
        convert(str(source), str(tmp_path / target), {})
    assert sorted(os.listdir(tmp_path)) == ["a.csv", "folder.csv"]


def test_topics_mean_nothing_to_a_table(tmp_path: Path) -> None:
    source = write_csv(tmp_path / "a.csv", motion_rows())
    with pytest.raises(BadInput, match=r"--topic force=/ft: found a \.csv file, without topics"):
        load(source, {"force": "/ft"})


def test_negative_times_cannot_become_mcap(tmp_path: Path) -> None:
    source = write_csv(tmp_path / "a.csv", changed(time=TIME - 0.2))
    with pytest.raises(BadInput, match=r"b\.mcap: row 1: found time -0\.2 s, expected 0 s or later"):
        convert(str(source), str(tmp_path / "b.mcap"), {})
    assert os.listdir(tmp_path) == ["a.csv"]
