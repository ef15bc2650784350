"""A camera's pose from touches of what it sees: found where the shape tells it, and not where it does not."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mmt_drake.cloud import Cloud
from mmt_drake.errors import BadInput
from mmt_drake.hw.realsense.by_touch import TouchCalibration, calibrate_by_touch
from mmt_drake.hw.realsense.extrinsics import Extrinsics
from mmt_drake.surfaces import Cylinder, HeightField, Plane, Shape, Sphere

TRUE = Extrinsics.from_matrix(Rotation.from_euler("ZX", [20, 205], degrees=True).as_matrix(), [0.1, 0.05, 0.5])
SAID_WRONG = (0.012, -0.009, 0.004)  # [m]


def touched(
    shape: Shape,
    *,
    heading: float = 12.0,
    tilt: float = 1.5,
    shift: tuple[float, float, float] = SAID_WRONG,
    n: int = 24,
    tip_radius: float = 0.0,
    keep_level: bool = False,
    seed: int = 0,
) -> TouchCalibration:
    """Calibrate a camera that is said to be elsewhere, on n touches (0.1 mm) and a cloud (0.3 mm) of a shape."""
    rng = np.random.default_rng(seed)
    if keep_level:
        tilt, shift = 0.0, (*shift[:2], 0.0)
    error = Rotation.from_euler("ZYX", [heading, tilt, -tilt], degrees=True).as_matrix()
    said = Extrinsics.from_matrix(error @ TRUE.rotation(), error @ np.array(TRUE.position) + shift)
    seen = shape.cloud(8000, (0.2, 0.2)).points()
    seen = (seen + 3e-4 * rng.standard_normal(seen.shape) - TRUE.position) @ TRUE.rotation()
    on_it = Cloud(shape.points(rng.uniform(-0.05, 0.05, (n, 2)))).with_normals()
    normals = shape.cloud(8000, (0.2, 0.2))
    tip = on_it.points() + 1e-4 * rng.standard_normal((n, 3))
    if tip_radius:  # along the true normal, of the nearest of many points
        from scipy.spatial import cKDTree

        assert normals.normals is not None
        tip += tip_radius * normals.normals[cKDTree(normals.points()).query(tip)[1]]
    cloud = Cloud(seen @ said.rotation().T + said.position)
    return calibrate_by_touch(cloud, tip, said, tip_radius=tip_radius, keep_level=keep_level)


def turned_by(found: TouchCalibration) -> float:
    """From the true pose [deg]."""
    return math.degrees(Rotation.from_matrix(found.extrinsics.rotation().T @ TRUE.rotation()).magnitude())


def off_by(found: TouchCalibration, point: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> float:
    """How far from itself the pose shows a point of the table frame [m]."""
    seen = (np.array(point) - TRUE.position) @ TRUE.rotation()
    return float(np.linalg.norm(found.extrinsics.rotation() @ seen + found.extrinsics.position - point))


def told(found: TouchCalibration) -> set[str]:
    return {coordinate.name for coordinate in found.coordinates if coordinate.told}


@pytest.mark.parametrize("heading", [12.0, 150.0])
def test_the_whole_pose_is_found_on_a_shape_that_determines_it(heading: float) -> None:
    found = touched(HeightField(), heading=heading, shift=(0.05, -0.03, 0.004))
    assert told(found) == {"heading", "tilt about y", "tilt about x", "x", "y", "z"}
    assert found.kept == () and found.others == ()
    assert turned_by(found) < 1.5
    assert off_by(found) < 1e-3
    assert found.residual < 4e-4


def test_intervals_hold_the_truth() -> None:
    held = list[bool]()
    for seed in range(4):
        found = touched(HeightField(), keep_level=True, seed=seed, n=30)
        heading = found.coordinates[0]
        held.append(abs(heading.change + 12.0) <= heading.half)
        assert heading.half < 3.0
    assert sum(held) >= 3


def test_a_plane_tells_height_and_tilt_and_neither_heading_nor_foot() -> None:
    found = touched(Plane())
    assert told(found) == {"tilt about y", "tilt about x", "z"}
    assert sorted(move.split(" (")[0] for move in found.kept) == ["a shift along", "a shift along", "a turn about"]
    heading, _, _, x, y, _ = found.coordinates
    assert heading.change == pytest.approx(0.0, abs=0.5), "as it was said"
    # What the tilt's correction carries along, and no more.
    assert max(abs(x.change), abs(y.change)) < 1.0
    up = found.extrinsics.rotation().T @ [0.0, 0.0, 1.0]
    assert np.degrees(np.arccos(up @ (TRUE.rotation().T @ [0.0, 0.0, 1.0]))) < 0.4


def test_a_plane_tells_nothing_where_height_and_tilt_are_kept() -> None:
    found = touched(Plane(), keep_level=True)
    assert len(found.coordinates) == 3 and told(found) == set()
    assert len(found.kept) == 3


def test_a_ball_tells_the_foot_and_no_turn_about_its_centre() -> None:
    found = touched(Sphere(), keep_level=True)
    assert told(found) == {"x", "y"}
    (turn,) = found.kept
    assert turn.startswith("a turn about (0.00, 0.00, ")
    assert off_by(found, (0.0, 0.0, 0.0)) < 1e-3
    assert len(touched(Sphere()).kept) == 3


def test_a_cylinder_tells_its_heading_and_no_shift_along_itself() -> None:
    found = touched(Cylinder(turned=30.0), keep_level=True)
    assert "heading" in told(found)
    assert found.coordinates[0].change == pytest.approx(-12.0, abs=1.5)
    (shift,) = found.kept
    along = np.array([float(part) for part in shift.partition("(")[2].rstrip(")").split(",")])
    assert abs(along @ [-0.5, math.sqrt(0.75), 0.0]) > 0.999


def test_the_radius_of_the_tip_is_taken_off() -> None:
    found = touched(HeightField(), tip_radius=0.003)
    assert off_by(found) < 1e-3
    assert off_by(touched(HeightField(), tip_radius=0.003, keep_level=True)) < 1e-3


def test_what_tells_nothing_is_refused_in_one_line() -> None:
    cloud, rng = Plane().cloud(1000), np.random.default_rng(0)
    tip = np.column_stack([rng.uniform(-0.05, 0.05, (20, 2)), np.zeros(20)])
    for given, on, named in (
        (tip[:5], cloud, "found 5, expected 12 or more"),
        (tip[:, :2], cloud, "shape"),
        (np.full((20, 3), math.nan), cloud, "finite"),
        (0.1 * tip, cloud, "touch all over the object"),
        (tip, Cloud(np.zeros((3, 3))), "3 points"),
        (tip + 0.02 * rng.standard_normal(tip.shape), cloud, "which has not moved"),
    ):
        with pytest.raises(BadInput, match=named) as refused:
            calibrate_by_touch(on, given, TRUE)
        assert "\n" not in str(refused.value)
    with pytest.raises(BadInput, match="tip radius"):
        calibrate_by_touch(cloud, tip, TRUE, tip_radius=-1.0)


def test_a_report_says_what_is_told_and_what_is_not() -> None:
    said = touched(Plane()).lines()
    assert said[0].startswith("24 touches, 0.")
    assert any(line.startswith("z: ") and "within" in line for line in said)
    assert "heading: not told by these touches" in said
    assert sum(line.startswith("cannot be told, and stays as it was said: ") for line in said) == 3
