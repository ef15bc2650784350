"""Scenarios: what is built, as dataclasses and as YAML."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

from diagrams.devices import Omega
from mmt_drake.cloud import ProxySettings
from mmt_drake.errors import BadInput
from mmt_drake.estimation.options import RlsOptions
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.model.structure import Friction
from mmt_drake.model_files import with_effects
from mmt_drake.motion.placement import Placement
from mmt_drake.motion.yielding import HandImpedance
from mmt_drake.network.config import ChannelConfig
from mmt_drake.recording import Recording
from mmt_drake.rendering.high_band import HighBand
from mmt_drake.rendering.passivity import PassivityControl
from mmt_drake.rendering.updates import AtOnce, Blended, EnergyPermitting, Policy, RateLimited
from mmt_drake.systems.flexible_box import SensorNoise
from mmt_drake.systems.impedance_reflection import ProbeInput
from mmt_drake.typed_yaml import fill, override, parse, read_text

SCENARIOS = Path(__file__).parent / "scenarios"

_MOST_POINTS = 10_000_000
_GREATEST_SEED = 2**52  # seeds of parts are added to it, and counted in float64 by some

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
    """A hand on three Meshcat sliders.

    Attributes:
        bandwidth: of the filter that smooths the sliders [Hz].
    """

    bandwidth: float = 2.0


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
    cloud: SurfaceCloud = SurfaceCloud()


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


@dataclass(frozen=True)
class Scenario:
    """One set-up, complete.

    Attributes:
        name: shown in reports.
        seed: of sensor and cloud noise and both networks. What has a seed of its own is shifted by it.
        step: of the fast path [s].
        duration: of a run [s]; null is the operator's own length, or 60 s.
        operator: whose hand it is, and what it means to do.
        hand: how it yields to what it feels; null: not at all.
        operator_device: what is in a real hand, in a run with hardware; operator and hand then are a person's.
        to_telerobot, to_operator: the network, one way and back.
        to_renderer: what is between the hand and the renderer beside it: nothing, if all is as it should be.
        environment: the object and the telerobot's sensors.
        detector: the telerobot's contact detector.
        estimator: the telerobot's estimator: the thesis's, or the one whose model runs freely.
        renderer: what the operator feels.
        switching: whose contact detector switches the renderer's model: the telerobot's, whose flag crosses the
            network, or a second one beside the operator, which sees the cloud that the network has brought.
        clouds: what is recorded of the point clouds: none, light (1 Hz, 5000 points at most) or full.
    """

    name: str = "setup1"
    seed: int = 0
    step: float = 1e-3
    duration: float | None = 60.0
    operator: Scripted | Recorded | Interactive = Scripted()
    hand: HandImpedance | None = None
    operator_device: Omega = field(default_factory=Omega)
    to_telerobot: ChannelConfig = field(default_factory=ChannelConfig)
    to_operator: ChannelConfig = field(default_factory=ChannelConfig)
    to_renderer: ChannelConfig = field(default_factory=ChannelConfig)
    environment: Environment = Environment()
    detector: ProxySettings = ProxySettings()
    estimator: RlsOptions | OutputErrorOptions = RlsOptions()
    renderer: Renderer = ImpedanceReflection()
    switching: Literal["telerobot", "operator"] = "telerobot"
    clouds: Literal["none", "light", "full"] = "light"

    def __post_init__(self) -> None:
        if not 1e-5 <= self.step <= 0.1:
            raise BadInput("scenario", at="step", found=self.step, expected="a time, 0.00001 to 0.1 s")
        if self.duration is not None and not (math.isfinite(self.duration) and self.duration > 0.0):
            raise BadInput("scenario", at="duration", found=self.duration, expected="a time above 0 s")
        if not 0 <= self.seed <= _GREATEST_SEED:
            raise BadInput("scenario", at="seed", found=self.seed, expected=f"0 to {_GREATEST_SEED}")
        if self.switching == "operator" and isinstance(self.renderer, DirectForce):
            expected = "telerobot: !DirectForce renders no model that could be switched"
            raise BadInput("scenario", at="switching", found=self.switching, expected=expected)

    @property
    def rls(self) -> RlsOptions:
        """The estimator's options where it is the thesis's.

        Raises:
            BadInput: it is another.
        """
        if not isinstance(self.estimator, RlsOptions):
            raise BadInput(self.name, at="estimator", found=f"!{type(self.estimator).__name__}", expected="!RlsOptions")
        return self.estimator


def operator_name(scenario: Scenario, replayed: Recording | None = None) -> str:
    """Whose motion it is, in a word.

    Args:
        scenario: whose hand it is,
        replayed: unless this recording replaces it.
    """
    hand = scenario.operator
    if replayed is not None:
        return replayed.source
    if isinstance(hand, Recorded):
        return hand.file
    return hand.motion if isinstance(hand, Scripted) else "sliders"


_RENDERER_NAMES = {
    ImpedanceReflection: "runge_kutta",
    ProxySpring: "proxy_spring",
    DirectForce: "direct",
    FusedReflection: "fused",
}


def renderer_name(scenario: Scenario) -> str:
    """What the operator feels, in a word."""
    if isinstance(scenario.renderer, DirectForce) and scenario.renderer.passivity is not None:
        return "passivity_controlled"
    return _RENDERER_NAMES[type(scenario.renderer)]


_UPDATES_NAMES: dict[type[Policy], str] = {
    AtOnce: "at_once",
    RateLimited: "rate_limited",
    Blended: "blended",
    EnergyPermitting: "energy_permitting",
}


def updates_name(scenario: Scenario) -> str | None:
    """How the renderer takes up new parameters, in a word; None for one that has no parameters."""
    if isinstance(scenario.renderer, ImpedanceReflection | FusedReflection):
        return _UPDATES_NAMES[type(scenario.renderer.updates)]
    return None


def shipped() -> list[str]:
    """Names of the scenarios that come with the project."""
    return sorted(path.stem for path in SCENARIOS.glob("*.yaml"))


def load_scenario(name: str | Path, changes: tuple[str, ...] | list[str] = ()) -> Scenario:
    """Read a scenario.

    Args:
        name: a YAML file, or the name of a shipped scenario.
        changes: `key.sub=value` assignments on top of it.

    Raises:
        BadInput: no such scenario; an unknown key, type or tag; a value out of its range.
    """
    path = Path(name)
    if str(name) in shipped():
        path = SCENARIOS / f"{name}.yaml"
    elif path.suffix not in (".yaml", ".yml") and not path.exists():
        raise BadInput("scenario", found=str(name), expected=f"a YAML file or one of {', '.join(shipped())}")
    data = parse(read_text(path, "a scenario (YAML)"), str(name))
    if data is None:
        data = {}
    if not isinstance(data, dict):
        raise BadInput(name, found=type(data).__name__, expected="a mapping of keys to values")
    for change in changes:
        override(data, change)
    return scenario_from(data, str(name))


def scenario_from(data: dict[str, Any], source: str = "scenario") -> Scenario:
    """A scenario from plain data, as YAML gives it.

    Raises:
        BadInput: as `load_scenario`.
    """
    data, effects = _without_effects(data)
    scenario = fill(Scenario, data, source)
    if effects is not None:
        scenario = _with_effects(scenario, effects, source)
    # Both classes know their own step; in a station it is the scenario's.
    for part, name in (("estimator", "step"), ("detector", "period")):
        said = (data.get(part) or {}).get(name, scenario.step)
        if said != scenario.step:
            expected = f"the scenario's step, {scenario.step:g} s, or nothing"
            raise BadInput(source, at=f"{part}.{name}", found=said, expected=expected)
    return scenario


def _without_effects(data: dict[str, Any]) -> tuple[dict[str, Any], object]:
    """The data without the key `environment.object.effects`, and what stands there."""
    world = data.get("environment")
    thing = world.get("object") if isinstance(world, dict) else None
    if not isinstance(world, dict) or not isinstance(thing, dict) or "effects" not in thing:
        return data, None
    bare = {key: value for key, value in thing.items() if key != "effects"}
    return {**data, "environment": {**world, "object": bare}}, thing["effects"]


def _with_effects(scenario: Scenario, effects: object, source: str) -> Scenario:
    """The scenario with effects in its object."""
    world = scenario.environment
    try:
        thing = with_effects(world.object, effects, source)
        if thing.additions.delay > 0.0:
            raise BadInput(
                source, at="effects", found="time_delay", expected="a delay of the network, to_telerobot.delay"
            )
    except BadInput as error:
        at = f"environment.object.{error.at}"
        raise BadInput(source, at=at, found=error.found, expected=error.expected) from None
    return replace(scenario, environment=replace(world, object=thing))
