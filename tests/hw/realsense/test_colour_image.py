"""Colours of points in a picture that was taken beside a depth image."""

import numpy as np
import pytest

from mmt_drake.cloud.colour import cielab
from mmt_drake.cloud.seen import SeenScene
from mmt_drake.cloud.tracking import tracked
from mmt_drake.cloud.tracking_options import Tracking
from mmt_drake.hw.realsense.colour import ColourImage
from mmt_drake.hw.realsense.depth import DepthToCloud, Intrinsics
from mmt_drake.hw.realsense.noise import DepthNoise
from mmt_drake.hw.realsense.rendered import RenderedScene
from mmt_drake.hw.realsense.settings import CloudSettings
from mmt_drake.hw.realsense.simulated import SimulatedFrame
from mmt_drake.hw.realsense.view import Solid, TableScene, View

CAMERA = Intrinsics(4, 3, 100.0, 100.0, 1.5, 1.0)
PIXELS = np.arange(36, dtype=np.uint8).reshape(3, 4, 3)
VIEW = View(focal=360.0, width=240, height=0.75, tilt=0.0)
SETTINGS = CloudSettings(low=(-0.3, -0.2, -0.08), high=(0.3, 0.2, 0.03), voxel=0.005)


def test_a_point_has_the_colour_of_the_pixel_that_it_is_seen_at_and_none_beyond_the_picture() -> None:
    image = ColourImage(PIXELS, CAMERA)
    seen = CAMERA.rays()[1, 2] * 0.7  # the middle of that pixel's ray
    points = np.array([seen, seen * [-10.0, 1.0, 1.0], -seen])
    found = image.at(points)
    np.testing.assert_array_equal(found[0], PIXELS[1, 2] / 255.0)
    assert np.isnan(found[1:]).all()
    assert image.at(np.zeros((0, 3))).shape == (0, 3)


def test_a_camera_that_stands_beside_that_of_depth_sees_a_point_where_it_is_for_it() -> None:
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # a quarter about the optical axis
    beside = ColourImage(PIXELS, CAMERA, turn, np.array([0.015, 0.0, 0.0]))
    seen = CAMERA.rays()[0, 3] * 0.5
    point = turn.T @ (seen - [0.015, 0.0, 0.0])
    np.testing.assert_array_equal(beside.at(point[None])[0], PIXELS[0, 3] / 255.0)


def test_what_a_simulated_camera_sees_of_two_things_is_their_colours() -> None:
    red, blue = (0.7, 0.1, 0.1), (0.1, 0.2, 0.8)
    solids = (Solid((0.08, 0.08, 0.05), (-0.1, 0.0), colour=red), Solid((0.08, 0.08, 0.05), (0.1, 0.0), colour=blue))
    where = VIEW.extrinsics((0.0, 0.0))
    seen = RenderedScene(VIEW.intrinsics(), where, TableScene(solids, -0.05, probe=0.005))
    convert = DepthToCloud(VIEW.intrinsics(), where, SETTINGS)
    frame = SimulatedFrame(seen, (), DepthNoise.stereo(VIEW.focal), 0, 15)
    cloud, _, _ = convert(frame.depth, frame.unit, 0.0, None, frame.colour)
    scene = tracked(SeenScene(), cloud, np.array([0.0, 0.0, 1.0]), 0.0, -0.05, Tracking())
    left, right = scene.things
    assert left.colour == pytest.approx(tuple(cielab(np.array(red))), abs=1.0)
    assert right.colour == pytest.approx(tuple(cielab(np.array(blue))), abs=1.0)


def test_one_frame_in_so_many_is_in_colour() -> None:
    seen = RenderedScene(VIEW.intrinsics(), VIEW.extrinsics((0.0, 0.0)))
    frames = [SimulatedFrame(seen, (), DepthNoise(), number, 15) for number in range(31)]
    assert [frame.number for frame in frames if frame.colour is not None] == [0, 15, 30]
