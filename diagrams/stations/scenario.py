"""Scenarios: what is built, as dataclasses and as YAML."""

import math
from dataclasses import dataclass, field, replace
from operator import attrgetter
from pathlib import Path
from typing import Any, Literal

from mmt_drake.ceilings import Option, looser_options
from mmt_drake.cloud import ProxySettings
from mmt_drake.cloud.touch import TouchSettings
from mmt_drake.diagrams.stations.carrying import Carrying
from mmt_drake.diagrams.stations.device_options import Franka, Omega
from mmt_drake.diagrams.stations.environment import Environment, ForeignBox
from mmt_drake.diagrams.stations.estimators import EstimatorOptions
from mmt_drake.diagrams.stations.hands import Interactive, Recorded, Scripted
from mmt_drake.diagrams.stations.renderers import ImpedanceReflection, Renderer
from mmt_drake.diagrams.stations.several import SeveralObjects
from mmt_drake.diagrams.stations.shipped import SCENARIOS, shipped
from mmt_drake.diagrams.stations.telerobots import CompliantTip, Panda
from mmt_drake.errors import BadInput
from mmt_drake.estimation.options import RlsOptions
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.learning.options import Learning
from mmt_drake.model_files import with_effects
from mmt_drake.motion.yielding import HandImpedance
from mmt_drake.network.config import ChannelConfig
from mmt_drake.recording import Recording
from mmt_drake.surfaces import Shape
from mmt_drake.typed_yaml import fill, override, parse, read_text

_GREATEST_SEED = 2**52  # seeds of parts are added to it, and counted in float64 by some

_DEVICES = ("operator_device", "telerobot_device", "environment.cloud")

_CODE = ("operator_device.library", "estimator.code", "renderer.code")
"""Keys that name code that runs here."""

_STEPS = (
    ("estimator", "step"),
    ("detector", "period"),
    ("telerobot", "compensation", "step"),
    ("telerobot_device", "compensation", "step"),
)


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
        telerobot: what holds the probe; null: nothing does, and it is where it is commanded to be.
        telerobot_device: the real one in its place, in a run with hardware; the object then is real, too.
        to_telerobot, to_operator: the network, one way and back.
        to_renderer: what is between the hand and the renderer beside it: nothing, if all is as it should be.
        environment: the object and the telerobot's sensors; `!ForeignBox`: by a simulation of another kind;
            `!SeveralObjects`: several of them on a table.
        detector: the telerobot's contact detector.
        touch: touches correct the height of the surface that is seen; null: it is believed.
        estimator: the telerobot's estimator: the thesis's, the one whose model runs freely, or one's own.
        renderer: what the operator feels; `!OwnRenderer`: one's own.
        learner: names physics that the estimator's numbers leave out, while it is felt; null: nobody does.
        carrying: a grip that lifts and carries the object; null: there is none.
        switching: whose contact detector switches the renderer's model: the telerobot's, whose flag crosses the
            network, or a second one beside the operator, which sees the cloud that the network has brought.
        clouds: what is recorded of the point clouds: none, light (1 Hz, 5000 points at most) or full.
    """

    name: str = "setup1"
    seed: int = 0
    step: float = 1e-3
    duration: float | None = 60.0
    operator: Scripted | Recorded | Interactive = field(default_factory=Scripted)
    hand: HandImpedance | None = None
    operator_device: Omega = field(default_factory=Omega)
    telerobot: CompliantTip | Panda | None = None
    telerobot_device: Franka = field(default_factory=Franka)
    to_telerobot: ChannelConfig = field(default_factory=ChannelConfig)
    to_operator: ChannelConfig = field(default_factory=ChannelConfig)
    to_renderer: ChannelConfig = field(default_factory=ChannelConfig)
    environment: Environment | ForeignBox | SeveralObjects = field(default_factory=Environment)
    detector: ProxySettings = ProxySettings()
    touch: TouchSettings | None = None
    estimator: EstimatorOptions = RlsOptions()
    renderer: Renderer = field(default_factory=ImpedanceReflection)
    learner: Learning | None = None
    carrying: Carrying | None = None
    switching: Literal["telerobot", "operator"] = "telerobot"
    clouds: Literal["none", "light", "full"] = "light"

    def __post_init__(self) -> None:
        if not 1e-5 <= self.step <= 0.1:
            raise BadInput("scenario", at="step", found=self.step, expected="a time, 0.00001 to 0.1 s")
        if self.duration is not None and not (math.isfinite(self.duration) and self.duration > 0.0):
            raise BadInput("scenario", at="duration", found=self.duration, expected="a time above 0 s")
        if not 0 <= self.seed <= _GREATEST_SEED:
            raise BadInput("scenario", at="seed", found=self.seed, expected=f"0 to {_GREATEST_SEED}")
        if self.switching == "operator" and not self.renderer.switched:
            expected = "telerobot: !DirectForce renders no model that could be switched"
            raise BadInput("scenario", at="switching", found=self.switching, expected=expected)
        self._check_touch()
        if self.learner is not None:
            self._check_learner()
        if self.carrying is not None:
            self._check_carrying()
        if self.telerobot is not None and (said := self.environment.sensing()) is not None:
            expected = "telerobot.sensor.noise: a telerobot measures by itself"
            raise BadInput(
                "scenario", at=f"environment.{said}", found=getattr(self.environment, said), expected=expected
            )

    def _check_touch(self) -> None:
        """Refuse touches that correct no surface: what is carried or one of several has none that stays."""
        for at, there in (("environment", self.several is not None), ("carrying", self.carrying is not None)):
            if there and self.touch is not None:
                found, expected = "touches that correct the surface", f"null beside this `{at}`"
                raise BadInput("scenario", at="touch", found=found, expected=expected)

    def _check_carrying(self) -> None:
        """Refuse what is not carried, or not felt while it is."""
        world, renderer = self.environment, self.renderer
        known = isinstance(renderer, ImpedanceReflection) and renderer.arm is None and renderer.mu is None
        body = world.object.parameters
        anchored = isinstance(world, ForeignBox) and (body.k1, body.b1) != (0.0, 0.0)
        plain = isinstance(world, SeveralObjects) or world.plain
        for at, bad, found, expected in (
            ("environment.surface", self.shape is not None, "a surface that is not level", "null"),
            ("environment", not plain, "laws or sensors of a !ForeignBox", "none"),
            ("environment.object.parameters", anchored, "k1 or b1 of a !ForeignBox", "0"),
            ("telerobot", self.telerobot is not None, "a telerobot", "null: the grip is at the hand's place"),
            ("learner", self.learner is not None, "a learner", "null"),
            ("renderer", not known, renderer.name, "!ImpedanceReflection without arm and mu"),
        ):
            if bad:
                raise BadInput("scenario", at=at, found=found, expected=f"{expected}, where there is `carrying`")

    def _check_learner(self) -> None:
        """Refuse a learner whose news nobody would take up."""
        chosen = {"estimator": self.estimator, "renderer": self.renderer}
        takes = {"estimator": OutputErrorOptions, "renderer": ImpedanceReflection}
        for name, part in chosen.items():
            if not isinstance(part, takes[name]):
                expected = f"!{takes[name].__name__}, which takes up what a learner finds"
                raise BadInput("scenario", at=name, found=f"!{type(part).__name__}", expected=expected)
        if isinstance(self.renderer, ImpedanceReflection) and self.renderer.structure != "flexible_box":
            expected = "flexible_box: a learner finds laws, and no other structure has any"
            raise BadInput("scenario", at="renderer.structure", found=self.renderer.structure, expected=expected)
        if self.shape is not None:
            expected = "null: laws of a surface that is not level are not learned"
            raise BadInput("scenario", at="learner", found="a learner", expected=expected)

    @property
    def shape(self) -> Shape | None:
        """Of the object's top; None: it is level."""
        return self.environment.surface if isinstance(self.environment, Environment) else None

    @property
    def several(self) -> SeveralObjects | None:
        """The objects where there are several; None: there is one."""
        return self.environment if isinstance(self.environment, SeveralObjects) else None

    @property
    def single(self) -> Environment | ForeignBox:
        """The environment where there is one object.

        Raises:
            BadInput: there are several.
        """
        if isinstance(self.environment, SeveralObjects):
            raise BadInput(self.name, at="environment", found="!SeveralObjects", expected="one object")
        return self.environment

    @property
    def seen_by_operator(self) -> bool:
        """Whether a detector beside the operator says where the surface is, and whether the hand touches it."""
        uneven = self.shape is not None or self.several is not None or self.touch is not None
        return self.switching == "operator" or (uneven and self.renderer.switched)

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
    return scenario.operator.name if replayed is None else replayed.source


def updates_name(scenario: Scenario) -> str | None:
    """How the renderer takes up new parameters, in a word; None for one that has no parameters."""
    updates = scenario.renderer.updates
    return None if updates is None else updates.name


def loosened(scenario: Scenario) -> tuple[Option, ...]:
    """Options of the scenario's devices that are looser than shipped; what is simulated has none."""
    return tuple(option for at in _DEVICES for option in looser_options(attrgetter(at)(scenario), at))


def load_scenario(
    name: str | Path, changes: tuple[str, ...] | list[str] = (), *, trust_library: bool = False
) -> Scenario:
    """Read a scenario.

    Args:
        name: a YAML file, or the name of a shipped scenario.
        changes: `key.sub=value` assignments on top of it.
        trust_library: a file may name code that runs here: `operator_device.library`, `estimator.code` and
            `renderer.code`. A change may always, and a shipped scenario.

    Raises:
        BadInput: no such scenario; an unknown key, type or tag; a value out of its range; code that is not to be
            trusted.
    """
    path = Path(name)
    if str(name) in shipped():
        path, trust_library = SCENARIOS / f"{name}.yaml", True
    elif path.suffix not in (".yaml", ".yml") and not path.exists():
        raise BadInput("scenario", found=str(name), expected=f"a YAML file or one of {', '.join(shipped())}")
    data = parse(read_text(path, "a scenario (YAML)"), str(name))
    if data is None:
        data = {}
    if not isinstance(data, dict):
        raise BadInput(name, found=type(data).__name__, expected="a mapping of keys to values")
    named = [] if trust_library else [(key, *_taken(data, key)) for key in _CODE]
    for change in changes:
        override(data, change)
    for key, part, code in named:
        part_name, _, own = key.partition(".")
        if code is not None and data[part_name] is part and own not in part:
            raise BadInput(
                name,
                at=key,
                found=repr(code),
                expected=f"none in a file, since it is code that runs here: --set {key}=..., or --trust-library if "
                "the file is yours",
            )
    return scenario_from(data, str(name))


def _taken(data: dict[str, Any], key: str) -> tuple[dict[str, Any], object]:
    """The mapping that a key stands in, and what stood there, which is taken out; None: nothing."""
    name, _, own = key.partition(".")
    part = data.get(name)
    return (part, part.pop(own, None)) if isinstance(part, dict) else ({}, None)


def scenario_from(data: dict[str, Any], source: str = "scenario") -> Scenario:
    """A scenario from plain data, as YAML gives it.

    Raises:
        BadInput: as `load_scenario`.
    """
    data, effects = _without_effects(data)
    scenario = fill(Scenario, data, source)
    for at, entries in effects.items():
        scenario = _with_effects(scenario, at, entries, source)
    # These classes know their own step; in a station it is the scenario's.
    for *parts, name in _STEPS:
        said: Any = data
        for part in parts:
            said = said.get(part) or {}
        said = said.get(name, scenario.step)
        if said != scenario.step:
            expected = f"the scenario's step, {scenario.step:g} s, or nothing"
            raise BadInput(source, at=".".join((*parts, name)), found=said, expected=expected)
    return scenario


def _without_effects(data: dict[str, Any]) -> tuple[dict[str, Any], dict[str, object]]:
    """The data without the effects of objects, and these by the names of objects; of the only one it is empty."""
    world = data.get("environment")
    if not isinstance(world, dict):
        return data, {}
    found: dict[str, object] = {}
    things = world.get("things")
    world = _bare(world, "", found)
    if isinstance(things, dict):
        owners = {
            name: _bare(thing, name, found) if isinstance(thing, dict) else thing for name, thing in things.items()
        }
        world = {**world, "things": owners}
    return {**data, "environment": world}, found


def _bare(owner: dict[str, Any], name: str, found: dict[str, object]) -> dict[str, Any]:
    """What has an `object`, without its effects, which are put where they are found."""
    thing = owner.get("object")
    if not isinstance(thing, dict) or "effects" not in thing:
        return owner
    found[name] = thing["effects"]
    return {**owner, "object": {key: value for key, value in thing.items() if key != "effects"}}


def _with_effects(scenario: Scenario, name: str, effects: object, source: str) -> Scenario:
    """The scenario with effects in its object, or the one of this name."""
    world = scenario.environment
    owner = world.things[name] if isinstance(world, SeveralObjects) else world
    path = f"things.{name}." if isinstance(world, SeveralObjects) else ""
    try:
        thing = with_effects(owner.object, effects, source)
        if thing.additions.delay > 0.0:
            raise BadInput(
                source, at="effects", found="time_delay", expected="a delay of the network, to_telerobot.delay"
            )
    except BadInput as error:
        at = f"environment.{path}object.{error.at}"
        raise BadInput(source, at=at, found=error.found, expected=error.expected) from None
    try:
        if isinstance(world, SeveralObjects):
            placed = replace(world.things[name], object=thing)
            return replace(scenario, environment=replace(world, things={**world.things, name: placed}))
        return replace(scenario, environment=replace(world, object=thing))
    except BadInput as error:
        raise BadInput(source, at=f"environment.{error.at}", found=error.found, expected=error.expected) from None
