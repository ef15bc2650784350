"""Model files of robot arms: `structure: multibody`."""

from __future__ import annotations

import dataclasses
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from mmt_drake.arms.laws import ARM_EFFECTS
from mmt_drake.arms.structure import STRUCTURE
from mmt_drake.errors import BadInput
from mmt_drake.model.controller import Controller
from mmt_drake.model_files import controller_data, parse_controller
from mmt_drake.recording.atomic import replacing
from mmt_drake.typed_yaml import fill, known_keys, mapping, parse, read_text

INERTIA = ("m", "mcx", "mcy", "mcz", "Ixx", "Iyy", "Izz", "Ixy", "Ixz", "Iyz")
"""The ten inertial numbers of a link, about its own frame: mass [kg], first moment [kg m], inertia [kg m^2]."""
INERTIA_UNITS = ("kg", *["kg m"] * 3, *["kg m^2"] * 6)
"""Theirs."""

_KEYS = (
    "structure",
    "robot",
    "plant",
    "joints",
    "gravity",
    "position",
    "torque",
    "held",
    "band_hz",
    "controller",
    "links",
    "effects",
)


@dataclass(frozen=True)
class JointEffect:
    """An effect of an arm, and where it acts.

    Attributes:
        name: of the library, or of those that arms alone have.
        where: a joint, a link, or the empty text: on the whole arm.
        parameters: by symbol; N is N m and m is rad where the joint turns.
    """

    name: str
    where: str
    parameters: Mapping[str, float | str]

    def to_data(self) -> dict[str, Any]:
        """As it stands in a file."""
        kind = ARM_EFFECTS[self.name].place
        place: dict[str, str] = {} if kind == "arm" else {kind: self.where}
        return {"name": self.name, **place, "parameters": dict(self.parameters)}


@dataclass(frozen=True)
class Held:
    """What is welded to a link and no part of the robot's file.

    Attributes:
        link: that carries it.
        m: its mass [kg].
        c: its centre in the frame of that link [m], (3,).
        moments: about its centre, along the axes of that link: xx, yy, zz, xy, xz, yz [kg m^2]; none of them: a point.
    """

    link: str
    m: float
    c: tuple[float, float, float] = (0.0, 0.0, 0.0)
    moments: tuple[float, ...] = (0.0,) * 6


@dataclass(frozen=True)
class ArmModel:
    """What a simulation believes of an arm.

    Attributes:
        robot: its file (URDF, SDF or MJCF), or `FILE.py:FUNCTION`, which returns a `MultibodyPlant`.
        source: the model file, for messages.
        joints: that were recorded, in the order of the log; empty: all that move.
        gravity: of the frame that the robot is welded to [m/s^2], (3,).
        column: of the log that tells the torque; empty: the first that is there.
        factor: torque [N m], or force [N] of a joint that slides, for one unit of that column, a number each joint;
            negative where the log counts it the other way; empty: 1.
        position_factor: position [rad], or [m] of a joint that slides, for one unit of the log's, a number each joint;
            empty: 1.
        held: what is welded to the hand.
        band_hz: motion and torque are compared below this frequency [Hz].
        controller: that drives the joints, one for all or one a joint, its gains in N m and rad; empty: none is known.
        links: inertial numbers in the place of those of the file: link -> (10,), see `INERTIA`.
        effects: that it has beside.
    """

    robot: Path
    source: str = "model"
    function: str = ""
    joints: tuple[str, ...] = ()
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)
    column: str = ""
    factor: tuple[float, ...] = ()
    position_factor: tuple[float, ...] = ()
    held: tuple[Held, ...] = ()
    band_hz: float = 8.0
    controller: tuple[Controller, ...] = ()
    links: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    effects: tuple[JointEffect, ...] = ()

    def with_found(self, effects: Sequence[JointEffect], links: Mapping[str, tuple[float, ...]]) -> ArmModel:
        """The model with effects in the place of its own, and inertial numbers of links in the place of the file's."""
        return dataclasses.replace(self, effects=tuple(effects), links={**self.links, **links})


def load_arm_model(path: str | Path) -> ArmModel:
    """Read a model file of an arm; the robot's file is sought beside it.

    Raises:
        BadInput: no such file, no YAML, an unknown key, joint count or effect, a value of the wrong kind.
    """
    source = str(path)
    data = mapping(parse(read_text(path, "a model file (YAML)"), source), source, "the model")
    known_keys(data, _KEYS, source, "")
    if data.get("structure") != STRUCTURE:
        raise BadInput(source, at="structure", found=repr(data.get("structure")), expected=STRUCTURE)
    if ("robot" in data) == ("plant" in data):
        found = "robot and plant" if "robot" in data else "neither robot nor plant"
        raise BadInput(source, found=found, expected="robot: a URDF, SDF or MJCF, or plant: FILE.py:FUNCTION")
    text = str(data.get("robot", data.get("plant")))
    file, _, function = text.partition(":") if "plant" in data else (text, "", "")
    if "plant" in data and not function:
        raise BadInput(source, at="plant", found=text, expected="FILE.py:FUNCTION")
    robot = Path(path).parent / file
    if not robot.is_file():
        raise BadInput(source, at="robot" if "robot" in data else "plant", found=f"{robot}, no file", expected="a file")
    torque = mapping(data.get("torque") or {}, source, "torque")
    known_keys(torque, ("column", "factor"), source, "torque")
    position = mapping(data.get("position") or {}, source, "position")
    known_keys(position, ("factor",), source, "position")
    joints = tuple(map(str, _list(data.get("joints") or [], source, "joints")))
    return ArmModel(
        robot=robot,
        source=source,
        function=function,
        joints=joints,
        gravity=fill(tuple[float, float, float], data.get("gravity", [0.0, 0.0, -9.81]), source, "gravity"),
        column=str(torque.get("column", "")),
        factor=_factors(torque, joints, source, "torque.factor"),
        position_factor=_factors(position, joints, source, "position.factor"),
        held=tuple(
            _held(one, source, f"held[{i}]") for i, one in enumerate(_list(data.get("held") or [], source, "held"))
        ),
        band_hz=_number(data.get("band_hz", 8.0), source, "band_hz", least=0.1),
        controller=_controllers(data.get("controller") or [], source),
        links={
            str(name): _link(v, source, f"links.{name}")
            for name, v in mapping(data.get("links") or {}, source, "links").items()
        },
        effects=tuple(
            _effect(e, source, f"effects[{i}]")
            for i, e in enumerate(_list(data.get("effects") or [], source, "effects"))
        ),
    )


def arm_model_data(model: ArmModel, beside: str | Path) -> dict[str, Any]:
    """The mapping that describes a model, whose robot is named as seen from the folder of a file."""
    name = os.path.relpath(model.robot.resolve(), Path(beside).resolve().parent)
    data: dict[str, Any] = {"structure": STRUCTURE}
    data["plant" if model.function else "robot"] = f"{name}:{model.function}" if model.function else name
    if model.joints:
        data["joints"] = list(model.joints)
    data["gravity"] = list(model.gravity)
    if model.column or model.factor:
        data["torque"] = {k: v for k, v in (("column", model.column), ("factor", list(model.factor))) if v}
    if model.position_factor:
        data["position"] = {"factor": list(model.position_factor)}
    if model.held:
        data["held"] = [{"link": h.link, "m": h.m, "c": list(h.c)} for h in model.held]
    data["band_hz"] = model.band_hz
    if model.controller:
        data["controller"] = [controller_data(one) for one in model.controller]
    if model.links:
        data["links"] = {name: dict(zip(INERTIA, map(float, v), strict=True)) for name, v in model.links.items()}
    if model.effects:
        data["effects"] = [effect.to_data() for effect in model.effects]
    return data


def save_arm_model(model: ArmModel, path: str | Path) -> Path:
    """Write a model file of an arm.

    Raises:
        BadInput: it cannot be written.
    """
    text = yaml.safe_dump(arm_model_data(model, path), sort_keys=False, default_flow_style=None, width=120)
    with replacing(Path(path)) as partial:
        partial.write_text(text)
    return Path(path)


def _factors(data: Mapping[str, Any], joints: Sequence[str], source: str, at: str) -> tuple[float, ...]:
    """What one unit of a column of the log is worth, for each joint."""
    factor = data.get("factor", [])
    every = factor if isinstance(factor, list) else [factor] * max(len(joints), 1)
    factors = fill(tuple[float, ...], every, source, at)
    if 0.0 in factors:
        raise BadInput(source, at=at, found="0", expected="what one unit of the column is worth, not 0")
    return factors


def _controllers(value: object, source: str) -> tuple[Controller, ...]:
    every = [value] if isinstance(value, dict) else _list(value, source, "controller")
    places = ["controller"] if isinstance(value, dict) else [f"controller[{i}]" for i in range(len(every))]
    return tuple(parse_controller(mapping(one, source, at), source, at) for one, at in zip(every, places, strict=True))


def _list(value: object, source: str, at: str) -> list[Any]:
    if not isinstance(value, list):
        raise BadInput(source, at=at, found=type(value).__name__, expected="a list")
    return value


def _number(value: object, source: str, at: str, least: float = -math.inf) -> float:
    number = fill(float, value, source, at)
    if number < least:
        raise BadInput(source, at=at, found=repr(value), expected=f"a number of {least:g} or more")
    return number


def _held(value: object, source: str, at: str) -> Held:
    data = mapping(value, source, at)
    known_keys(data, ("link", "m", "c"), source, at)
    mass = _number(data.get("m"), source, f"{at}.m", least=0.0)
    centre = fill(tuple[float, float, float], data.get("c", [0.0, 0.0, 0.0]), source, f"{at}.c")
    return Held(str(data.get("link")), mass, centre)


def _link(value: object, source: str, at: str) -> tuple[float, ...]:
    data = mapping(value, source, at)
    if set(data) != set(INERTIA):
        raise BadInput(source, at=at, found=", ".join(map(str, data)) or "nothing", expected=", ".join(INERTIA))
    return tuple(_number(data[symbol], source, f"{at}.{symbol}") for symbol in INERTIA)


def _effect(value: object, source: str, at: str) -> JointEffect:
    data = mapping(value, source, at)
    name = data.get("name")
    if name not in ARM_EFFECTS:
        raise BadInput(source, at=f"{at}.name", found=repr(name), expected=f"one of {', '.join(ARM_EFFECTS)}")
    law = ARM_EFFECTS[name]
    place = () if law.place == "arm" else (law.place,)
    known_keys(data, ("name", *place, "parameters"), source, at)
    if place and not isinstance(data.get(law.place), str):
        raise BadInput(source, at=f"{at}.{law.place}", found=repr(data.get(law.place)), expected=f"a {law.place}")
    parameters = mapping(data.get("parameters") or {}, source, f"{at}.parameters")
    if not set(law.symbols) - set(law.optional) <= set(parameters) <= set(law.symbols):
        found = ", ".join(map(str, parameters)) or "none"
        expected = ", ".join(s + " (or not)" if s in law.optional else s for s in law.symbols)
        raise BadInput(source, at=f"{at}.parameters", found=found, expected=expected)
    values: dict[str, float | str] = {
        s: str(parameters[s]) if s == "joint" else _number(parameters[s], source, f"{at}.parameters.{s}")
        for s in law.symbols
        if s in parameters
    }
    return JointEffect(name, str(data.get(law.place, "")), values)
