"""Files of one's own: with other names, units, signs, separators the same recording; what does not fit is told."""

from pathlib import Path

import numpy as np
import pytest
from samples import same
from table_samples import csv_text, good

from mmt_drake.errors import BadInput
from mmt_drake.recording import Recording, load, save
from mmt_drake.recording.column_map import AS_NAMED, ColumnMap
from mmt_drake.recording.foreign_table import entry, guessed
from mmt_drake.recording.units import in_si, split

TIME = np.arange(200) * 0.01
PLAIN = {"time": TIME, "position": 0.01 * np.sin(5.0 * TIME), "force": -2.0 * np.sin(5.0 * TIME) + 0.25}
OWN = {"t [ms]": 1e3 * TIME, "Weg (mm)": 1e3 * PLAIN["position"], "F_mN": -1e3 * PLAIN["force"]}
ENTRIES = ("time=t", "position=Weg", "force=-F")


def write(path: Path, columns: dict[str, np.ndarray], separator: str = ",", decimal: str = ".") -> Path:
    rows = zip(*(values.tolist() for values in columns.values()), strict=True)
    lines = [separator.join(columns), *(separator.join(map(repr, row)).replace(".", decimal) for row in rows)]
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    return load(write(tmp_path_factory.mktemp("plain") / "a.csv", PLAIN))


def close(read: Recording, expected: Recording) -> None:
    np.testing.assert_allclose(read.time, expected.time, rtol=1e-12)
    assert set(read.columns) == set(expected.columns)
    for name in ("position", "force"):
        np.testing.assert_allclose(read[name], expected[name], rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize(("separator", "decimal"), [(",", "."), (";", "."), (";", ","), ("\t", ","), ("\t", ".")])
def test_a_file_in_mm_ms_and_mn_with_its_own_names_and_marks_reads_as_in_si(
    separator: str, decimal: str, plain: Recording, tmp_path: Path
) -> None:
    read = load(write(tmp_path / "own.csv", OWN, separator, decimal), columns=ColumnMap.of(ENTRIES))
    close(read, plain)
    assert read.units["position"] == "m" and read.units["force"] == "N"


def test_units_of_the_option_are_taken_where_the_header_has_none(plain: Recording, tmp_path: Path) -> None:
    path = write(tmp_path / "own.csv", dict(zip("txf", OWN.values(), strict=True)))
    close(load(path, columns=ColumnMap.of(["time=t:ms", "position=x:mm", "force=-f:mN"])), plain)
    mapping = tmp_path / "own.yaml"
    mapping.write_text("time: t:ms\nposition: x:mm\nforce: -f:mN\n")
    close(load(path, columns=ColumnMap.of([str(mapping)])), plain)
    np.savez(tmp_path / "own.npz", **dict(zip("txf", OWN.values(), strict=True)))
    close(load(tmp_path / "own.npz", columns=ColumnMap.of([str(mapping)])), plain)


def test_a_contract_s_name_with_a_unit_needs_no_map(plain: Recording, tmp_path: Path) -> None:
    headers = ("time_ms", "position [mm]", "force (mN)")
    values = (1e3 * TIME, 1e3 * PLAIN["position"], 1e3 * PLAIN["force"])
    close(load(write(tmp_path / "own.csv", dict(zip(headers, values, strict=True)))), plain)


@pytest.mark.parametrize(
    ("name", "header"),
    [("force", "force_kg"), ("force", "force_V"), ("position", "position_deg/s"), ("time", "time_m")],
)
def test_a_contract_s_name_with_a_unit_that_cannot_be_its_is_refused(name: str, header: str, tmp_path: Path) -> None:
    path = write(tmp_path / "own.csv", {header if key == name else key: values for key, values in PLAIN.items()})
    with pytest.raises(BadInput, match=f"header, column '{header}': found unit .*, expected a unit of {name}: "):
        load(path)


def test_a_unit_is_no_matter_of_a_column_that_a_mapped_file_leaves_out(tmp_path: Path) -> None:
    headers = ("time", "cmd", "angle", "force_V")
    path = write(tmp_path / "own.csv", dict(zip(headers, [*PLAIN.values(), TIME], strict=True)))
    read = load(path, columns=ColumnMap.of(["input=cmd:V", "output=angle:deg"]))
    assert "columns left out: force_V" in read.notes
    assert read.units == {"time": "s", "input": "V", "output": "rad", "output_rate": "rad/s"}


def test_angles_and_torques_have_no_limits_of_metres_and_newtons(tmp_path: Path) -> None:
    turned = {"time": TIME, "position_deg": 600.0 * np.sin(5.0 * TIME), "force_Nm": 3e4 * np.sin(5.0 * TIME)}
    read = load(write(tmp_path / "own.csv", turned))
    assert np.max(np.abs(read["position"])) > 5.0
    assert read.units == {"time": "s", "position": "rad", "velocity": "rad/s", "force": "N m"}
    with pytest.raises(BadInput, match=r"column 'position': found .*at most 5 m, is it in mm"):
        load(write(tmp_path / "own.csv", dict(zip(("time", "position", "force_Nm"), turned.values(), strict=True))))


def test_columns_that_nobody_asks_for_may_be_words_and_are_left_out(plain: Recording, tmp_path: Path) -> None:
    path = write(tmp_path / "own.csv", OWN, ";")
    lines = path.read_text().splitlines()
    path.write_text("\n".join([lines[0] + ";phase", *(f"{line};going up" for line in lines[1:])]) + "\n")
    read = load(path, columns=ColumnMap.of(ENTRIES))
    close(read, plain)
    assert "columns left out: phase" in read.notes
    lines[7] = lines[7].replace(";", ";x", 1)
    path.write_text("\n".join([lines[0] + ";phase", *(f"{line};going up" for line in lines[1:])]) + "\n")
    with pytest.raises(BadInput, match=r"row 7 \(line 8\), column 'Weg \(mm\)': found 'x"):
        load(path, columns=ColumnMap.of(ENTRIES))


@pytest.mark.parametrize("ending", [".csv", ".npz", ".mcap"])
def test_one_axis_of_three_is_a_recording_of_one_axis(ending: str, tmp_path: Path) -> None:
    rows = good()
    (tmp_path / "a.csv").write_text(csv_text(rows))
    save(load(tmp_path / "a.csv"), tmp_path / f"b{ending}")
    read = load(tmp_path / f"b{ending}", columns=ColumnMap(axis="y"))
    assert read.kind == "single_axis"
    (note,) = (note for note in read.notes if note.startswith("columns left out: "))
    assert {"position_x", "force_z"} <= set(note.removeprefix("columns left out: ").split(", "))
    np.testing.assert_array_equal(read["position"], rows["position_y"])
    np.testing.assert_array_equal(read["force"], rows["force_y"])


def test_a_file_with_one_axis_of_three_is_offered_to_be_read_as_such(tmp_path: Path) -> None:
    rows = {name: values for name, values in good().items() if name in ("time", "position_y", "force_y")}
    path = write(tmp_path / "a.csv", rows)
    with pytest.raises(BadInput, match="or --axis y, that axis alone"):
        load(path)
    assert load(path, columns=ColumnMap(axis="y")).kind == "single_axis"
    with pytest.raises(BadInput, match=r"--axis x: found columns time, .* expected also position_x, force_x"):
        load(path, columns=ColumnMap(axis="x"))


def test_what_a_hand_and_an_arm_did_can_be_read_as_a_driven_body(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(csv_text(good()))
    whole = load(tmp_path / "a.csv")
    save(whole, tmp_path / "a.mcap")
    read = load(tmp_path / "a.mcap", columns=ColumnMap({"input": "force_x", "output": "position_x"}))
    assert read.kind == "driven_body" and set(read.columns) == {"input", "output", "output_rate"}
    np.testing.assert_array_equal(read["input"], whole["force_x"])


def test_no_map_changes_nothing(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(csv_text(good()))
    same(load(tmp_path / "a.csv"), load(tmp_path / "a.csv", columns=AS_NAMED))


@pytest.mark.parametrize(
    ("entries", "message"),
    [
        (("time=t", "position=Weg", "position=F_mN"), r"position: found position twice: 'Weg' and 'F_mN'"),
        (
            ("time=t", "position=Weg", "force=Weg"),
            "found column 'Weg' for position and for force, expected each column",
        ),
        (("time=t", "position=Way"), r"found no column 'Way', expected one of t \[ms\], Weg \(mm\), F_mN"),
        (("time=t", "positon=Weg"), r"found 'positon', expected a column of a recording \(did you mean 'position'\?\)"),
        (("time=t", "position=Weg:N"), "found unit 'N', expected a unit of position: nm, um, mm, cm, m"),
        (("time=t", "position=Weg:furlong"), "found unit 'furlong', expected a unit of position"),
        (("time=t", "position=Weg:cm"), r"found unit cm of column 'Weg \(mm\)', expected mm, as its header says"),
        (("time=",), "found no column, expected time=COLUMN:UNIT"),
        (("own",), r"--map: found 'own', expected NAME=COLUMN:UNIT, or a \.yaml file of such lines"),
        ((), r"'time' among them; --map 'time=t \[ms\]:ms' .* `mmt-drake init own\.csv` looks"),
        (("time=t", "position=Weg"), "found time, position, expected also force"),
    ],
)
def test_a_mapping_that_does_not_fit_is_told_in_one_line(
    entries: tuple[str, ...], message: str, tmp_path: Path
) -> None:
    path = write(tmp_path / "own.csv", OWN)
    with pytest.raises(BadInput, match=message) as caught:
        load(path, columns=ColumnMap.of(entries))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("written", "expected"),
    [
        ("mm", ("m", 1e-3)),
        ("µm", ("m", 1e-6)),
        ("°", ("rad", np.pi / 180.0)),
        ("deg/s", ("rad/s", np.pi / 180.0)),
        ("mm/s", ("m/s", 1e-3)),
        ("rpm", ("rad/s", 2.0 * np.pi / 60.0)),
        ("N*m", ("N m", 1.0)),
        ("mNm", ("N m", 1e-3)),
        ("kgf", ("N", 9.80665)),
    ],
)
def test_units_are_those_of_the_si_brochure(written: str, expected: tuple[str, float]) -> None:
    found = in_si(written)
    assert found is not None and found[0] == expected[0]
    assert found[1] == pytest.approx(expected[1], rel=1e-12)


def test_a_header_is_split_into_name_and_unit_only_where_that_is_a_unit() -> None:
    expected = {"x [mm]": ("x", "mm"), "x_mm": ("x", "mm"), "force (filtered)": ("force (filtered)", None)}
    expected |= {"in_contact": ("in_contact", None), "position_x": ("position_x", None), "_s": ("_s", None)}
    assert {header: split(header) for header in expected} == expected


def test_names_that_people_use_are_guessed_and_nothing_else() -> None:
    one = guessed(["Zeit [s]", "Weg [mm]", "Kraft [N]", "note"])
    assert one == {"time": "Zeit [s]", "position": "Weg [mm]", "force": "Kraft [N]"}
    three = guessed(["t", "x", "y", "z", "fx", "fy", "fz"])
    assert three["position_z"] == "z" and three["force_x"] == "fx" and len(three) == 7
    assert guessed(["t", "motor_current_A", "q_deg"]) == {"time": "t", "input": "motor_current_A", "output": "q_deg"}
    assert guessed(["a", "b"]) == {}


def test_the_only_column_in_a_unit_is_guessed_by_it_where_no_name_is_known() -> None:
    one = guessed(["Stamp [s]", "Schlitten (mm)", "Last [kN]", "Raum [K]"])
    assert one == {"time": "Stamp [s]", "position": "Schlitten (mm)", "force": "Last [kN]"}
    three = guessed(["Stamp [s]", *(f"tip {axis} [mm]" for axis in "XYZ"), *(f"F{axis} [N]" for axis in "xyz")])
    assert three["position_z"] == "tip Z [mm]" and three["force_x"] == "Fx [N]" and len(three) == 7
    assert guessed(["t", "upper [mm]", "lower [mm]"]) == {"time": "t"}, "two of a unit"
    assert guessed(["t", "command [N]", "q [mm]"]) == {"time": "t", "input": "command [N]", "output": "q [mm]"}


def test_an_entry_tells_column_and_unit() -> None:
    assert entry("force", "Kraft [N]") == "Kraft [N]:N"


@pytest.mark.parametrize("entry", ["t:N", "t:furlong", "", "-"])
def test_a_refused_entry_says_where_the_documents_say_more(entry: str) -> None:
    with pytest.raises(BadInput, match=r"expected .+ \(docs/files\.md\)$"):
        ColumnMap({"time": entry})
