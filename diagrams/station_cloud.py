"""Where a station's cloud comes from: the environment itself, a simulated camera, or a real one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

from pydrake.systems.framework import DiagramBuilder, OutputPort, System

from mmt_drake.cloud import Cloud, contact_offset, plane
from mmt_drake.cloud.files import read_cloud, thinned
from mmt_drake.diagrams.camera_options import DepthCamera, SimulatedDepthCamera
from mmt_drake.diagrams.devices import Devices
from mmt_drake.diagrams.ports import split
from mmt_drake.diagrams.scenario import Scenario, SurfaceCloud
from mmt_drake.diagrams.station_live import Columns
from mmt_drake.errors import BadInput
from mmt_drake.hw.realsense.depth import DepthToCloud
from mmt_drake.hw.realsense.simulated import perfect_depth, rendered_scene, simulated_camera
from mmt_drake.hw.realsense.untouched import untouched
from mmt_drake.hw.realsense.view import TableScene

_CAMERA_SEED = 601  # apart from the station's other random streams


class Surface(NamedTuple):
    """What a station's detectors will see, as far as it is known before the run.

    Attributes:
        shown: by the environment itself, undisplaced; empty where a camera looks.
        camera: what looks, if not the environment itself shows its surface.
        spacing: between the points [m]; 0: unknown.
        noise: standard deviation of their heights [m]; of a real camera's nothing is known.
        offset: how much lower a detector should take them [m]; None leaves it to the detector.
    """

    shown: Cloud
    camera: System | None
    spacing: float
    noise: float
    offset: float | None


def surface_of(scenario: Scenario, middle: tuple[float, float], devices: Devices = Devices()) -> Surface:
    """The surface of a scenario.

    Args:
        scenario: what is built.
        middle: x, y [m] of what the hand covers.
        devices: of the run; without a camera a scenario that names one has no surface yet.

    Raises:
        BadInput: a file of points cannot be read; a simulated camera does not see the object, or is to see a real one.
    """
    chosen, r2 = scenario.environment.cloud, scenario.detector.r2
    if isinstance(chosen, SurfaceCloud):
        shown = _points(chosen, middle, scenario.seed)
        # Without noise the detector's own rule follows the spacing of each cloud.
        noisy = chosen.noise > 0.0 and len(shown) > 0
        offset = contact_offset(r2, shown.spacing, chosen.noise) if noisy else None
        return Surface(shown, None, shown.spacing, chosen.noise, offset)
    if isinstance(chosen, DepthCamera):
        system = None if devices.camera is None else devices.camera.system
        return Surface(Cloud.empty(), system, chosen.settings.voxel or 0.0, 0.0, None)
    if devices.arm is not None:
        expected = "!DepthCamera, or the surface as it was measured (cloud.file): the object is a real one"
        raise BadInput(scenario.name, found="!SimulatedDepthCamera beside an arm", expected=expected)
    return _simulated(chosen, middle, r2, scenario.seed)


def cloud_port(scenario: Scenario, parts: Mapping[str, System]) -> OutputPort:
    """The port that shows the surface: the camera's where one looks, else the environment's.

    Raises:
        BadInput: the scenario names a real camera and there is none.
    """
    if "camera" in parts:
        return parts["camera"].GetOutputPort("point_cloud")
    if isinstance(scenario.environment.cloud, DepthCamera):
        expected = "a run with --hardware, or !SimulatedDepthCamera"
        raise BadInput(scenario.name, at="environment.cloud", found="!DepthCamera", expected=expected)
    return parts["environment"].GetOutputPort("point_cloud")


def wire_camera(builder: DiagramBuilder, parts: Mapping[str, System]) -> None:
    """Show a simulated camera, if there is one, how the object moves."""
    camera = parts.get("camera")
    if camera is not None and camera.HasInputPort("body"):
        builder.Connect(parts["environment"].GetOutputPort("body"), camera.GetInputPort("body"))


def camera_columns(builder: DiagramBuilder, parts: Mapping[str, System]) -> Columns:
    """What a camera tells of itself: ports, and the recording's columns for each; nothing where there is none."""
    if "camera" not in parts:
        return ()
    fault, age, lost = split(builder, parts["camera"].GetOutputPort("camera"), (1, 1, 1))
    return ((fault, ("camera_fault",)), (age, ("camera_age",)), (lost, ("camera_lost",)))


def _points(chosen: SurfaceCloud, middle: tuple[float, float], seed: int) -> Cloud:
    """The undisplaced surface, from a file, or drawn about the middle."""
    if chosen.file is None:
        return plane(chosen.points, (chosen.size,) * 2, centre=(*middle, 0.0), layout=chosen.layout, seed=seed)
    surface = read_cloud(chosen.file)
    return surface if chosen.voxel is None else thinned(surface, chosen.voxel)


def _simulated(chosen: SimulatedDepthCamera, middle: tuple[float, float], r2: float, seed: int) -> Surface:
    errors = chosen.camera_errors()
    errors = replace(errors, seed=errors.seed + seed + _CAMERA_SEED)
    intrinsics, where = chosen.view.intrinsics(), chosen.view.extrinsics(middle)
    scene = TableScene(chosen.size, at=middle)
    depth = perfect_depth(rendered_scene(intrinsics, where, scene))
    seen = untouched(DepthToCloud(intrinsics, where, chosen.settings), errors, depth, scene, r2, chosen.smooth)
    camera = simulated_camera(
        intrinsics,
        where,
        scene=scene,
        noise=errors,
        settings=chosen.settings,
        smooth=chosen.smooth,
        rate=chosen.rate,
        latency=chosen.latency,
    )
    return Surface(Cloud.empty(), camera, seen.spacing, seen.roughness, seen.offset)
