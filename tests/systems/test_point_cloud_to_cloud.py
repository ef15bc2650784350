"""A camera's point cloud comes out as a cloud in the table frame, at the converter's own rate."""

import numpy as np
import pytest
from pydrake.common.value import AbstractValue
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.perception import BaseField, DepthImageToPointCloud, Fields, PointCloud
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantValueSource
from pydrake.systems.sensors import CameraInfo, ImageDepth32F

from mmt_drake.errors import BadInput
from mmt_drake.systems.point_cloud_to_cloud import PointCloudToCloud

POSE = RigidTransform(RollPitchYaw(np.pi, 0.0, 0.3), [0.1, -0.2, 0.6])


def camera_points(xyzs):
    cloud = PointCloud(xyzs.shape[1])
    cloud.mutable_xyzs()[:] = xyzs
    return cloud


def test_points_are_turned_into_the_table_frame_and_lost_pixels_counted():
    seen = np.random.default_rng(0).uniform(-0.1, 0.1, (3, 50)).astype(np.float32)
    seen[0, 4] = np.nan
    seen[2, [7, 9]] = np.inf
    converter = PointCloudToCloud(camera_pose=POSE)
    context = converter.CreateDefaultContext()
    converter.GetInputPort("camera_points").FixValue(context, AbstractValue.Make(camera_points(seen)))
    assert len(converter.GetOutputPort("point_cloud").Eval(context)) == 0
    context.SetTime(0.0)
    simulator = Simulator(converter, context)
    simulator.AdvanceTo(0.01)
    cloud = converter.GetOutputPort("point_cloud").Eval(context)
    kept = np.delete(seen, [4, 7, 9], axis=1).astype(float)
    np.testing.assert_allclose(cloud.points(), (POSE.rotation().matrix() @ kept).T + POSE.translation(), atol=1e-12)
    assert converter.GetOutputPort("dropped").Eval(context) == [3.0]


def test_it_builds_clouds_at_its_own_rate():
    source = ConstantValueSource(AbstractValue.Make(camera_points(np.zeros((3, 2), np.float32))))
    builder = DiagramBuilder()
    builder.AddSystem(source)
    converter = builder.AddSystem(PointCloudToCloud(period=0.1))
    builder.Connect(source.get_output_port(), converter.GetInputPort("camera_points"))
    simulator = Simulator(builder.Build())
    context = converter.GetMyContextFromRoot(simulator.get_context())
    stamps = []
    for k in range(1, 12):
        simulator.AdvanceTo(0.03 * k)
        stamps.append(converter.GetOutputPort("point_cloud").Eval(context).stamp)
    np.testing.assert_allclose(stamps, [0.1 * ((3 * k - 1) // 10) for k in range(1, 12)], atol=1e-9)


def test_a_depth_image_of_the_table_becomes_points_at_z_0():
    info = CameraInfo(width=64, height=48, fov_y=0.8)
    image = ImageDepth32F(64, 48)
    image.mutable_data[:] = 0.6  # looking straight down from 0.6 m
    image.mutable_data[0, 0] = np.inf
    builder = DiagramBuilder()
    source = builder.AddSystem(ConstantValueSource(AbstractValue.Make(image)))
    points = builder.AddSystem(DepthImageToPointCloud(info))
    converter = builder.AddSystem(PointCloudToCloud(camera_pose=POSE))
    builder.Connect(source.get_output_port(), points.GetInputPort("depth_image"))
    builder.Connect(points.GetOutputPort("point_cloud"), converter.GetInputPort("camera_points"))
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(0.01)
    context = converter.GetMyContextFromRoot(simulator.get_context())
    cloud = converter.GetOutputPort("point_cloud").Eval(context)
    assert len(cloud) == 64 * 48 - 1
    np.testing.assert_allclose(cloud.points()[:, 2], 0.0, atol=1e-7)


def test_what_has_no_positions_is_refused():
    converter = PointCloudToCloud()
    context = converter.CreateDefaultContext()
    colours = PointCloud(3, Fields(BaseField.kRGBs))
    converter.GetInputPort("camera_points").FixValue(context, AbstractValue.Make(colours))
    with pytest.raises(BadInput, match="xyzs"):
        Simulator(converter, context).AdvanceTo(0.01)
    with pytest.raises(BadInput):
        PointCloudToCloud(period=0.0)
