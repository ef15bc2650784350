"""`simulate`: the recording's clock and columns, the model's force."""

from pathlib import Path

import numpy as np
import pytest
from cli_samples import Program

from mmt_drake.diagnosis.diagnose import diagnose
from mmt_drake.model.driven_model import DrivenBodyModel
from mmt_drake.model_files import load_model
from mmt_drake.recording import Recording, load, save
from mmt_drake.simulation import simulate

SETUP1 = """\
structure: flexible_box
parameters: {m: 1.0, k1: 0.0, k2: 500.0, b1: 60.0, b2: 60.0}
normal: {k: 500.0, b: 60.0}
friction: per_axis
effects:
  - {name: static_friction, parameters: {Fs: 0.1, Fd: 0.05, v_d: 0.005}}
"""
TISSUE = "structure: kelvin_voigt\nparameters: {k: 300.0, b: 20.0, x0: 0.01, F0: 0.5}\n"


def model(folder: Path, text: str) -> Path:
    path = folder / "model.yaml"
    path.write_text(text)
    return path


def single_axis(folder: Path) -> tuple[Path, dict[str, np.ndarray]]:
    """One axis on an uneven clock, measured with an error of 0.1 N."""
    time = 7.0 + np.cumsum(np.random.default_rng(0).uniform(1e-3, 3e-3, 400))
    columns = {"time": time, "position": 0.01 + 0.005 * np.sin(9.0 * time), "velocity": 0.045 * np.cos(9.0 * time)}
    exact = 0.5 - 300.0 * (columns["position"] - 0.01) - 20.0 * columns["velocity"]
    columns["force"] = exact + 0.1
    rows = zip(*(values.tolist() for values in columns.values()), strict=True)
    path = folder / "in.csv"
    path.write_text("\n".join([",".join(columns), *(",".join(map(repr, row)) for row in rows)]) + "\n")
    return path, columns | {"exact": exact}


def test_header_and_times_are_the_recording_s_to_the_letter_and_force_is_the_model_s(
    tmp_path: Path, program: Program
) -> None:
    source, columns = single_axis(tmp_path)
    target = tmp_path / "out.csv"
    arguments = ["simulate", "--model", model(tmp_path, TISSUE), "--operator", source, "--out"]
    status, out, err = program(*arguments, target)
    assert (status, err) == (0, "")
    before, after = (path.read_text().splitlines() for path in (source, target))
    assert after[0] == before[0]
    assert [row.split(",")[:3] for row in after] == [row.split(",")[:3] for row in before]
    np.testing.assert_allclose(load(target)["force"], columns["exact"], rtol=0.0, atol=1e-12)
    # nrmse = RMS of 0.1 N over the standard deviation of what was measured
    assert f"nrmse in contact: force {0.1 / np.std(columns['force']):.4g}\n" in out
    assert out.startswith(f"{target}: 400 samples, ") and out.count("\n") == 1


def test_the_object_of_set_up_1_replayed_gives_the_force_that_was_recorded(tmp_path: Path, program: Program) -> None:
    recorded, simulated = tmp_path / "in.csv", tmp_path / "out.csv"
    assert program("run", "setup1", "--seconds", "8", "--record", recorded).status == 0
    arguments = ["simulate", "--model", model(tmp_path, SETUP1), "--operator", recorded, "--out", simulated]
    assert program(*arguments).status == 0
    a, b = load(recorded), load(simulated)
    assert list(a.columns) == list(b.columns)
    for axis in "xyz":
        assert np.abs(a[f"force_{axis}"]).max() > 0.5
        np.testing.assert_allclose(b[f"force_{axis}"], a[f"force_{axis}"], rtol=0.0, atol=1e-9)


def test_columns_that_a_reader_derives_stay_out_of_the_result(tmp_path: Path, program: Program) -> None:
    time = np.arange(300) * 1e-3
    source = tmp_path / "in.npz"
    np.savez(source, time=time, position_x=0.01 * np.sin(9.0 * time), position_y=0.0 * time,
             position_z=-0.001 + 0.0 * time, force_x=0.0 * time, force_y=0.0 * time, force_z=0.0 * time)  # fmt: skip
    target = tmp_path / "out.csv"
    arguments = ["simulate", "--model", model(tmp_path, SETUP1), "--operator", source, "--out", target]
    assert program(*arguments).status == 0
    assert target.read_text().partition("\n")[0] == ("time,position_x,position_y,position_z,force_x,force_y,force_z")


def test_a_hand_without_forces_gets_them_and_no_error_is_told(tmp_path: Path, program: Program) -> None:
    time = np.arange(300) * 1e-3
    source = tmp_path / "hand.npz"
    np.savez(source, time=time, position_x=0.01 * np.sin(9.0 * time), position_y=0.0 * time, position_z=-0.002 - time)
    target = tmp_path / "out.npz"
    arguments = ["simulate", "--model", model(tmp_path, SETUP1), "--operator", source, "--out", target]
    status, out, _ = program(*arguments)
    assert status == 0 and "nrmse" not in out
    # F_z = -k z - b v_z with v_z = -1 m/s
    np.testing.assert_allclose(load(target)["force_z"], 500.0 * (0.002 + time) + 60.0, rtol=1e-6)


def test_over_windows_the_error_is_the_one_that_a_diagnosis_states(tmp_path: Path, program: Program) -> None:
    time, random = np.arange(0.0, 40.0, 1e-2), np.random.default_rng(1)
    force = 3.0 * np.sin(4.4 * time) + 2.0 * np.sin(1.9 * time + 1.0)
    hidden = Recording(time, {"input": force + 0.2, "output": 0.0 * time}, "carriage")
    output = simulate(DrivenBodyModel(m=2.0, b=4.0), hidden)["output"] + 1e-4 * random.standard_normal(len(time))
    noisy = {"input": force + 0.3 * random.standard_normal(len(time)), "output": output}
    source = tmp_path / "in.csv"
    save(Recording(time, noisy, "carriage"), source)
    believed = model(tmp_path, "structure: driven_body\nparameters: {m: 2.0, b: 4.0}\n")
    fit = diagnose([load(source)], load_model(believed), library={}).diagnosis.fit
    assert fit is not None and fit.window_s is not None and 1.0 < fit.window_s < 10.0
    simulated = tmp_path / "out.csv"
    assert program("simulate", "--model", believed, "--windows", source, "--out", simulated).status == 0
    counts = np.any([(first <= time) & (time <= last) for first, last in fit.heldout_s], axis=0)
    error = np.sqrt(np.mean((load(simulated)["output"] - output)[counts] ** 2)) / np.std(output[counts])
    assert error == pytest.approx(fit.heldout_nrmse.nominal, rel=1e-9)
