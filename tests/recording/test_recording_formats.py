"""Recordings survive every format that is written, and CSV reads as the contract's examples are."""

import os
from pathlib import Path

import numpy as np
import pytest
from samples import contact, same
from table_samples import csv_text, good

from mmt_drake.cli.convert import convert
from mmt_drake.errors import BadInput
from mmt_drake.model.parameters import TANGENTIAL_THETA, THETA
from mmt_drake.model.scene_layout import COLOUR
from mmt_drake.recording import Recording, load, save

CLOCK = {".csv": 0.0, ".npz": 0.0, ".mcap": 0.6e-9}  # mcap keeps whole nanoseconds


@pytest.mark.parametrize("ending", CLOCK)
def test_every_column_of_the_conventions_survives_bit_by_bit(ending: str, tmp_path: Path) -> None:
    recording = contact()
    save(recording, tmp_path / f"a{ending}")
    same(recording, load(tmp_path / f"a{ending}"), clock=CLOCK[ending])


@pytest.mark.parametrize("ending", CLOCK)
@pytest.mark.parametrize(
    ("kind", "names"),
    [
        ("single_axis", ("position", "force", "velocity", "in_contact")),
        ("driven_body", ("input", "output", "output_rate", "load")),
    ],
)
def test_one_axis_and_driven_bodies_survive_too(kind: str, names: tuple[str, ...], ending: str, tmp_path: Path) -> None:
    time = np.cumsum(np.random.default_rng(3).uniform(5e-4, 3e-3, 4000))  # an uneven clock over several chunks
    columns = {name: np.sin(time + i) for i, name in enumerate(names)}
    columns.update({name: np.cos(time) for name in ("velocity", "output_rate") if name in columns})
    columns.update({"in_contact": (time > 1.0).astype(float)} if "in_contact" in names else {})
    save(Recording(time, columns), tmp_path / f"a{ending}")
    read = load(tmp_path / f"a{ending}")
    assert read.kind == kind
    same(Recording(time, columns), read, clock=CLOCK[ending])


def test_theta_without_the_normal_axis_stays_six_numbers(tmp_path: Path) -> None:
    whole = contact()
    left_out = {f"theta_{name}" for name in THETA if name not in TANGENTIAL_THETA}
    columns = {name: values for name, values in whole.columns.items() if name not in left_out}
    save(Recording(whole.time, columns), tmp_path / "a.mcap")
    assert set(load(tmp_path / "a.mcap").columns) == set(columns)


@pytest.mark.parametrize("ending", [".npz", ".mcap", ".csv"])
def test_a_scene_may_be_without_colours_as_before_they_were_told_or_have_unknown_ones(
    ending: str, tmp_path: Path
) -> None:
    whole = contact()
    coloured = {name: values for name, values in whole.columns.items() if name.endswith(COLOUR)}
    plain = {name: values for name, values in whole.columns.items() if name not in coloured}
    save(Recording(whole.time, plain), tmp_path / f"plain{ending}")
    assert set(load(tmp_path / f"plain{ending}").columns) == set(plain)
    unknown = plain | {name: np.full(len(whole.time), np.nan) for name in coloured}
    save(Recording(whole.time, unknown), tmp_path / f"unknown{ending}")
    assert np.isnan(load(tmp_path / f"unknown{ending}")["scene_1_lightness"]).all()


@pytest.mark.parametrize("ending", [".npz", ".mcap"])
def test_clouds_and_constants_survive(ending: str, tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    clouds = tuple((0.25 * i, rng.normal(size=(20 + i, 3)).astype(np.float32)) for i in range(4))
    whole = contact()
    recording = Recording(whole.time, whole.columns, clouds=clouds, constants={"mass_kg": 0.1, "radius_m": 1 / 3})
    save(recording, tmp_path / f"a{ending}")
    read = load(tmp_path / f"a{ending}")
    assert read.constants == recording.constants
    assert [time for time, _ in read.clouds] == pytest.approx([time for time, _ in clouds], abs=1e-9)
    for (_, points), (_, expected) in zip(read.clouds, clouds, strict=True):
        np.testing.assert_array_equal(points, expected)


def test_a_chain_of_conversions_ends_where_it_began(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(csv_text(good()))
    for source, target in [("a.csv", "b.mcap"), ("b.mcap", "c.npz"), ("c.npz", "d.csv")]:
        summary = convert(str(tmp_path / source), str(tmp_path / target), {})
        assert "50 samples" in summary
    same(load(tmp_path / "a.csv"), load(tmp_path / "d.csv"), clock=1e-9)


def test_conversion_says_what_csv_cannot_keep(tmp_path: Path) -> None:
    whole = contact(0.1)
    cloud = (0.0, np.zeros((3, 3), dtype=np.float32))
    save(Recording(whole.time, whole.columns, clouds=(cloud,), constants={"mass_kg": 0.1}), tmp_path / "a.npz")
    assert "not in CSV: 1 point clouds, mass_kg = 0.1" in convert(str(tmp_path / "a.npz"), str(tmp_path / "a.csv"), {})


@pytest.mark.parametrize("name", ["clean", "coulomb_hidden"])
def test_the_contract_s_examples_read_as_numpy_reads_them(name: str, recordings: Path) -> None:
    path = recordings.parent / "examples" / f"{name}.csv"
    if not path.exists():
        pytest.skip("no examples beside the recordings")
    expected = np.genfromtxt(path, delimiter=",", names=True)
    read = load(path)
    assert read.kind == "contact" and not read.notes  # nothing had to be derived
    np.testing.assert_array_equal(read.time, expected["time"])
    for column in read.columns:
        np.testing.assert_array_equal(read[column], expected[column])


@pytest.mark.parametrize("text", ["\ufeff{}", "{}\n\n", " {}"])
def test_csv_from_other_programs_reads_the_same(text: str, tmp_path: Path) -> None:
    plain = csv_text(good())
    (tmp_path / "a.csv").write_text(plain)
    (tmp_path / "b.csv").write_text(text.format(plain).replace("\n", "\r\n"), encoding="utf-8")
    same(load(tmp_path / "a.csv"), load(tmp_path / "b.csv"))


def test_missing_optional_columns_are_derived_and_told(tmp_path: Path) -> None:
    rows = good()
    (tmp_path / "a.csv").write_text(csv_text(rows))
    read = load(tmp_path / "a.csv")
    np.testing.assert_array_equal(read["in_contact"], (rows["position_z"] < 0).astype(float))
    exact = 0.05 * np.cos(5.0 * rows["time"])
    assert np.abs(read["velocity_x"] - exact).max() < 2e-2 * 0.05
    assert any("in_contact" in note for note in read.notes) and any("velocity_x" in note for note in read.notes)


def test_an_operator_s_motion_needs_no_force_where_it_is_asked_for_as_one(tmp_path: Path) -> None:
    rows = {name: values for name, values in good().items() if not name.startswith("force")}
    (tmp_path / "a.csv").write_text(csv_text(rows))
    assert load(tmp_path / "a.csv", forces=False).kind == "motion"
    with pytest.raises(BadInput, match="force_x, force_y, force_z"):
        load(tmp_path / "a.csv")


def test_saving_fails_without_leaving_or_touching_anything(tmp_path: Path) -> None:
    target = tmp_path / "a.mcap"
    target.write_text("older")
    bad = Recording(np.array([0.0, 1e-12, 1.0]), {"input": np.zeros(3), "output": np.zeros(3)})
    with pytest.raises(BadInput, match=r"a\.mcap: row 2"):
        save(bad, target)
    assert target.read_text() == "older" and os.listdir(tmp_path) == ["a.mcap"]


def test_a_force_that_was_rendered_from_a_poor_estimate_is_read_whatever_its_size(tmp_path):
    time = np.arange(20) * 1e-3
    zero = np.zeros(20)
    columns = {f"{name}_{axis}": zero for name in ("position", "force", "rendered_force") for axis in "xyz"}
    columns["rendered_force_y"] = np.linspace(0.0, 1e5, 20)
    save(Recording(time, columns), tmp_path / "out.mcap")
    np.testing.assert_array_equal(load(tmp_path / "out.mcap")["rendered_force_y"], columns["rendered_force_y"])
