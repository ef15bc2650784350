"""Surfaces of a scenario's object, as shown by the object itself, a simulated depth camera, or a real one."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, Annotated, Literal, NamedTuple

from pydrake.systems.framework import System

from mmt_drake.ceilings import Bound, refuse_beyond
from mmt_drake.cloud import Cloud, ProxySettings, contact_offset, plane
from mmt_drake.cloud.files import read_cloud, thinned
from mmt_drake.errors import BadInput, check_number
from mmt_drake.hw.link.options import OPERATOR
from mmt_drake.hw.realsense.depth import DepthToCloud, TemporalFilter
from mmt_drake.hw.realsense.noise import DepthNoise
from mmt_drake.hw.realsense.settings import CloudSettings
from mmt_drake.hw.realsense.view import TableScene, View
from mmt_drake.hw.safety.limits import OURS

if TYPE_CHECKING:
    from mmt_drake.diagrams.stations.site import Site

_RATES = (1e-3, 1e3)  # [Hz]
_MOST_POINTS = 10_000_000
_CAMERA_SEED = 601  # apart from the station's other random streams


class SeenSurface(NamedTuple):
    """What a station's detectors will see, as far as it is known before the run.

    Attributes:
        shown: by the environment itself, undisplaced; empty where a camera looks.
        camera: what looks, if not the environment itself shows its surface.
        spacing: between the points [m]; 0: unknown.
        noise: standard deviation of their heights [m]; of a real camera's nothing is known.
        offset: how much lower a detector should take them [m]; None leaves it to the detector.
    """

    shown: Cloud
    camera: System | None = None
    spacing: float = 0.0
    noise: float = 0.0
    offset: float | None = None

    def looking_ahead(self, proxy: ProxySettings) -> ProxySettings:
        """Settings of a proxy that touches before the hand does, wherever between the points it comes down.

        On a square lattice a sphere of radius r comes down spacing²/(4 r) lower in a gap than on a point; noise lifts
        it.
        """
        if self.spacing == 0.0:
            return proxy
        ahead = self.spacing**2 / (4.0 * proxy.r2) + 3.0 * self.noise
        offset = proxy.surface_offset
        if offset is None:
            offset = contact_offset(proxy.r2, self.spacing, self.noise)
        return replace(proxy, surface_offset=offset - ahead)


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
    real = False

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

    def surface(self, site: Site) -> SeenSurface:
        """The undisplaced surface, from a file, or drawn about the middle of what the hand covers.

        Raises:
            BadInput: the file cannot be read.
        """
        shape = site.scenario.shape
        if self.file is None and shape is not None:
            shown = shape.cloud(self.points, (self.size,) * 2, arranged=self.layout, seed=site.scenario.seed)
        elif self.file is None:
            at = (*site.person.middle, 0.0)
            shown = plane(self.points, (self.size,) * 2, centre=at, layout=self.layout, seed=site.scenario.seed)
        else:
            shown = read_cloud(self.file)
            shown = shown if self.voxel is None else thinned(shown, self.voxel)
            shown = shown if shape is None else shown.with_normals()
        # Without noise the detector's own rule follows the spacing of each cloud.
        noisy = self.noise > 0.0 and len(shown) > 0
        offset = contact_offset(site.scenario.detector.r2, shown.spacing, self.noise) if noisy else None
        return SeenSurface(shown, None, shown.spacing, self.noise, offset)


@dataclass(frozen=True)
class SimulatedDepthCamera:
    """The object's top as a simulated depth camera sees it: rendered, with a camera's errors.

    The object is a box about the middle of what a recorded hand covers, else about the origin. It moves with the body;
    beyond its rim, and where no camera looks, there is no surface. Where the detector's `surface_offset` is not said,
    it is measured on the untouched object.

    Attributes:
        size: of the box along x, y, z [m].
        view: the camera, and where it stands.
        noise: axial and lateral noise, in parts of what the errors say.
        errors: noise, holes, flying pixels; null: those of a stereo camera (`DepthNoise.stereo`).
        settings: what of a depth image becomes the cloud.
        smooth: over frames; null: each stands alone.
        rate: frames per second [Hz].
        latency: from the moment a frame shows to its cloud [s], less than the time between frames.
    """

    size: tuple[float, float, float] = (0.2, 0.2, 0.08)
    view: View = field(default_factory=View)
    noise: float = 1.0
    errors: DepthNoise | None = None
    settings: CloudSettings = field(default_factory=CloudSettings)
    smooth: TemporalFilter | None = None
    rate: float = 30.0
    latency: float = 0.03
    real = False

    def __post_init__(self) -> None:
        TableScene.of_box(self.size)  # refuses a box without meaning
        check_number("cloud", "noise", self.noise, least=0.0)
        _check_rate(self.rate)
        if not 0.0 <= self.latency < 1.0 / self.rate:
            raise BadInput("cloud", at="latency", found=self.latency, expected=f"0 to below {1.0 / self.rate:g} s")

    def camera_errors(self) -> DepthNoise:
        """The camera's errors."""
        return (self.errors or DepthNoise.stereo(self.view.focal)).scaled(self.noise)

    def surface(self, site: Site) -> SeenSurface:
        """The camera above the object, and what it sees of it before it is touched.

        Raises:
            BadInput: the object is a real one, or the camera does not see it.
        """
        # Here: a station without a camera loads none of Drake's renderer.
        from mmt_drake.hw.realsense.rendered import RenderedScene
        from mmt_drake.hw.realsense.simulated import simulated_camera
        from mmt_drake.hw.realsense.untouched import untouched

        if site.devices.arm is not None:
            expected = "!DepthCamera, or the surface as it was measured (cloud.file): the object is a real one"
            raise BadInput(site.scenario.name, found="!SimulatedDepthCamera beside an arm", expected=expected)
        if site.scenario.shape is not None:
            expected = "environment.cloud: {}, points on the surface: the simulated camera sees a level box"
            raise BadInput(site.scenario.name, at="environment.cloud", found="!SimulatedDepthCamera", expected=expected)
        several = site.scenario.several
        middle, errors = site.person.middle if several is None else (0.0, 0.0), self.camera_errors()
        errors = replace(errors, seed=errors.seed + site.scenario.seed + _CAMERA_SEED)
        intrinsics, where = self.view.intrinsics(), self.view.extrinsics(middle)
        simulated = partial(
            simulated_camera,
            noise=errors,
            rate=self.rate,
            latency=self.latency,
            apart=site.apart,
            waits=not site.worker,
        )
        if several is not None:
            converted = DepthToCloud(intrinsics, where, self.settings, self.smooth)
            camera = simulated(where, converted, scene=several.solids())
            return SeenSurface(Cloud.empty(), camera, self.settings.voxel or 0.0)
        scene = TableScene.of_box(self.size, middle)
        depth = RenderedScene(intrinsics, where, scene).depth()
        converted = DepthToCloud(intrinsics, where, self.settings, self.smooth)
        seen = untouched(converted, errors, depth, scene.solids[0], site.scenario.detector.r2)
        camera = simulated(where, converted, scene=scene)
        return SeenSurface(Cloud.empty(), camera, seen.spacing, seen.roughness, seen.offset)


@dataclass(frozen=True)
class DepthCamera:
    """The surface as a RealSense camera sees it, in a run with hardware.

    How much lower the detector is to take the cloud, `surface_offset`, is said by
    `python -m mmt_drake.hw.realsense cloud`.

    Attributes:
        extrinsics: YAML file with the camera's pose, from `python -m mmt_drake.hw.realsense calibrate`.
        serial: number of the camera; null takes the first one.
        recording: `.db3` file that is played over and over in place of a camera.
        width: of the camera's images [px].
        height: of the camera's images [px].
        rate: images per second [Hz].
        stale: age from which on a frame no longer counts [s].
        settings: what of a depth image becomes the cloud.
        smooth: over frames; null: each stands alone.
    """

    extrinsics: str | None = None
    serial: str | None = None
    recording: str | None = None
    width: int = 640
    height: int = 480
    rate: int = 30
    stale: Annotated[float, Bound(1.0, "s", OURS)] = 0.25
    settings: CloudSettings = field(default_factory=CloudSettings)
    smooth: TemporalFilter | None = None
    real = True

    def __post_init__(self) -> None:
        if self.extrinsics is None:
            expected = "the file that `python -m mmt_drake.hw.realsense calibrate` wrote"
            raise BadInput("cloud", at="extrinsics", found="nothing", expected=expected)
        if self.serial is not None and self.recording is not None:
            raise BadInput("cloud", at="recording", found=self.recording, expected="nothing beside a serial number")
        _check_rate(self.rate)
        check_number("cloud", "stale", self.stale, least=0.0, open_interval=True)
        refuse_beyond(self, "cloud")

    def surface(self, site: Site) -> SeenSurface:
        """The camera that is connected; beside the operator of two machines there is none.

        Raises:
            BadInput: there is none where it is needed.
        """
        if site.devices.camera is None and site.side != OPERATOR:
            expected = "a run with --hardware, or !SimulatedDepthCamera"
            raise BadInput(site.scenario.name, found="!DepthCamera", expected=expected)
        system = None if site.devices.camera is None else site.devices.camera.system
        return SeenSurface(Cloud.empty(), system, self.settings.voxel or 0.0)


def _check_rate(rate: float) -> None:
    if not _RATES[0] <= rate <= _RATES[1]:
        raise BadInput("cloud", at="rate", found=rate, expected=f"{_RATES[0]:g} to {_RATES[1]:g} Hz")
