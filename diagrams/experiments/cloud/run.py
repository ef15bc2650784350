"""One rendered scene, seen by many cameras at once, each with a detector of its own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from itertools import product

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import Demultiplexer, LogVectorOutput

from mmt_drake.cloud import ProxySettings
from mmt_drake.diagrams.experiments.cloud.plan import Plan
from mmt_drake.diagrams.experiments.cloud.score import Score, score
from mmt_drake.hw.realsense.depth import DepthToCloud
from mmt_drake.hw.realsense.extrinsics import Calibration, calibrate_on_table
from mmt_drake.hw.realsense.noise import DepthNoise
from mmt_drake.hw.realsense.settings import CloudSettings
from mmt_drake.hw.realsense.simulated import SimulatedDepthCamera, SimulatedFrames, perfect_depth, rendered_scene
from mmt_drake.hw.realsense.temporal import TemporalFilter
from mmt_drake.hw.realsense.untouched import Untouched, untouched
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.systems.contact_detector import ContactDetector
from mmt_drake.systems.flexible_box import FlexibleBox
from mmt_drake.systems.scripted_operator import ScriptedOperator

_STEP = 1e-3
_R2 = ProxySettings().r2
_CALIBRATION_FRAMES, _FIRST_CALIBRATION_FRAME = 8, 1_000_000  # frames that no run reaches
_CHECKED_EVERY = 0.5  # [s] between two calls of `progress`


@dataclass(frozen=True)
class Case:
    """One camera and its detector.

    Attributes:
        noise: in parts of a stereo camera's.
        voxel: edge of the voxel filter [m].
        alpha: of the temporal filter; 1: none.
        untouched: what the camera shows of the object before the first touch; its offset is the detector's.
        score: what the detector did.
    """

    noise: float
    voxel: float
    alpha: float
    untouched: Untouched
    score: Score


@dataclass(frozen=True)
class Result:
    """What came of a plan: one case for each temporal filter, noise and voxel, in the plan's order."""

    plan: Plan
    seconds: float
    cases: tuple[Case, ...]


def cases_of(result: Result, **of: float) -> list[Case]:
    """The cases with this noise, voxel or alpha, in the plan's order."""
    return [case for case in result.cases if all(getattr(case, name) == value for name, value in of.items())]


def run_cloud(plan: Plan | None = None, progress: Callable[[float], None] | None = None) -> Result:
    """Carry out a plan.

    Every camera is first calibrated on the bare table through its own noise, and its detector is given the offset that
    was measured on a few frames of the untouched object. The plant is in contact where the tip is below the undeformed
    top.

    Args:
        plan: what to do; `Plan()` by default.
        progress: called now and then with the simulated time [s].

    Raises:
        BadInput: a camera that does not see the object.
    """
    plan = plan or Plan()
    intrinsics, where = plan.view.intrinsics(), plan.view.extrinsics()
    depth = perfect_depth(rendered_scene(intrinsics, where, plan.scene))
    table = perfect_depth(rendered_scene(intrinsics, where, replace(plan.scene, empty=True)))
    motion = plan.motion()

    builder = DiagramBuilder()
    hand = builder.AddSystem(ScriptedOperator(motion))
    box = builder.AddSystem(FlexibleBox(FlexibleBoxModel()))
    view = builder.AddSystem(rendered_scene(intrinsics, where, plan.scene))
    builder.Connect(hand.GetOutputPort("motion"), box.GetInputPort("motion"))
    builder.Connect(box.GetOutputPort("force"), hand.GetInputPort("force"))
    builder.Connect(box.GetOutputPort("body"), view.GetInputPort("body"))
    truth = LogVectorOutput(box.GetOutputPort("in_contact"), builder, _STEP)
    halves = builder.AddSystem(Demultiplexer([3, 3]))
    builder.Connect(hand.GetOutputPort("motion"), halves.get_input_port())
    tip = halves.get_output_port(0)
    position = LogVectorOutput(tip, builder, _STEP)

    prepared = []
    for number, amount in enumerate(plan.noise):
        noise = replace(DepthNoise.stereo(intrinsics.fx).scaled(amount), seed=1000 * plan.seed + number)
        calibration = calibrate(plan, table, noise)
        frames = builder.AddSystem(SimulatedFrames(intrinsics, noise, rate=plan.rate))
        builder.Connect(view.GetOutputPort("depth_image"), frames.GetInputPort("depth_image"))
        for alpha, voxel in product(plan.alpha, plan.voxel):
            convert = DepthToCloud(intrinsics, calibration.extrinsics, CloudSettings(voxel=voxel))
            smooth = None if alpha == 1.0 else TemporalFilter(alpha)
            shown = untouched(convert, noise, depth, plan.scene, _R2, smooth)
            camera = builder.AddSystem(SimulatedDepthCamera(convert, smooth, rate=plan.rate, latency=plan.latency))
            detector = builder.AddSystem(ContactDetector(ProxySettings(r2=_R2, surface_offset=shown.offset)))
            builder.Connect(frames.GetOutputPort("frame"), camera.GetInputPort("frame"))
            builder.Connect(camera.GetOutputPort("point_cloud"), detector.GetInputPort("point_cloud"))
            builder.Connect(tip, detector.GetInputPort("position"))
            detected = LogVectorOutput(detector.GetOutputPort("in_contact"), builder, _STEP)
            prepared.append((partial(Case, amount, voxel, alpha, shown), detected))

    simulator = Simulator(builder.Build())
    if progress is not None:
        report, due = progress, 0.0

        def watch(context: object) -> None:
            nonlocal due
            now = simulator.get_context().get_time()
            if now >= due:
                due = now + _CHECKED_EVERY
                report(now)

        simulator.set_monitor(watch)
    simulator.AdvanceTo(motion.cycle)
    context = simulator.get_context()
    time = truth.FindLog(context).sample_times()
    contact = truth.FindLog(context).data()[0] > 0.5
    height = position.FindLog(context).data()[2]
    cases = [
        case(score(time, height, contact, detected.FindLog(context).data()[0] > 0.5)) for case, detected in prepared
    ]
    cases.sort(key=lambda case: plan.alpha.index(case.alpha))  # stable: noise and voxel stay in order
    return Result(plan, motion.cycle, tuple(cases))


def calibrate(plan: Plan, table: NDArray[np.float32], noise: DepthNoise) -> Calibration:
    """The camera's place, found from a few noisy frames of the bare table.

    Args:
        plan: whose camera and object.
        table: (height, width) depth of the bare table [m].
        noise: of the camera.
    """
    intrinsics, where = plan.view.intrinsics(), plan.view.extrinsics()
    frames = range(_CALIBRATION_FRAMES)
    points = [
        intrinsics.points(noise.apply(table, intrinsics, _FIRST_CALIBRATION_FRAME + k), noise.unit) for k in frames
    ]
    x, y, _ = where.position
    tolerance = max(0.005, 4.0 * noise.axial_z2)
    return calibrate_on_table(
        np.concatenate(points)[::7], object_height=plan.scene.size[2], foot=(x, y), tolerance=tolerance
    )
