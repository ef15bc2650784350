"""A simulated depth camera: a rendered scene, of which `DepthNoise` makes what a camera tells."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Self

from pydrake.common.value import AbstractValue
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, State

from mmt_drake.beside import Apart, Later, at_once
from mmt_drake.cloud import Cloud
from mmt_drake.errors import BadInput, check_number
from mmt_drake.hw.realsense.camera import STALE_S, declare_camera_ports
from mmt_drake.hw.realsense.colour import ColourImage
from mmt_drake.hw.realsense.depth import Converted, DepthImage, DepthToCloud, Image, Intrinsics
from mmt_drake.hw.realsense.extrinsics import Extrinsics
from mmt_drake.hw.realsense.faults import BLIND, NO_FRAME, STALE, WELL
from mmt_drake.hw.realsense.noise import DepthNoise
from mmt_drake.hw.realsense.rendered import Point3, RenderedScene
from mmt_drake.hw.realsense.view import BOX, TableScene
from mmt_drake.numeric.arrays import Array
from mmt_drake.systems.leaf import LeafSystem
from mmt_drake.systems.objects_on_table import OF_A_BODY

_COLOUR_S = 1.0  # between frames in colour


@dataclass(frozen=True, eq=False)
class SimulatedFrame:
    """What a camera tells where a perfect one sees something; the picture is made once, when it is first asked for.

    Attributes:
        seen: what it looks at.
        at: where that is now, see `RenderedScene.depth`.
        noise: the camera's errors.
        number: of the frame.
        coloured: every so many-th frame is in colour, too.
    """

    seen: RenderedScene
    at: tuple[Point3, ...]
    noise: DepthNoise
    number: int
    coloured: int = 1

    @property
    def unit(self) -> float:
        """Of depth [m]."""
        return self.noise.unit

    @cached_property
    def depth(self) -> DepthImage:
        """(height, width) in units, 0 without depth."""
        return self.noise.apply(self.seen.depth(*self.at), self.seen.intrinsics, self.number)

    @cached_property
    def colour(self) -> ColourImage | None:
        """In colour; of the first frame and one in a second, since objects keep their colours."""
        return self.seen.colour(*self.at) if self.number % self.coloured == 0 else None

    def __deepcopy__(self, memo: object) -> Self:
        return self


_NOWHERE = RenderedScene(Intrinsics(3, 3, 1.0, 1.0, 1.0, 1.0), Extrinsics((0.0, 0.0, 1.0), (1.0, 0.0, 0.0, 0.0)))
_NO_FRAME = SimulatedFrame(_NOWHERE, (), DepthNoise(), -1)


class SimulatedFrames(LeafSystem):
    """Where bodies are in, out the frame that a camera with `DepthNoise` tells of them; no state.

    .. pydrake_system::

        name: SimulatedFrames
        input_ports:
        - body
        - bodies
        - probe
        output_ports:
        - frame

    Ports:

    - `body` (4): displacement of the one body in x, y [m], rates; there where no probe is seen.
    - `bodies` (5 for each): the same of each body, and its height off the table [m]; there where a probe is seen.
    - `probe` (3): its tip [m, table frame]; there where it is seen.
    - `frame` (abstract, `SimulatedFrame`): numbered by the time, in frames since 0; errors are a function of that.

    Attributes:
        untouched: the frame before anything moves.

    Args:
        seen: what the camera looks at.
        noise: its errors.
        rate: frames per second [Hz].

    Raises:
        BadInput: a rate that is not positive.
    """

    def __init__(self, seen: RenderedScene, noise: DepthNoise | None = None, *, rate: float = 30.0) -> None:
        super().__init__()
        check_number("simulated camera", "rate", rate, least=0.0, open_interval=True)
        self._rate = rate
        self.untouched = SimulatedFrame(seen, (), noise or DepthNoise(), 0, max(1, round(rate * _COLOUR_S)))
        if seen.scene.probe is None:
            self.declare_inputs("body", bodies=0, probe=0)
        else:
            self.declare_inputs(body=0, bodies=OF_A_BODY * len(seen.origins), probe=3)
        sources = self.tickets(("body", "bodies", "probe"))
        self.DeclareAbstractOutputPort("frame", lambda: AbstractValue.Make(_NO_FRAME), self._calc, sources)

    def _calc(self, context: Context, output: AbstractValue) -> None:
        body, bodies, probe = self.inputs_at(context)
        first = self.untouched
        moved = [(*body[:2], 0.0)] if bodies is None else bodies.reshape(-1, OF_A_BODY)[:, [0, 1, 4]].tolist()
        frames = [(x + dx, y + dy, up) for (x, y), (dx, dy, up) in zip(first.seen.origins, moved, strict=True)]
        at = tuple(frames) if probe is None else (*frames, tuple(probe.tolist()))
        output.set_value(replace(first, at=at, number=round(context.get_time() * self._rate)))


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
    - `camera` (3): fault code (0: well; else `mmt_drake.hw.realsense.faults`), age of the latest frame when its cloud
      was ready, and more once a cloud is late [s], share of its pixels that had no depth (0 to 1).

    Both outputs are states.

    Args:
        convert: the camera, where it is taken to be, and the filters.
        rate: frames per second [Hz].
        latency: from the moment a frame shows to its cloud [s]; less than the time between frames.
        apart: how the picture and its cloud are made: in a process of its own, where a run has one.
        prepare: is called where they are made, before the first.
        waits: for that; else, in real time, a cloud that is not there in time is shown frames later, and the frames in
            the meantime are passed over. One older than `STALE_S` is no longer shown.

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
        prepare: Callable[[], object] | None = None,
        waits: bool = True,
    ) -> None:
        super().__init__()
        check_number("simulated camera", "rate", rate, least=0.0, open_interval=True)
        if not 0.0 <= latency < 1.0 / rate:
            raise BadInput("simulated camera", at="latency", found=latency, expected=f"0 to below {1.0 / rate:g} s")
        self._period = 1.0 / rate
        self._converted, self._latency, self._waits = apart(_Conversion(convert), prepare), latency, waits
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
        shown = state.get_mutable_abstract_state(self._cloud)
        camera = state.get_mutable_discrete_state(self._camera).get_mutable_value()
        if not (self._waits or later.is_there):
            self._late(context.get_time(), shown, camera)
            return
        taken = later.value
        shown.set_value(taken.cloud)
        age = self._latency if self._waits else context.get_time() - taken.cloud.stamp
        camera[:] = WELL if len(taken.cloud) else BLIND, age, taken.lost

    def _late(self, t: float, shown: AbstractValue, camera: Array) -> None:
        """No cloud has come in time: the one that is shown gets older, and is let go."""
        if camera[0] != NO_FRAME:
            camera[1] += self._period
        if camera[0] == WELL and camera[1] > STALE_S:
            camera[0] = STALE
            shown.set_value(Cloud.empty(t))


@dataclass(frozen=True)
class _Conversion:
    convert: DepthToCloud

    def __call__(self, frame: SimulatedFrame, t: float, before: Image | None) -> Converted:
        return self.convert(frame.depth, frame.unit, t, before, frame.colour)


def _look_at(frame: SimulatedFrame) -> None:
    """Have pictures made; of a copy, so that the frame does not keep them."""
    unkept = replace(frame)
    unkept.depth, unkept.colour  # noqa: B018


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
    """`SimulatedFrames` and the `SimulatedDepthCameraSystem` that takes them: inputs of the one, outputs of the other.

    Args:
        where: the camera really is.
        convert: the camera, where it is taken to be, and the filters.
        scene: what it looks at.
        noise: its errors.
        rate: frames per second [Hz].
        latency: from the moment a frame shows to its cloud [s].
        apart, waits: see `SimulatedDepthCameraSystem`.

    Raises:
        BadInput: as these, and `RenderedScene`.
    """
    builder = DiagramBuilder()
    frames = builder.AddSystem(SimulatedFrames(RenderedScene(convert.intrinsics, where, scene), noise, rate=rate))
    prepare = partial(_look_at, frames.untouched)  # loads and compiles before the clock starts
    camera = builder.AddSystem(
        SimulatedDepthCameraSystem(convert, rate=rate, latency=latency, apart=apart, prepare=prepare, waits=waits)
    )
    builder.Connect(frames.GetOutputPort("frame"), camera.GetInputPort("frame"))
    for index in range(frames.num_input_ports()):
        builder.ExportInput(frames.get_input_port(index), frames.get_input_port(index).get_name())
    for port in ("point_cloud", "camera"):
        builder.ExportOutput(camera.GetOutputPort(port), port)
    diagram = builder.Build()
    diagram.set_name("simulated_camera")
    return diagram
