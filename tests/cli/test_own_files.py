"""From a file of one's own to an answer: `init`, `fit`, and `diagnose` without a model."""

import json
from pathlib import Path

import pytest
from cli_samples import Program

from mmt_drake.diagnosis.own_file import OwnFile
from mmt_drake.errors import BadInput
from mmt_drake.model_files import load_model

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
"""tensile.csv: k 1200 N/m, b 35 N s/m, F0 0.8 N, in mm and ms, with the sign of the machine."""


@pytest.fixture
def strip(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """4 s of the shipped example, in a folder of its own."""
    monkeypatch.chdir(tmp_path)
    lines = (EXAMPLES / "tensile.csv").read_text().splitlines()[:1001]
    Path("strip.csv").write_text("\n".join(lines) + "\n")
    return Path("strip.csv")


def test_two_commands_lead_from_a_file_in_mm_to_a_report(strip: Path, program: Program) -> None:
    done = program("init", strip)
    assert done.status == 0 and "next: mmt-drake diagnose strip.csv --map strip.map.yaml --out out/strip" in done.out
    mapping = Path("strip.map.yaml").read_text()
    assert "position: Weg [mm]:mm" in mapping and "force: -Kraft [N]:N" in mapping and "turned round" in mapping
    done = program("diagnose", strip, "--map", "strip.map.yaml", "--out", "out/strip", "--json")
    assert done.status == 0, done.err
    document = json.loads(done.out)
    assert document["verdict"] == "no_mismatch" and document["first_model"] == "first_model.yaml"
    assert document["summary"].startswith("No model was handed in; one was fitted to the recordings first")
    assert "the model handed in" not in document["summary"]
    assert "first_model.yaml" in Path("out/strip/report.html").read_text()
    model = load_model("out/strip/first_model.yaml")
    assert model.value("k") == pytest.approx(1200.0, rel=0.01)


def test_fit_prints_each_number_with_its_interval_and_writes_them_into_the_file(strip: Path, program: Program) -> None:
    columns = ("--map", "time=t:ms", "--map", "position=Weg", "--map", "force=-Kraft")
    done = program("fit", strip, *columns, "--out", "m.yaml")
    assert done.status == 0, done.err
    rows = {line.split()[0]: line for line in done.out.splitlines() if line}
    assert rows["k"].endswith("determined") and " to " in rows["b"] and "Held-out" in rows
    assert "# k [N/m]: 11" in Path("m.yaml").read_text() and ", determined" in Path("m.yaml").read_text()
    done = program("fit", strip, *columns, "--out", "m.yaml", "--json")
    found = {number["symbol"]: number for number in json.loads(done.out)["numbers"]}
    assert found["F0"]["ci95"][0] <= 0.8 <= found["F0"]["ci95"][1]


def test_init_writes_a_model_that_reads_and_touches_nothing_that_is_there(strip: Path, program: Program) -> None:
    assert program("init", strip, "--out", "lab").status == 0
    assert load_model("lab/strip.model.yaml").value("k") == pytest.approx(1200.0, rel=0.1)
    done = program("init", strip, "--out", "lab")
    assert done.status == 2 and "strip.map.yaml: found a file that is there already" in done.err


def test_init_of_a_file_with_a_recording_s_names_maps_nothing(program: Program, tmp_path: Path) -> None:
    done = program("init", EXAMPLES / "servo.csv", "--out", tmp_path)
    assert done.status == 0 and "of a driven_body" in done.out
    assert sorted(path.name for path in tmp_path.iterdir()) == ["servo.model.yaml"]


def test_init_leaves_no_mapping_behind_if_its_model_is_refused(
    strip: Path, program: Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(self: OwnFile, path: Path) -> None:
        raise BadInput(path, found="a full disk", expected="room")

    monkeypatch.setattr(OwnFile, "write_model", refused)
    done = program("init", strip)
    assert done.status == 2 and "found a full disk" in done.err
    assert [path.name for path in Path().iterdir()] == ["strip.csv"]


def test_init_of_columns_that_nobody_knows_leaves_a_form_to_fill_in(program: Program, tmp_path: Path) -> None:
    (tmp_path / "odd.csv").write_text("aa,bb,cc\n" + "".join(f"{i},{i % 7},{i % 5}\n" for i in range(50)))
    done = program("init", tmp_path / "odd.csv", "--out", tmp_path)
    assert done.status == 0 and "Fill in" in done.out
    text = (tmp_path / "odd.map.yaml").read_text()
    assert "# time: COLUMN:UNIT" in text and "# not read: aa, bb, cc" in text
    assert "# Of three axes: position_x, _y, _z and force_x, _y, _z." in text


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("fit", "{}", "--out", "m.yaml"), "expected column names, 'time' among them; --map 'time=t [ms]:ms'"),
        (
            ("fit", "{}", "--map", "time=t:N", "--out", "m.yaml"),
            "--map time=t:N: found unit 'N', expected a unit of time",
        ),
        (("convert", "{}", "a.csv", "--map", "time=q"), "--map time=q: found no column 'q', expected one of t [ms]"),
        (("simulate", "--model", "m.yaml", "--operator", "{}", "--axis", "y", "--out", "a.csv"), "m.yaml"),
        (("run", "setup1", "--operator", "{}", "--map", "time=t"), "also position_x, position_y, position_z"),
        (("run", "setup1", "--map", "time=t"), "--map: found no --operator, expected a file whose columns it names"),
        (("diagnose", "{}", "--blocks", "setup1", "--out", "o"), "--blocks: found no --model"),
        (
            ("diagnose", "{}", "--model", "m.yaml", "--structure", "driven_body", "--out", "o"),
            "--structure: found --model",
        ),
    ],
)
def test_what_does_not_fit_is_told_in_one_line_and_leaves_nothing(
    arguments: tuple[str, ...], message: str, strip: Path, program: Program
) -> None:
    done = program(*(str(strip) if argument == "{}" else argument for argument in arguments))
    assert done.status == 2 and message in done.err and done.err.count("\n") == 1
    assert [path.name for path in Path().iterdir()] == ["strip.csv"]
