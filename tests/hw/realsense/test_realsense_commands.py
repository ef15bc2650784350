"""`python -m mmt_drake.hw.realsense` calibrates from a recording of the bare table and writes the cloud of another."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from realsense_samples import plane_depth, record, told

from mmt_drake.cloud import Cloud, ProxySettings
from mmt_drake.cloud.files import read_cloud, write_cloud
from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.diagrams.stations.station import build_station
from mmt_drake.hw.realsense.__main__ import main
from mmt_drake.hw.realsense.depth import Intrinsics
from mmt_drake.hw.realsense.extrinsics import Extrinsics
from mmt_drake.recording import Recording
from mmt_drake.surfaces import HeightField


def test_from_a_recording_of_the_table_to_a_cloud_in_its_frame(
    software: Any, small_camera: Intrinsics, tilted: Extrinsics, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table = record(software, tmp_path / "table.db3", [told(plane_depth(small_camera, tilted, -0.08))] * 3)
    place = str(tmp_path / "camera.yaml")
    foot = [str(value) for value in tilted.position[:2]]
    given = ["calibrate", "--recording", str(table), "--object-height", "0.08", "--heading", "20", "--out", place]
    assert main([*given, "--foot", *foot]) == 0
    assert "3 frames" in capsys.readouterr().out
    np.testing.assert_allclose(Extrinsics.read(place).position, tilted.position, atol=1e-4)
    # Told that the object is no higher than the table, the camera sees the table at z = 0.
    offsets = []
    for height in (0.0, 0.001):
        assert main([*given[:4], str(height), *given[5:], "--foot", *foot]) == 0
        seen = tmp_path / "table.ply"
        assert main(["cloud", "--recording", str(table), "--extrinsics", place, "--out", str(seen)]) == 0
        points = read_cloud(seen).points()
        assert len(points) > 100
        assert np.abs(points[:, 2] + height).max() < 2e-4
        said = capsys.readouterr().out
        assert " mm apart: from 5.7 mm on" in said, "few pixels, of which each voxel wants two"
        offsets.append(float(said.split("surface_offset=")[1]))
    assert 0.0 < offsets[0] < ProxySettings().r2
    assert offsets[0] - offsets[1] == pytest.approx(0.001, abs=1e-4)


def test_what_is_missing_is_one_line_and_status_2(
    realsense: Any, tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    missing = str(tmp_path / "none.db3")
    assert main(["calibrate", "--recording", missing, "--out", str(tmp_path / "x.yaml")]) == 2
    said = capsys.readouterr()
    assert said.err.count("\n") == 1
    assert "none.db3" in said.err
    assert not (tmp_path / "x.yaml").exists()


def test_touches_of_a_run_give_the_pose_of_the_camera_that_saw_its_object(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A hand presses an organ at 28 places; who calibrates has the recording, and a cloud by a wrong pose."""
    places = np.random.default_rng(0).uniform(-0.06, 0.06, (29, 2))
    time = 1e-3 * np.arange(28_000)
    part = np.clip(time % 1.0 * 2.0, 0.0, 1.0)[:, None]  # half a second's way in the air, then a press
    here = places[:-1].repeat(1000, axis=0) * (1.0 - part) + places[1:].repeat(1000, axis=0) * part
    height = np.where(time % 1.0 < 0.5, 0.003, 0.003 - 0.006 * np.sin(2.0 * np.pi * (time % 1.0 - 0.5)))
    hand = Recording(time, {"position_x": here[:, 0], "position_y": here[:, 1], "position_z": height}, "presses")
    recorded = tmp_path / "run.mcap"
    organ = load_scenario("setup1", ["environment.surface=!HeightField {}", "clouds=none"])
    build_station(organ, record=recorded, operator=hand).simulate(28.0)

    true = Extrinsics.from_matrix(np.diag([1.0, -1.0, -1.0]), [0.0, 0.0, 0.6])
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    said, place, top = (
        Extrinsics.from_matrix(turn @ true.rotation(), [0.01, 0.02, 0.6]),
        *(str(tmp_path / name) for name in ("camera.yaml", "organ.ply")),
    )
    said.write(place)
    seen = (HeightField().cloud(10_000).points() - true.position) @ true.rotation()
    write_cloud(Cloud(seen @ said.rotation().T + said.position), top)
    given = ["touch", str(recorded), "--extrinsics", place, "--out", place]
    assert main(given) == 2
    assert "found none, expected the cloud that the camera saw" in capsys.readouterr().err
    assert Extrinsics.read(place) == said
    assert main([*given, "--cloud", top, "--keep-level"]) == 0
    told = capsys.readouterr().out
    assert "28 touches, 0." in told and "\nheading: -" in told
    found = Extrinsics.read(place)
    np.testing.assert_allclose(found.position, true.position, atol=2e-3)
    np.testing.assert_allclose(found.rotation(), true.rotation(), atol=0.03)
