"""`python -m mmt_drake.hw.realsense` calibrates from a recording of the bare table and writes the cloud of another."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from realsense_samples import plane_depth, record, told

from mmt_drake.cloud import ProxySettings
from mmt_drake.cloud.files import read_cloud
from mmt_drake.hw.realsense.__main__ import main
from mmt_drake.hw.realsense.depth import Intrinsics
from mmt_drake.hw.realsense.extrinsics import Extrinsics


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
