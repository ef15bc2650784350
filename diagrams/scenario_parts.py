"""What a scenario is put together from: hands, object and sensors, renderers."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from mmt_drake.diagrams.camera_options import DepthCamera, SimulatedDepthCamera
from mmt_drake.errors import BadInput
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.model.structure import Friction
from mmt_drake.motion.placement import Placement
from mmt_drake.rendering.high_band import HighBand
from mmt_drake.rendering.passivity import PassivityControl
from mmt_drake.rendering.updates import AtOnce, Policy
from mmt_drake.systems.flexible_box import SensorNoise
from mmt_drake.systems.impedance_reflection import ProbeInput

_MOST_POINTS = 10_000_000

#: Karnopp friction of the thesis's set-up 1 (section 4.1).
THESIS_FRICTION = Friction(Fs=0.1, Fd=0.05, v_d=0.005)


@dataclass(frozen=True)
class Scripted:
    """A hand that follows a named motion (`mmt_drake.motion.SCRIPTED`).

    Attributes:
        motion: its name.
        parameters: of the motion; those left out keep their defaults.
    """

    motion: str = "strokes"
    parameters: dict[str, float | int | str] = field(default_factory=dict)


@dataclass(frozen=True)
class Recorded:
    """A hand that repeats a recording.

    Attributes:
        file: any recording with a probe's position; `builtin:NAME` is one that the package ships.
        placement: how it is put onto the table; null chooses by what the recording holds.
    """

    file: str = "builtin:hand_reaching"
    placement: Placement | None = None


@dataclass(frozen=True)
class Interactive:
    """A hand on three sliders of the viewer's page.

    Attributes:
        bandwidth: of the filter that smooths the sliders [Hz].
        greatest_speed: of the hand along each axis [m/s].
    """

    bandwidth: float = 2.0
    greatest_speed: float = 0.5


@dataclass(frozen=True)
class SurfaceCloud:
    """The object's top as a depth camera would sample it.

    It lies about the middle of what a recorded hand covers, else about the origin, and moves with the object, while the
    plant's surface has no edge: a probe that has left the square is in contact but not detected. A hand that drags the
    object further in every cycle gets there in time.

    Attributes:
        file: `.ply`, `.pcd` or `.xyz` of the undisplaced surface [m, table frame], in place of points, size and layout.
        voxel: thins the file's points to one for each cube of this edge [m]; null keeps all.
        points: how many.
        size: side of the square [m].
        rate: clouds per second [Hz].
        layout: `regular`, `jittered` or `random`.
        noise: standard deviation of each coordinate, fresh in every cloud [m].
    """

    file: str | None = None
    voxel: float | None = None
    points: int = 30_000
    size: float = 0.3
    rate: float = 30.0
    layout: Literal["regular", "jittered", "random"] = "regular"
    noise: float = 0.0

    def __post_init__(self) -> None:
        if not 0 <= self.points <= _MOST_POINTS:
            raise BadInput("cloud", at="points", found=self.points, expected=f"0 to {_MOST_POINTS}")
        drawn = [name for name in ("points", "size", "layout") if getattr(self, name) != getattr(SurfaceCloud, name)]
        if self.file is not None and drawn:
            raise BadInput("cloud", at=drawn[0], found=getattr(self, drawn[0]), expected="nothing beside a file")
        if self.voxel is not None and (self.file is None or not self.voxel > 0.0):
            raise BadInput("cloud", at="voxel", found=self.voxel, expected="an edge above 0 m, for a cloud from a file")
        for name, least, most, unit in (("size", 1e-3, 10.0, "m"), ("rate", 1e-3, 1e3, "Hz"), ("noise", 0.0, 0.1, "m")):
            if not least <= getattr(self, name) <= most:
                expected = f"{least:g} to {most:g} {unit}"
                raise BadInput("cloud", at=name, found=getattr(self, name), expected=expected)


@dataclass(frozen=True)
class Environment:
    """The remote side's object and sensors; the defaults are the thesis's set-up 1.

    In a file the object may have `effects` too, as in a model file.
    """

    object: FlexibleBoxModel = FlexibleBoxModel(friction=THESIS_FRICTION)
    noise: SensorNoise = SensorNoise()
    cloud: SurfaceCloud | SimulatedDepthCamera | DepthCamera = SurfaceCloud()

    def __post_init__(self) -> None:
        try:
            self.object.kernel_vector()
        except BadInput as error:
            at = f"object.parameters.{error.at}"
            raise BadInput("environment", at=at, found=error.found, expected=error.expected) from None


@dataclass(frozen=True)
class ImpedanceReflection:
    """The estimated object, integrated on the operator's side.

    Attributes:
        substeps: Runge-Kutta steps per tick at least.
        updates: how parameters that arrive are taken up.
        probe: `moved` or `placed`, see `mmt_drake.systems.impedance_reflection`.
    """

    substeps: int = 1
    updates: Policy = field(default_factory=AtOnce)
    probe: ProbeInput = "moved"


@dataclass(frozen=True)
class ProxySpring:
    """A spring to the proxy on the point cloud, eq. 3.

    Attributes:
        k: its stiffness [N/m].
    """

    k: float = 500.0


@dataclass(frozen=True)
class DirectForce:
    """The telerobot's force, sent to the operator as it is measured: no model.

    Attributes:
        passivity: time-domain passivity control at both ends; null: none.
    """

    passivity: PassivityControl | None = None


@dataclass(frozen=True)
class FusedReflection:
    """`ImpedanceReflection`, and above a frequency in part a variable spring that the telerobot fits as well.

    Attributes:
        substeps, updates: as there.
        high_band: the second model.
    """

    substeps: int = 1
    updates: Policy = field(default_factory=AtOnce)
    high_band: HighBand = field(default_factory=HighBand)


Renderer = ImpedanceReflection | ProxySpring | DirectForce | FusedReflection
