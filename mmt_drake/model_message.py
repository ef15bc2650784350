"""The message by which an estimator tells a renderer what the object is: its numbers, and laws that have a name.

It stands in the place of theta. On the wire it is a vector of one size (`ModelMessage.vector`), in recordings and for
people JSON. Nothing in it is an address or an index: structure and effects go by a sum over their names, so that two
machines need only have the laws that are told, and one that has not says so.

It holds what may be felt and nothing else: a law of the contact, the body or friction along the surface whose values
give no energy that was not put in (`Effect.passive`). A law of the sensor or the channel corrects an estimator's data
and is never felt; what adds to a number of theta is told by that number.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final
from zlib import crc32

import numpy as np

from mmt_drake.effects import LIBRARY, Effect
from mmt_drake.errors import BadInput
from mmt_drake.model.laws import LAW_PARAMETERS, ActiveLaw, Slot
from mmt_drake.model.parameters import THETA, BoxParameters, FlexibleBoxModel, NormalContact
from mmt_drake.model.structure import Friction
from mmt_drake.model_files import with_effects
from mmt_drake.numeric.arrays import Array
from mmt_drake.typed_yaml import known_keys

VERSION: Final = 1
"""Of what is laid out here; a message of another one is refused."""
MOST_EFFECTS: Final = 2
"""That one message may tell."""
STRUCTURE: Final = FlexibleBoxModel.NAME
"""The one structure that theta is of."""

_HEAD = ("version", "structure", "object", "number")
_ENTRY = 1 + LAW_PARAMETERS  # of an effect in the vector: which one, its values
_EFFECTS = len(_HEAD) + len(THETA)
MESSAGE_SIZE: Final = _EFFECTS + MOST_EFFECTS * _ENTRY
"""Of the vector."""

_SLOTS = (Slot.BODY, Slot.CONTACT, Slot.FRICTION)
_KEYS = (*_HEAD, "theta", "deviations", "effects")
_GREATEST = 2**53  # whole numbers that float64 holds
_SOURCE = "model message"


class NotFelt(BadInput):
    """A message tells a law that is known and must not, or cannot, be felt."""


@dataclass(frozen=True)
class ToldEffect:
    """A law by its name.

    Attributes:
        name: of the library.
        parameters: its values by symbol.
        deviations: standard deviations of those that were estimated, in their units.
    """

    name: str
    parameters: dict[str, float] = field(hash=False)
    deviations: dict[str, float] = field(default_factory=dict, hash=False)


@dataclass(frozen=True)
class ModelMessage:
    """A model as it crosses the network.

    Attributes:
        theta: (10,) numbers in the order of `THETA`; NaN: not known yet.
        deviations: (10,) their standard deviations; empty: nobody says. Not in the vector: nobody feels them.
        effects: named laws beside them, at most `MOST_EFFECTS`.
        thing: which object it is, a whole number; another one, another object.
        number: of the message, from 1 on; a later one has a greater.

    Raises:
        BadInput: theta is not 10 numbers; numbers or deviations that cannot be; an effect that is unknown, stands twice
            or beside one that excludes it, or has values that it does not allow. `NotFelt`: an effect that is no law of
            the contact, the body or friction along the surface, or whose values are not passive.
    """

    theta: tuple[float, ...]
    deviations: tuple[float, ...] = ()
    effects: tuple[ToldEffect, ...] = ()
    thing: int = 0
    number: int = 1

    def __post_init__(self) -> None:
        _sized("theta", self.theta, (len(THETA),))
        _sized("deviations", self.deviations, (0, len(THETA)))
        for name, number, least in (("object", self.thing, 0), ("number", self.number, 1)):
            if isinstance(number, bool) or not isinstance(number, int) or not least <= number < _GREATEST:
                raise BadInput(_SOURCE, at=name, found=number, expected=f"a whole number from {least} on")
        if len(self.effects) > MOST_EFFECTS:
            raise NotFelt(_SOURCE, at="effects", found=len(self.effects), expected=f"{MOST_EFFECTS} at most")
        for told in self.effects:
            for symbol, deviation in told.deviations.items():
                number = isinstance(deviation, int | float) and math.isfinite(deviation)
                if symbol not in told.parameters or not (number and deviation >= 0.0):
                    expected = f"deviations, not below 0, of {', '.join(told.parameters)}"
                    raise BadInput(_SOURCE, at=told.name, found=f"{symbol}: {deviation}", expected=expected)
        _ = self.laws

    @property
    def laws(self) -> tuple[ActiveLaw, ...]:
        """The laws of its effects, in their order, as they act in `box_of` its theta."""
        box = box_of(self.theta)
        for told in self.effects:
            if told.name in LIBRARY:
                effect = LIBRARY[told.name].within(box)
                _check_place(effect)
                self._check_defaults(effect, told.parameters)
        entries = [{"name": told.name, "parameters": dict(told.parameters)} for told in self.effects]
        model = with_effects(box, entries, _SOURCE)
        for name, values in () if model.handed is None else model.handed.effects:
            passive = LIBRARY[name].passive
            if passive is None or not passive.holds(box, values):
                found = ", ".join(f"{symbol} = {value:g}" for symbol, value in values.items())
                expected = "values that give no energy that was not put in"
                expected += f": {passive.where}" if passive is not None else ", of which nobody knows any"
                raise NotFelt(_SOURCE, at=name, found=found, expected=expected)
        return model.additions.laws

    def _check_defaults(self, effect: Effect, given: Mapping[str, float]) -> None:
        """Refuse numbers that are left to a theta that is not known."""
        if all(map(math.isfinite, self.theta)):
            return
        own = {parameter.symbol for parameter in effect.parameters}
        for parameter in effect.parameters:
            if isinstance(parameter.default, str) and parameter.default not in own and parameter.symbol not in given:
                expected = f"a value: that of {parameter.default} is not known"
                raise BadInput(_SOURCE, at=f"{effect.name}.{parameter.symbol}", found="none", expected=expected)

    # ------------------------------------------------------------------------------------------------- on the wire
    def vector(self) -> Array:
        """(MESSAGE_SIZE,) as it crosses the network: head, theta, and for each effect which and its values."""
        vector = np.zeros(MESSAGE_SIZE)
        vector[: len(_HEAD)] = VERSION, code_of(STRUCTURE), self.thing, self.number
        vector[len(_HEAD) : _EFFECTS] = self.theta
        box = box_of(self.theta)
        for i, told in enumerate(self.effects):
            values = LIBRARY[told.name].checked(told.parameters, box, _SOURCE)
            start = _EFFECTS + i * _ENTRY
            vector[start] = code_of(told.name)
            vector[start + 1 : start + 1 + len(values)] = tuple(values.values())
        return vector

    @classmethod
    def from_vector(cls, vector: Array) -> ModelMessage | None:
        """The message that a vector is; None: zeros, there is none yet.

        Raises:
            BadInput: another version or structure, an effect that nobody here knows, or as the class.
        """
        if not np.any(vector):
            return None
        version, structure, thing, number = vector[: len(_HEAD)]
        if version != VERSION:
            raise BadInput(_SOURCE, at="version", found=f"{version:g}", expected=VERSION)
        if structure != code_of(STRUCTURE):
            raise BadInput(_SOURCE, at="structure", found=f"{structure:.0f}", expected=f"the sum of {STRUCTURE}")
        known = {code_of(name): effect for name, effect in LIBRARY.items()}
        effects = []
        for code, *values in vector[_EFFECTS:].reshape(MOST_EFFECTS, _ENTRY).tolist():
            if code not in known:
                if code == 0.0:
                    continue
                raise BadInput(_SOURCE, at="effects", found=f"{code:.0f}", expected="the sum of an effect known here")
            effect = known[code]
            symbols = [parameter.symbol for parameter in effect.parameters]
            effects.append(ToldEffect(effect.name, dict(zip(symbols, values, strict=False))))
        theta = tuple(vector[len(_HEAD) : _EFFECTS].tolist())
        return cls(theta, (), tuple(effects), _whole("object", thing), _whole("number", number))

    # ---------------------------------------------------------------------------------------------------- for people
    def json(self) -> str:
        """One line of JSON; what is not known is null."""
        data: dict[str, Any] = dict(zip(_HEAD, (VERSION, STRUCTURE, self.thing, self.number), strict=True))
        data["theta"] = _by_symbol(self.theta)
        if self.deviations:
            data["deviations"] = _by_symbol(self.deviations)
        data["effects"] = [
            {"name": told.name, "parameters": dict(told.parameters)}
            | ({"deviations": dict(told.deviations)} if told.deviations else {})
            for told in self.effects
        ]
        return json.dumps(data, allow_nan=False)

    @classmethod
    def from_json(cls, text: str) -> ModelMessage:
        """The message that a line of JSON is.

        Raises:
            BadInput: no JSON, an unknown key, version or structure, or as the class.
        """
        try:
            data = json.loads(text)
        except ValueError as error:
            raise BadInput(_SOURCE, found=f"no JSON ({error})", expected="a mapping") from None
        data = _mapping(data, "the message")
        known_keys(data, _KEYS, _SOURCE, "")
        for name, expected in (("version", VERSION), ("structure", STRUCTURE)):
            if data.get(name) != expected:
                raise BadInput(_SOURCE, at=name, found=repr(data.get(name)), expected=expected)
        theta = _numbers(data.get("theta"), "theta")
        deviations = _numbers(data["deviations"], "deviations") if "deviations" in data else ()
        effects = data.get("effects", [])
        if not isinstance(effects, list):
            raise BadInput(_SOURCE, at="effects", found=type(effects).__name__, expected="a list")
        thing, number = data.get("object"), data.get("number")
        return cls(theta, deviations, tuple(_named(effect, i) for i, effect in enumerate(effects)), thing, number)  # type: ignore[arg-type]  # refused there


UNKNOWN_THETA: Final = (math.nan,) * len(THETA)
"""Numbers of which none is known yet."""


def code_of(name: str) -> float:
    """What stands for a name in a vector: its CRC-32, never 0 for a name that there is."""
    return float(crc32(name.encode()))


def box_of(theta: Sequence[float]) -> FlexibleBoxModel:
    """The object of these (10,) numbers, in which laws are checked.

    Estimates scatter about zero: what is below counts as 0. Where one is not known, all are taken to be such that the
    least is passive in it: no damper, no friction.
    """
    if not all(map(math.isfinite, theta)) or not theta[0] > 0.0:
        return FlexibleBoxModel(BoxParameters(m=1.0, k1=0.0, k2=1.0, b1=0.0, b2=1.0), NormalContact(1.0, 0.0))
    m, k1, k2, b1, b2, Fc, k, b, Fs, v_d = (max(number, 0.0) for number in theta)
    friction = Friction(Fs=max(Fs, Fc), Fd=Fc, v_d=v_d)
    return FlexibleBoxModel(BoxParameters(m, k1, k2, b1, b2, Fc), NormalContact(k, b), friction=friction)


def _check_place(effect: Effect) -> None:
    """Refuse an effect that is no law along the surface."""
    found = f"an effect of the block {effect.block}"
    if effect.block in ("force_sensor", "channel", "geometry", "drive"):
        raise NotFelt(
            _SOURCE, at=effect.name, found=found, expected="one of friction, contact or body: it is never felt"
        )
    if effect.law is None or effect.axis or effect.law.slot not in _SLOTS:
        found = "an effect along the surface normal" if effect.axis else "what is no law with numbers of its own"
        expected = "a law along the surface; what adds to a number of theta is told by that"
        raise NotFelt(_SOURCE, at=effect.name, found=found, expected=expected)


def _sized(name: str, numbers: Sequence[float], sizes: tuple[int, ...]) -> None:
    if len(numbers) not in sizes:
        raise BadInput(_SOURCE, at=name, found=f"{len(numbers)} numbers", expected=sizes[-1])
    for symbol, number in zip(THETA, numbers, strict=False):
        if math.isinf(number) or (name == "deviations" and number < 0.0):
            raise BadInput(_SOURCE, at=f"{name}.{symbol}", found=number, expected="a finite number")


def _whole(name: str, number: float) -> int:
    if not (math.isfinite(number) and number == int(number)):
        raise BadInput(_SOURCE, at=name, found=number, expected="a whole number")
    return int(number)


def _by_symbol(numbers: Sequence[float]) -> dict[str, float | None]:
    return {s: None if math.isnan(number) else number for s, number in zip(THETA, numbers, strict=True)}


def _numbers(data: object, name: str) -> tuple[float, ...]:
    data = _mapping(data, name)
    if set(data) != set(THETA):
        raise BadInput(_SOURCE, at=name, found=", ".join(data) or "nothing", expected=", ".join(THETA))
    for symbol, number in data.items():
        if number is not None and (isinstance(number, bool) or not isinstance(number, int | float)):
            raise BadInput(_SOURCE, at=f"{name}.{symbol}", found=repr(number), expected="a number, or null")
    return tuple(math.nan if data[symbol] is None else float(data[symbol]) for symbol in THETA)


def _named(data: object, i: int) -> ToldEffect:
    at = f"effects[{i}]"
    data = _mapping(data, at)
    known_keys(data, ("name", "parameters", "deviations"), _SOURCE, at)
    name = data.get("name")
    if not isinstance(name, str) or name not in LIBRARY:
        raise BadInput(_SOURCE, at=f"{at}.name", found=repr(name), expected=f"one of {', '.join(LIBRARY)}")
    values, deviations = (_mapping(data.get(key, {}), f"{at}.{key}") for key in ("parameters", "deviations"))
    return ToldEffect(name, values, deviations)


def _mapping(data: object, at: str) -> dict[str, Any]:
    if not isinstance(data, dict):
        raise BadInput(_SOURCE, at=at, found=type(data).__name__, expected="a mapping of names to values")
    return data
