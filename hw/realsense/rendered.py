"""What a perfect camera of depth and colour sees of bodies on a table, rendered by Drake."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from functools import lru_cache
from threading import get_ident
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import (
    Box,
    ClippingRange,
    DepthRange,
    DepthRenderCamera,
    FrameId,
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    MakeRenderEngineVtk,
    PerceptionProperties,
    RenderCameraCore,
    RenderEngineVtkParams,
    RenderLabel,
    Rgba,
    SceneGraph,
    Shape,
)
from pydrake.geometry import Cylinder as CylinderShape
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.sensors import CameraInfo, RgbdSensor

from mmt_drake.errors import BadInput
from mmt_drake.hw.realsense.colour import ColourImage
from mmt_drake.hw.realsense.depth import Image, Intrinsics
from mmt_drake.hw.realsense.extrinsics import Extrinsics
from mmt_drake.hw.realsense.view import BOX, GREY, Colour, Point, Solid, TableScene

Point3 = tuple[float, float, float]

_RENDERER = "scene"
_SHAFT = 0.15  # length of the probe [m]
_TABLE = (1.5, 1.5, 0.05)  # size of the table's top [m]
_NEAR, _FAR = 0.05, 5.0  # of what is rendered [m]
_KEPT = 4  # renderers: each holds a picture and its buffers


@dataclass(frozen=True)
class RenderedScene:
    """A table under a camera. It can be pickled: what renders it is made where it is first asked for a picture.

    Attributes:
        intrinsics: of the camera.
        where: it really is.
        scene: what it looks at. The hand is not in it, and surfaces are undeformed.

    Raises:
        BadInput: a focal length that Drake's renderer cannot have: fx and fy must be equal to a percent; several bodies
            without a probe.
    """

    intrinsics: Intrinsics
    where: Extrinsics
    scene: TableScene = BOX

    def __post_init__(self) -> None:
        i = self.intrinsics
        if not math.isclose(i.fx, i.fy, rel_tol=0.01):
            raise BadInput("simulated camera", at="fx, fy", found=f"{i.fx}, {i.fy}", expected="square pixels")
        if len(self.scene.solids) > 1 and self.scene.probe is None:
            found = f"{len(self.scene.solids)} solids and no probe"
            raise BadInput("simulated camera", at="scene", found=found, expected="a probe beside several solids")

    @property
    def origins(self) -> tuple[Point, ...]:
        """x, y of each body before anything moves [m]; of the bare table's middle."""
        return tuple(solid.at for solid in self.scene.solids) or (self.scene.at,)

    def depth(self, *frames: Point3) -> Image:
        """(height, width) depth along the optical axis [m], read-only.

        Args:
            frames: x, y, z of each body's frame [m], which is at its origin and on the table before anything moves, and
                of the probe's tip, where that is seen; without any it is that, and the probe far away.
        """
        return _rendered(self, frames or self._untouched())

    def colour(self, *frames: Point3) -> ColourImage:
        """The same in colour, from where depth is seen, without shade."""
        return ColourImage(_drawn(self, "colour", frames or self._untouched())[..., :3], self.intrinsics)

    def _untouched(self) -> tuple[Point3, ...]:
        bodies = tuple((x, y, 0.0) for x, y in self.origins)
        return bodies if self.scene.probe is None else (*bodies, (0.0, 0.0, 2.0 * _FAR))


@lru_cache(maxsize=1)  # cameras of different errors look at the same picture
def _rendered(seen: RenderedScene, frames: tuple[Point3, ...]) -> Image:
    depth: Image = _drawn(seen, "depth", frames)[..., 0]
    return depth


def _drawn(seen: RenderedScene, what: str, frames: tuple[Point3, ...]) -> NDArray[Any]:
    return _renderer(seen, os.getpid(), get_ident()).draw(what, frames)


@lru_cache(maxsize=_KEPT)
def _renderer(seen: RenderedScene, process: int, thread: int) -> _SceneRenderer:
    """That of this thread: a renderer draws in no other."""
    return _SceneRenderer(seen)


class _SceneRenderer:
    def __init__(self, seen: RenderedScene) -> None:
        i, scene = seen.intrinsics, seen.scene
        builder = DiagramBuilder()
        graph = builder.AddSystem(SceneGraph())
        graph.AddRenderer(_RENDERER, MakeRenderEngineVtk(RenderEngineVtkParams()))
        source = graph.RegisterSource("scene")
        table = _instance("table", Box(*_TABLE), (*scene.at, scene.low - 0.5 * _TABLE[2]))
        graph.RegisterAnchoredGeometry(source, table)
        self._frames: list[FrameId] = []
        for k in range(len(seen.origins)):
            self._frames.append(graph.RegisterFrame(source, GeometryFrame(f"body {k}")))
        for frame, solid in zip(self._frames, scene.solids, strict=False):
            graph.RegisterGeometry(source, frame, _solid("body", solid))
        if scene.probe is not None:
            self._frames.append(graph.RegisterFrame(source, GeometryFrame("probe")))
            shaft = CylinderShape(scene.probe, _SHAFT)
            graph.RegisterGeometry(source, self._frames[-1], _instance("probe", shaft, (0.0, 0.0, 0.5 * _SHAFT)))
        # The renderer's pixel u looks along (u + 0.5 - cx) / fx: its middle is counted from the image's corner.
        info = CameraInfo(i.width, i.height, i.fx, i.fy, i.cx + 0.5, i.cy + 0.5)
        core = RenderCameraCore(_RENDERER, info, ClippingRange(0.5 * _NEAR, 2.0 * _FAR), RigidTransform())
        placed = RigidTransform(RotationMatrix(seen.where.rotation()), np.array(seen.where.position))
        camera = DepthRenderCamera(core, DepthRange(_NEAR, _FAR))
        sensor = builder.AddSystem(RgbdSensor(graph.world_frame_id(), placed, camera))
        builder.Connect(graph.get_query_output_port(), sensor.query_object_input_port())
        builder.ExportInput(graph.get_source_pose_port(source), "poses")
        builder.ExportOutput(sensor.depth_image_32F_output_port(), "depth")
        builder.ExportOutput(sensor.color_image_output_port(), "colour")
        self._diagram = builder.Build()
        self._context = self._diagram.CreateDefaultContext()

    def draw(self, what: str, frames: tuple[Point3, ...]) -> NDArray[Any]:
        """(height, width, channels) a picture, read-only."""
        poses = FramePoseVector()
        for frame, at in zip(self._frames, frames, strict=True):
            poses.set_value(frame, RigidTransform(np.array(at)))
        self._diagram.GetInputPort("poses").FixValue(self._context, poses)
        picture = np.array(self._diagram.GetOutputPort(what).Eval(self._context).data)
        picture.flags.writeable = False
        return picture


def _instance(name: str, shape: Shape, middle: Point3, colour: Colour = GREY) -> GeometryInstance:
    made = GeometryInstance(RigidTransform(np.array(middle)), shape, name)
    seen = PerceptionProperties()
    seen.AddProperty("phong", "diffuse", Rgba(*colour, 1.0))
    seen.AddProperty("label", "id", RenderLabel(1))
    made.set_perception_properties(seen)
    return made


def _solid(name: str, solid: Solid) -> GeometryInstance:
    """A body about the axis through its origin, its top where it is."""
    wide, deep, high = solid.size
    shape = CylinderShape(0.5 * wide, high) if solid.round else Box(wide, deep, high)
    return _instance(name, shape, (0.0, 0.0, solid.top - 0.5 * high), solid.colour)
