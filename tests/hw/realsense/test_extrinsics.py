"""A camera's place: through a file unchanged, and found again from a cloud of the bare table."""

import math
from pathlib import Path

import numpy as np
import pytest
from realsense_samples import plane_depth
from scipy.spatial.transform import Rotation

from mmt_drake.errors import BadInput
from mmt_drake.hw.realsense.depth import Intrinsics
from mmt_drake.hw.realsense.extrinsics import Extrinsics, calibrate_on_table


def test_a_file_gives_back_what_was_written(tilted: Extrinsics, tmp_path: Path) -> None:
    tilted.write(tmp_path / "camera.yaml")
    assert Extrinsics.read(tmp_path / "camera.yaml") == tilted


def test_the_rotation_is_that_of_its_quaternion(tilted: Extrinsics) -> None:
    w, x, y, z = tilted.quaternion
    np.testing.assert_allclose(tilted.rotation(), Rotation.from_quat([x, y, z, w]).as_matrix(), atol=1e-12)


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("position: [0, 0, 1]", "quaternion"),
        ("position: [0, 0]\nquaternion: [1, 0, 0, 0]", "position"),
        ("position: [0, 0, 1]\nquaternion: [0, 0, 0, 0]", "quaternion"),
        ("position: [0, 0, 1]\nquaternion: [1, 0, 0, 0]\nangle: 3", "angle"),
    ],
)
def test_a_broken_file_is_refused_in_one_line_that_names_the_key(text: str, named: str, tmp_path: Path) -> None:
    (tmp_path / "camera.yaml").write_text(text)
    with pytest.raises(BadInput, match=named) as refused:
        Extrinsics.read(tmp_path / "camera.yaml")
    assert "\n" not in str(refused.value)


def test_height_and_tilt_are_found_among_noise_clutter_and_holes(small_camera: Intrinsics, tilted: Extrinsics) -> None:
    random = np.random.default_rng(3)
    depth = plane_depth(small_camera, tilted, -0.08) + 1e-3 * random.standard_normal((120, 160))
    depth[30:70, 20:70] -= 0.06  # something stands on the table
    points = (small_camera.rays() * depth[..., None]).reshape(-1, 3)
    points[::17] = math.nan
    heading = math.radians(20.0)
    found = calibrate_on_table(points, object_height=0.08, foot=tilted.position[:2], heading=heading)
    np.testing.assert_allclose(found.extrinsics.position, tilted.position, atol=1e-4)
    apart = Rotation.from_matrix(found.extrinsics.rotation().T @ tilted.rotation()).magnitude()
    assert math.degrees(apart) < 0.05
    assert found.residual == pytest.approx(1e-3 * math.cos(math.radians(25.0)), rel=0.1)
    assert 0.85 < found.share < 0.95


def test_what_is_no_bare_table_is_refused(small_camera: Intrinsics, tilted: Extrinsics) -> None:
    random = np.random.default_rng(0)
    with pytest.raises(BadInput, match="a bare table"):
        calibrate_on_table(random.uniform(0.3, 1.0, (3000, 3)))
    with pytest.raises(BadInput, match="100 or more"):
        calibrate_on_table(np.full((500, 3), math.nan))
    steep = np.column_stack([random.uniform(-1, 1, (2, 1000)).T, np.zeros(1000)])[:, [0, 2, 1]] + [0.0, 0.1, 2.0]
    with pytest.raises(BadInput, match="tilt"):
        calibrate_on_table(steep)
