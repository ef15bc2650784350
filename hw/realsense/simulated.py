"""A simulated depth camera: Drake renders the scene, `DepthNoise` makes a camera of the picture."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.geometry import (
    Box,
    ClippingRange,
    DepthRange,
    DepthRenderCamera,
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
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, State
from pydrake.systems.sensors import CameraInfo, ImageDepth32F, RgbdSensor

from mmt_drake.beside import Apart, Later, at_once
from mmt_drake.cloud import Cloud
from mmt_drake.errors import BadInput, check_number
from mmt_drake.hw.realsense.camera import declare_camera_ports
from mmt_drake.hw.realsense.depth import Converted, DepthImage, DepthToCloud, Image, Intrinsics
from mmt_drake.hw.realsense.extrinsics import Extrinsics
from mmt_drake.hw.realsense.faults import BLIND, WELL
from mmt_drake.hw.realsense.noise import DepthNoise
from mmt_drake.hw.realsense.view import BOX, Point, Solid, TableScene
from mmt_drake.systems.leaf import LeafSystem
from mmt_drake.systems.objects_on_table import OF_A_BODY

_RENDERER = "depth"
_SHAFT = 0.15  # length of the probe [m]
_TABLE = (1.5, 1.5, 0.05)  # size of the table's top [m]
_NEAR, _FAR = 0.05, 5.0  # of what is rendered [m]


@dataclass(frozen=True, eq=False)
class SimulatedFrame:
    """What a camera tells where a perfect one sees something.

    Attributes:
        clean: (height, width) what that sees [m].
        intrinsics: of both.
        noise: its errors, which are put on once, when the depth is first asked for.
        number: of the frame.
    """

    clean: Image
    intrinsics: Intrinsics
    noise: DepthNoise
    number: int

    @property
    def unit(self) -> float:
        """Of depth [m]."""
        return self.noise.unit

    @cached_property
    def depth(self) -> DepthImage:
        """(height, width) in units, 0 without depth."""
        return self.noise.apply(self.clean, self.intrinsics, self.number)

    def __deepcopy__(self, memo: object) -> Self:
        return self


_NO_FRAME = SimulatedFrame(np.zeros((0, 0), np.float32), Intrinsics(3, 3, 1.0, 1.0, 1.0, 1.0), DepthNoise(), -1)


class SimulatedFrames(LeafSystem):
    """A perfect depth image in, out the frame that a camera with `DepthNoise` tells; no state.

    .. pydrake_system::

        name: SimulatedFrames
        input_ports:
        - depth_image
        output_ports:
        - frame

    Ports:

    - `depth_image` (abstract, `ImageDepth32F`): depth along the optical axis [m].
    - `frame` (abstract, `SimulatedFrame`): numbered by the time, in frames since 0; errors are a function of that.

    Args:
        intrinsics: of the camera.
        noise: its errors.
        rate: frames per second [Hz].
    """

    def __init__(self, intrinsics: Intrinsics, noise: DepthNoise | None = None, *, rate: float = 30.0) -> None:
        super().__init__()
        check_number("simulated camera", "rate", rate, least=0.0, open_interval=True)
        self._intrinsics, self._noise, self._rate = intrinsics, noise or DepthNoise(), rate
        i = intrinsics
        self._image = self.DeclareAbstractInputPort("depth_image", AbstractValue.Make(ImageDepth32F(i.width, i.height)))
        sources = {self.time_ticket(), self.input_port_ticket(self._image.get_index())}
        self.DeclareAbstractOutputPort("frame", lambda: AbstractValue.Make(_NO_FRAME), self._calc, sources)
        self._noise.apply(np.ones((i.height, i.width), np.float32), i, 0)  # compiles before the clock starts

    def _calc(self, context: Context, output: AbstractValue) -> None:
        t = context.get_time()
        clean = np.array(self._image.Eval(context).data[..., 0])
        output.set_value(SimulatedFrame(clean, self._intrinsics, self._noise, round(t * self._rate)))


class SimulatedDepthCameraSystem(LeafSystem):
    """Takes a frame at the camera's rate and shows of it what a `DepthCameraSystem` would.

    .. pydrake_system::

        name: SimulatedDepthCameraSystem
        input_ports:
        - frame
        output_ports:
        - point_cloud
        - camera

    Ports:

    - `frame` (abstract, `SimulatedFrame`): what the camera sees now.
    - `point_cloud` (abstract, `Cloud`): the surface, table frame, stamped with the time of its frame; empty before the
      first.
    - `camera` (3): fault code (0: well, 1: no frame yet), age of the latest frame when its cloud was ready [s], share
      of its pixels that had no depth (0 to 1).

    Both outputs are states.

    Args:
        convert: the camera, where it is taken to be, and the filters.
        rate: frames per second [Hz].
        latency: from the moment a frame shows to its cloud [s]; less than the time between frames.
        apart: how errors are put on and the cloud is made: in a process of its own, where a run has one.
        waits: for that; else, in real time, a cloud that is not there in time is shown a frame later, and the frames in
            the meantime are passed over.

    Raises:
        BadInput: a rate or latency out of its range.
    """

    def __init__(
        self,
        convert: DepthToCloud,
        *,
        rate: float = 30.0,
        latency: float = 0.0,
        apart: Apart = at_once,
        waits: bool = True,
    ) -> None:
        super().__init__()
        check_number("simulated camera", "rate", rate, least=0.0, open_interval=True)
        if not 0.0 <= latency < 1.0 / rate:
            raise BadInput("simulated camera", at="latency", found=latency, expected=f"0 to below {1.0 / rate:g} s")
        self._converted, self._latency, self._waits = apart(_Conversion(convert)), latency, waits
        self._frame = self.DeclareAbstractInputPort("frame", AbstractValue.Make(_NO_FRAME))
        self._cloud, self._camera = declare_camera_ports(self)
        nothing = Converted(Cloud.empty(), 0.0, None)
        self._taken = self.DeclareAbstractState(AbstractValue.Make(Later.known(nothing)))
        self.DeclarePeriodicUnrestrictedUpdateEvent(1.0 / rate, 0.0, self._take)
        if latency > 0.0:
            self.DeclarePeriodicUnrestrictedUpdateEvent(1.0 / rate, latency, self._deliver)

    def _take(self, context: Context, state: State) -> None:
        taken = state.get_mutable_abstract_state(self._taken)
        if not (self._waits or taken.get_value().is_there):
            return
        before: Converted = taken.get_value().value
        taken.set_value(self._converted(self._frame.Eval(context), context.get_time(), before.image))
        if self._latency == 0.0:
            self._deliver(context, state)

    def _deliver(self, context: Context, state: State) -> None:
        later: Later[Converted] = state.get_mutable_abstract_state(self._taken).get_value()
        if not (self._waits or later.is_there):
            return
        taken = later.value
        fault = WELL if len(taken.cloud) else BLIND
        state.get_mutable_abstract_state(self._cloud).set_value(taken.cloud)
        state.get_mutable_discrete_state(self._camera).get_mutable_value()[:] = fault, self._latency, taken.lost


@dataclass(frozen=True)
class _Conversion:
    convert: DepthToCloud

    def __call__(self, frame: SimulatedFrame, t: float, before: Image | None) -> Converted:
        return self.convert(frame.depth, frame.unit, t, before)


class _BodyPoses(LeafSystem):
    """The frames of bodies from their displacements, and the probe's from that of its tip.

    Of a body four numbers are told, of each of several a fifth: its height off the table [m].
    """

    def __init__(self, frames: Sequence[object], places: Sequence[Point], body: str, probe: object | None) -> None:
        super().__init__()
        self._frames, self._places, self._probe = frames, places, probe
        self._each = 4 if probe is None else OF_A_BODY
        self._body = self.DeclareVectorInputPort(body, self._each * len(frames))
        self._tip = None if probe is None else self.DeclareVectorInputPort("probe", 3)
        self.DeclareAbstractOutputPort("pose", lambda: AbstractValue.Make(FramePoseVector()), self._calc)

    def _calc(self, context: Context, output: AbstractValue) -> None:
        bodies = self._body.Eval(context).reshape(-1, self._each)
        poses = FramePoseVector()
        for frame, body, (x, y) in zip(self._frames, bodies, self._places, strict=True):
            height = 0.0 if self._tip is None else body[4]
            poses.set_value(frame, RigidTransform([body[0] + x, body[1] + y, height]))
        if self._tip is not None:
            poses.set_value(self._probe, RigidTransform(self._tip.Eval(context)))
        output.set_value(poses)


def _instance(name: str, shape: Shape, middle: tuple[float, float, float]) -> GeometryInstance:
    made = GeometryInstance(RigidTransform(np.array(middle)), shape, name)
    seen = PerceptionProperties()
    seen.AddProperty("phong", "diffuse", Rgba(0.6, 0.6, 0.6, 1.0))
    seen.AddProperty("label", "id", RenderLabel(1))
    made.set_perception_properties(seen)
    return made


def _solid(name: str, solid: Solid) -> GeometryInstance:
    """A body about the axis through its place, its top where it is."""
    wide, deep, high = solid.size
    shape = CylinderShape(0.5 * wide, high) if solid.round else Box(wide, deep, high)
    return _instance(name, shape, (0.0, 0.0, solid.top - 0.5 * high))


def rendered_scene(intrinsics: Intrinsics, where: Extrinsics, scene: TableScene = BOX) -> Diagram:
    """A diagram with the input `body` (4: displacement in x, y [m], rates) and the output `depth_image`.

    Where the probe is seen the input is `bodies`, so many numbers for each, and beside it `probe` (3: its tip [m]).

    Args:
        intrinsics: of the camera.
        where: it really is.
        scene: what it looks at. The hand is not in it, and surfaces are undeformed.

    Raises:
        BadInput: a focal length that Drake's renderer cannot have: fx and fy must be equal to a percent.
    """
    i = intrinsics
    if not math.isclose(i.fx, i.fy, rel_tol=0.01):
        raise BadInput("simulated camera", at="fx, fy", found=f"{i.fx}, {i.fy}", expected="square pixels")
    builder = DiagramBuilder()
    graph = builder.AddSystem(SceneGraph())
    graph.AddRenderer(_RENDERER, MakeRenderEngineVtk(RenderEngineVtkParams()))
    source = graph.RegisterSource("scene")
    table = _instance("table", Box(*_TABLE), (*scene.at, scene.low - 0.5 * _TABLE[2]))
    graph.RegisterAnchoredGeometry(source, table)
    places = [solid.at for solid in scene.solids] or [scene.at]
    frames = [graph.RegisterFrame(source, GeometryFrame(f"box {k}")) for k in range(len(places))]
    for frame, solid in zip(frames, scene.solids, strict=False):
        graph.RegisterGeometry(source, frame, _solid("box", solid))
    probe = None
    if scene.probe is not None:
        probe = graph.RegisterFrame(source, GeometryFrame("probe"))
        shaft = CylinderShape(scene.probe, _SHAFT)
        graph.RegisterGeometry(source, probe, _instance("probe", shaft, (0.0, 0.0, 0.5 * _SHAFT)))
    pose = builder.AddSystem(_BodyPoses(frames, places, _inputs(scene)[0], probe))
    builder.Connect(pose.GetOutputPort("pose"), graph.get_source_pose_port(source))
    # The renderer's pixel u looks along (u + 0.5 - cx) / fx: its middle is counted from the image's corner.
    info = CameraInfo(i.width, i.height, i.fx, i.fy, i.cx + 0.5, i.cy + 0.5)
    core = RenderCameraCore(_RENDERER, info, ClippingRange(0.5 * _NEAR, 2.0 * _FAR), RigidTransform())
    placed = RigidTransform(RotationMatrix(where.rotation()), np.array(where.position))
    sensor = builder.AddSystem(
        RgbdSensor(graph.world_frame_id(), placed, DepthRenderCamera(core, DepthRange(_NEAR, _FAR)))
    )
    builder.Connect(graph.get_query_output_port(), sensor.query_object_input_port())
    for name in _inputs(scene):
        builder.ExportInput(pose.GetInputPort(name), name)
    builder.ExportOutput(sensor.depth_image_32F_output_port(), "depth_image")
    diagram = builder.Build()
    diagram.set_name("rendered_scene")
    return diagram


def _inputs(scene: TableScene) -> tuple[str, ...]:
    return ("body",) if scene.probe is None else ("bodies", "probe")


def perfect_depth(scene: Diagram) -> np.ndarray[tuple[int, int], np.dtype[np.float32]]:
    """(height, width) depth [m] of a `rendered_scene` whose body has not moved."""
    context = scene.CreateDefaultContext()
    scene.GetInputPort("body").FixValue(context, np.zeros(4))
    return np.array(scene.GetOutputPort("depth_image").Eval(context).data[..., 0])


def simulated_camera(
    where: Extrinsics,
    convert: DepthToCloud,
    *,
    scene: TableScene = BOX,
    noise: DepthNoise | None = None,
    rate: float = 30.0,
    latency: float = 0.0,
    apart: Apart = at_once,
    waits: bool = True,
) -> Diagram:
    """Scene and camera: inputs of `rendered_scene`, outputs `point_cloud`, `camera` of `SimulatedDepthCameraSystem`.

    Args:
        where: the camera really is.
        convert: the camera, where it is taken to be, and the filters.
        scene: what it looks at.
        noise: its errors.
        rate: frames per second [Hz].
        latency: from the moment a frame shows to its cloud [s].
        apart, waits: see `SimulatedDepthCameraSystem`.
    """
    builder = DiagramBuilder()
    view = builder.AddSystem(rendered_scene(convert.intrinsics, where, scene))
    frames = builder.AddSystem(SimulatedFrames(convert.intrinsics, noise, rate=rate))
    camera = builder.AddSystem(
        SimulatedDepthCameraSystem(convert, rate=rate, latency=latency, apart=apart, waits=waits)
    )
    builder.Connect(view.GetOutputPort("depth_image"), frames.GetInputPort("depth_image"))
    builder.Connect(frames.GetOutputPort("frame"), camera.GetInputPort("frame"))
    for name in _inputs(scene):
        builder.ExportInput(view.GetInputPort(name), name)
    for port in ("point_cloud", "camera"):
        builder.ExportOutput(camera.GetOutputPort(port), port)
    diagram = builder.Build()
    diagram.set_name("simulated_camera")
    return diagram
