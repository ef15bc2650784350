"""A transmission from its file and a table of numbers to what the commands say of it."""

import json
from pathlib import Path

import numpy as np
import pytest
from cli_samples import Program

from mmt_drake.recording import load

TIME = np.arange(2000) * 2e-3
INPUT = 0.3 * (np.cos(1.7 * TIME) - 1.0) + 0.2 * np.sin(4.1 * TIME)
MODEL = "structure: transmission\nparameters: {ratio: -0.5, offset: 0.2}\nunits: {position: rad, force: N m}\n"


def table(folder: Path, **columns: np.ndarray) -> Path:
    path, columns = folder / "gears.csv", {"time": TIME, **columns}
    np.savetxt(path, np.column_stack(list(columns.values())), delimiter=",", header=",".join(columns), comments="")
    return path


def file(folder: Path, text: str = MODEL) -> Path:
    path = folder / "model.yaml"
    path.write_text(text)
    return path


def test_simulate_answers_with_the_output_half_the_gap_behind(tmp_path: Path, program: Program) -> None:
    text = MODEL + "effects: [{name: gear_play, parameters: {gap: 0.04}}]\n"
    recorded, target = table(tmp_path, input=INPUT, output=0.0 * TIME + 0.2), tmp_path / "out.csv"
    arguments = ["simulate", "--model", file(tmp_path, text), "--operator", recorded, "--out", target]
    assert program(*arguments).status == 0
    x, place = 0.2, 0.2 - 0.5 * INPUT
    for simulated, at in zip(load(target)["output"], place, strict=True):
        x = min(max(x, at - 0.02), at + 0.02)
        assert simulated == pytest.approx(x, abs=1e-9)


def test_diagnose_finds_the_zero_of_the_other_encoder_and_nothing_else(tmp_path: Path, program: Program) -> None:
    output = 0.23 - 0.5 * INPUT + 1e-4 * np.random.default_rng(2).standard_normal(len(TIME))
    out = tmp_path / "out"
    recorded = table(tmp_path, input=INPUT, output=output)
    assert program("diagnose", recorded, "--model", file(tmp_path), "--out", out).status == 0
    said = json.loads((out / "diagnosis.json").read_text())
    assert said["verdict"] == "parameters" and said["effects"] == []
    assert set(said["parameters"]) == {"offset"} and said["parameters"]["offset"]["unit"] == "rad"
    assert said["parameters"]["offset"]["value"] == pytest.approx(0.23, abs=1e-4)


@pytest.mark.parametrize("command", ["simulate", "diagnose"])
@pytest.mark.parametrize(
    ("columns", "parameters", "line"),
    [
        (
            ("input", "output"),
            "{ratio: -0.5, load: 1.0}",
            "gears.csv: columns: found input, output, expected the column",
        ),
        (("position", "force"), "{ratio: -0.5}", "time, input, output"),
        (("input", "output"), "{ratio: 0}", "model.yaml: parameters.ratio: found 0, expected a number other than 0"),
    ],
)
def test_what_does_not_belong_together_is_refused_in_one_line(
    tmp_path: Path, program: Program, command: str, columns: tuple[str, str], parameters: str, line: str
) -> None:
    recorded = table(tmp_path, **dict.fromkeys(columns, INPUT))
    model, out = file(tmp_path, f"structure: transmission\nparameters: {parameters}\n"), tmp_path / "out.csv"
    given = [recorded] if command == "diagnose" else ["--operator", recorded]
    status, printed, said = program(command, *given, "--model", model, "--out", out)
    assert (status, printed) == (2, "") and said.count("\n") == 1 and line in said
    assert not out.exists()
