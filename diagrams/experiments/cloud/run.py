"""One rendered scene, seen by many cameras at once, each with a detector of its own."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import Demultiplexer, LogVectorOutput

from diagrams.experiments.cloud.plan import Plan
from diagrams.experiments.cloud.score import Score, score
from hw.realsense.depth import DepthToCloud
from hw.realsense.extrinsics import Calibration, calibrate_on_table
from hw.realsense.noise import DepthNoise
from hw.realsense.offset import measured_offset
from hw.realsense.settings import CloudSettings
from hw.realsense.simulated import SimulatedDepthCamera, SimulatedFrames, perfect_depth, rendered_scene
from mmt_drake.cloud import Cloud, ProxySettings
from mmt_drake.errors import BadInput
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.systems.contact_detector import ContactDetector
from mmt_drake.systems.flexible_box import FlexibleBox
from mmt_drake.systems.scripted_operator import ScriptedOperator

Array = NDArray[np.float64]

_STEP = 1e-3
_FIRST_UNTOUCHED_FRAME = 500_000  # like the next, a number that no run reaches
_CALIBRATION_FRAMES, _FIRST_CALIBRATION_FRAME = 8, 1_000_000  # frames that no run reaches
_MARGIN = 0.01  # of the object's rim, where a surface is hard to tell from its edge [m]
_CHECKED_EVERY = 0.5  # [s] between two calls of `progress`


@dataclass(frozen=True)
class Case:
    """One camera and its detector.

    Attributes:
        noise: in parts of a stereo camera's.
        voxel: edge of the voxel filter [m].
        points: of the object's cloud.
        spacing: between its points [m].
        height: of the measured above the true top, mean [m]: the calibration's error.
        roughness: standard deviation of the points' heights [m].
        offset: how much lower the detector takes the cloud [m], as measured on the untouched object.
        score: what it did.
    """

    noise: float
    voxel: float
    points: int
    spacing: float
    height: float
    roughness: float
    offset: float
    score: Score


@dataclass(frozen=True)
class Result:
    """What came of a plan: one case for each noise and voxel, in the plan's order."""

    plan: Plan
    seconds: float
    cases: tuple[Case, ...]


def run(plan: Plan, progress: Callable[[float], None] | None = None) -> Result:
    """Carry out a plan.

    Every camera is first calibrated on the bare table through its own noise, and its detector is given the offset that
    was measured on a few frames of the untouched object. The plant is in contact where the tip is below the undeformed
    top.

    Args:
        plan: what to do.
        progress: called now and then with the share done (0 to 1).

    Raises:
        BadInput: a camera that does not see the object.
    """
    intrinsics, where = plan.intrinsics(), plan.camera()
    untouched = perfect_depth(rendered_scene(intrinsics, where, plan.scene))
    table = perfect_depth(rendered_scene(intrinsics, where, replace(plan.scene, empty=True)))
    motion = plan.motion()

    builder = DiagramBuilder()
    hand = builder.AddSystem(ScriptedOperator(motion))
    box = builder.AddSystem(FlexibleBox(FlexibleBoxModel()))
    view = builder.AddSystem(rendered_scene(intrinsics, where, plan.scene))
    split = builder.AddSystem(Demultiplexer([3, 3]))
    builder.Connect(hand.GetOutputPort("motion"), box.GetInputPort("motion"))
    builder.Connect(hand.GetOutputPort("motion"), split.get_input_port())
    builder.Connect(box.GetOutputPort("force"), hand.GetInputPort("force"))
    builder.Connect(box.GetOutputPort("body"), view.GetInputPort("body"))
    truth = LogVectorOutput(box.GetOutputPort("in_contact"), builder, _STEP)
    position = LogVectorOutput(split.get_output_port(0), builder, _STEP)

    smooth, prepared = plan.smoothing(), []
    for number, amount in enumerate(plan.noise):
        noise = replace(DepthNoise.stereo(intrinsics.fx).scaled(amount), seed=1000 * plan.seed + number)
        calibration = calibrate(plan, table, noise)
        frames = builder.AddSystem(SimulatedFrames(intrinsics, noise, rate=plan.rate))
        builder.Connect(view.GetOutputPort("depth_image"), frames.GetInputPort("depth_image"))
        for voxel in plan.voxel:
            convert = DepthToCloud(intrinsics, calibration.extrinsics, CloudSettings(voxel=voxel))
            case = _prepared(plan, amount, voxel, convert, noise, untouched)
            camera = builder.AddSystem(SimulatedDepthCamera(convert, smooth, rate=plan.rate, latency=plan.latency))
            detector = builder.AddSystem(ContactDetector(ProxySettings(surface_offset=case.offset)))
            builder.Connect(frames.GetOutputPort("frame"), camera.GetInputPort("frame"))
            builder.Connect(camera.GetOutputPort("point_cloud"), detector.GetInputPort("point_cloud"))
            builder.Connect(split.get_output_port(0), detector.GetInputPort("position"))
            prepared.append((case, LogVectorOutput(detector.GetOutputPort("in_contact"), builder, _STEP)))

    simulator = Simulator(builder.Build())
    if progress is not None:
        report, due = progress, 0.0

        def watch(context: object) -> None:
            nonlocal due
            now = simulator.get_context().get_time()
            if now >= due:
                due = now + _CHECKED_EVERY
                report(now / motion.cycle)

        simulator.set_monitor(watch)
    simulator.AdvanceTo(motion.cycle)
    context = simulator.get_context()
    time = truth.FindLog(context).sample_times()
    contact = truth.FindLog(context).data()[0] > 0.5
    height = position.FindLog(context).data()[2]
    cases = (
        replace(case, score=score(time, height, contact, log.FindLog(context).data()[0] > 0.5))
        for case, log in prepared
    )
    return Result(plan, motion.cycle, tuple(cases))


def calibrate(plan: Plan, table: NDArray[np.float32], noise: DepthNoise) -> Calibration:
    """The camera's place, found from a few noisy frames of the bare table.

    Args:
        plan: whose camera and object.
        table: (height, width) depth of the bare table [m].
        noise: of the camera.
    """
    intrinsics, where = plan.intrinsics(), plan.camera()
    frames = range(_CALIBRATION_FRAMES)
    points = [
        intrinsics.points(noise.apply(table, intrinsics, _FIRST_CALIBRATION_FRAME + k), noise.unit) for k in frames
    ]
    x, y, _ = where.position
    tolerance = max(0.005, 4.0 * noise.axial_z2)
    return calibrate_on_table(
        np.concatenate(points)[::7], object_height=plan.scene.size[2], foot=(x, y), tolerance=tolerance
    )


def _prepared(
    plan: Plan, amount: float, voxel: float, convert: DepthToCloud, noise: DepthNoise, untouched: NDArray[np.float32]
) -> Case:
    """A case whose detector has not run yet."""
    rim = 0.5 * np.array(plan.scene.size[:2]) - _MARGIN
    tops = []
    smooth, smoothed = plan.smoothing(), None
    settling = 0 if smooth is None else math.ceil(3.0 / plan.alpha)
    for k in range(-settling, _CALIBRATION_FRAMES):
        depth = noise.apply(untouched, convert.intrinsics, _FIRST_UNTOUCHED_FRAME + k)
        if smooth is not None:
            smoothed = smooth(smoothed, depth, noise.unit)
        if k < 0:
            continue
        points = (convert(depth, noise.unit) if smoothed is None else convert(smoothed, 1.0)).cloud.points()
        tops.append(points[(np.abs(points[:, :2]) < rim).all(axis=1)])
    top = tops[0]
    if len(top) < 10:
        found = f"{len(top)} points of the object, noise {amount:g}, voxel {voxel:g} m"
        raise BadInput("cloud experiment", found=found, expected="a camera that sees it")
    spacing, roughness = Cloud(top).spacing, float(top[:, 2].std())
    r2 = ProxySettings().r2
    (x, y), frames = (rim - r2).tolist(), enumerate(tops)
    offset = float(np.mean([measured_offset(top, r2, (-x, -y), (x, y), seed=k) for k, top in frames]))
    nothing = Score(0, 0, 0, 0, 0.0, np.empty(0), np.empty(0), np.empty(0))
    return Case(amount, voxel, len(top), spacing, float(top[:, 2].mean()), roughness, offset, nothing)
