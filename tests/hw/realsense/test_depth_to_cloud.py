"""A depth image becomes the points of the table frame that a ray meets, cropped, filtered, averaged."""

from dataclasses import replace

import numpy as np
import pytest
from realsense_samples import UNIT, plane_depth, told

from mmt_drake.errors import BadInput
from mmt_drake.hw.realsense.depth import DepthToCloud, Intrinsics
from mmt_drake.hw.realsense.extrinsics import Extrinsics
from mmt_drake.hw.realsense.settings import CloudSettings

OPEN = CloudSettings(edge=None, voxel=None, low=(-1.0, -1.0, -0.05), high=(1.0, 1.0, 0.05))


def test_a_plane_seen_at_an_angle_comes_out_flat_at_its_height(small_camera: Intrinsics, tilted: Extrinsics) -> None:
    depth = plane_depth(small_camera, tilted, 0.012)
    cloud, lost, _ = DepthToCloud(small_camera, tilted, OPEN)(told(depth), UNIT, 2.5)
    assert lost == 0.0
    assert cloud.stamp == 2.5
    assert len(cloud) == depth.size
    assert np.abs(cloud.points()[:, 2] - 0.012).max() <= 0.5 * UNIT * 1.25  # how much a ray falls in a unit of depth


def test_every_pixel_is_the_point_that_the_pinhole_model_says(small_camera: Intrinsics, tilted: Extrinsics) -> None:
    depth = np.zeros((120, 160), np.uint16)
    depth[17, 101] = 4321
    convert = DepthToCloud(small_camera, tilted, replace(OPEN, low=(-2.0,) * 3, high=(2.0,) * 3))
    cloud, lost, _ = convert(depth, UNIT)
    z = 0.4321
    optical = np.array([(101 - 79.5) / 150.0 * z, (17 - 59.5) / 150.0 * z, z])
    np.testing.assert_allclose(cloud.points(), [tilted.rotation() @ optical + tilted.position], atol=1e-12)
    assert lost == pytest.approx(1.0 - 1.0 / depth.size)


def test_only_what_is_in_the_box_and_in_range_is_kept(small_camera: Intrinsics) -> None:
    above = Extrinsics((0.0, 0.0, 0.4), (0.0, 1.0, 0.0, 0.0))
    depth = told(plane_depth(small_camera, above))
    cropped = replace(OPEN, low=(-0.05, -0.02, -0.01), high=(0.03, 0.04, 0.01))
    points = DepthToCloud(small_camera, above, cropped)(depth, UNIT).cloud.points()
    assert np.all((points >= cropped.low) & (points < cropped.high))
    everything = DepthToCloud(small_camera, above, OPEN)(depth, UNIT).cloud.points()
    inside = np.all((everything >= cropped.low) & (everything < cropped.high), axis=1)
    assert 0 < len(points) == inside.sum() < len(everything)
    assert len(DepthToCloud(small_camera, above, replace(OPEN, near=0.41))(depth, UNIT).cloud) == 0


def test_flying_pixels_at_an_edge_are_dropped_and_a_slope_is_not(small_camera: Intrinsics, tilted: Extrinsics) -> None:
    depth = plane_depth(small_camera, tilted)
    depth[:, :80] += 0.04  # a step
    depth[40:60, 80] = depth[40:60, 81] + 0.017  # between the two
    filtered = DepthToCloud(small_camera, tilted, replace(OPEN, edge=0.01))
    points = filtered(told(depth), UNIT).cloud.points()
    assert len(points) >= depth.size - 3 * 120
    flying = DepthToCloud(small_camera, tilted, OPEN)(told(depth), UNIT).cloud.points()
    assert np.any((flying[:, 2] < -0.005) & (flying[:, 2] > -0.025))
    assert not np.any((points[:, 2] < -0.005) & (points[:, 2] > -0.025))


def test_voxels_hold_the_mean_of_their_points_and_one_is_centred_on_the_origin(
    small_camera: Intrinsics, tilted: Extrinsics
) -> None:
    random = np.random.default_rng(1)
    depth = told(plane_depth(small_camera, tilted) + 4e-4 * random.standard_normal((120, 160)))
    every = DepthToCloud(small_camera, tilted, OPEN)(depth, UNIT).cloud.points()
    voxel, support = 0.006, 3
    found = DepthToCloud(small_camera, tilted, replace(OPEN, voxel=voxel, support=support))(depth, UNIT).cloud.points()
    keys, owner, count = np.unique(np.round(every / voxel), axis=0, return_inverse=True, return_counts=True)
    means = np.stack([np.bincount(owner.ravel(), every[:, k]) / count for k in range(3)], axis=1)[count >= support]
    np.testing.assert_allclose(found, means, atol=1e-12)  # both in the order of the cubes
    assert set(keys[:, 2]) == {0.0}, "the surface lies in one layer"


def test_another_image_than_the_camera_s_is_refused(small_camera: Intrinsics, tilted: Extrinsics) -> None:
    convert = DepthToCloud(small_camera, tilted)
    with pytest.raises(BadInput, match=r"expected \(120, 160\) of uint16"):
        convert(np.zeros((60, 80), np.uint16), UNIT)


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"low": (0.3, 0.0, 0.0)}, "low, high of x"),
        ({"near": 0.0}, "near, far"),
        ({"edge": -1.0}, "edge"),
        ({"voxel": 1e-5}, "cubes at most"),
        ({"support": 0}, "support"),
    ],
)
def test_settings_without_meaning_are_refused_by_name(changes: dict, named: str) -> None:
    with pytest.raises(BadInput, match=named):
        CloudSettings(**changes)
