"""The message by which an estimator tells a renderer what the object is: its numbers, and laws that have a name.

It stands in the place of theta. On the wire it is a vector of one size (`ModelMessage.vector`). Nothing in it is an
address or an index: structure and effects go by a sum over their names, so that two machines need only have the laws
that are told, and one that has not says so.

A law in it may be felt: it is one of the contact, the body or friction whose values give no energy that was not put in
(`Effect.passive`). What the force sensor adds to what is (`SensorError`) corrects an estimator's data and is never
felt; what adds to a number of theta is told by that number.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final, NamedTuple
from zlib import crc32

import numpy as np

from mmt_drake.effects import LIBRARY, Effect
from mmt_drake.effects.wording import law_words
from mmt_drake.errors import BadInput, check_number
from mmt_drake.model.laws import LAW_PARAMETERS, ActiveLaw, Slot
from mmt_drake.model.message_layout import EFFECTS, ENTRY, HEAD, MESSAGE_SIZE, MOST_EFFECTS, OF_SENSOR, SENSOR
from mmt_drake.model.parameters import THETA, BoxParameters, FlexibleBoxModel, NormalContact
from mmt_drake.model.structure import Friction
from mmt_drake.model_files import with_effects
from mmt_drake.numeric.arrays import Array

VERSION: Final = 2
"""Of what is laid out here; a message of another one is refused."""
STRUCTURE: Final = FlexibleBoxModel.NAME
"""The one structure that theta is of."""
_CLEARANCE: Final = "contact_gap"
"""The effect that is felt and no law with a force of its own."""

_SLOTS = (Slot.BODY, Slot.CONTACT, Slot.FRICTION)
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
        deviation: their standard deviations by symbol, where they are known.
    """

    name: str
    parameters: dict[str, float] = field(hash=False)
    deviation: dict[str, float] = field(default_factory=dict, hash=False)

    @property
    def words(self) -> str:
        """As a person reads it: `nonlinear stiffness (k3 = 3e+06 N/m^3)`."""
        name, *numbers = law_words(LIBRARY[self.name])
        told = {number.partition(" ")[0]: number for number in numbers}
        values = (told[symbol].replace("#", f"{value:.3g}") for symbol, value in self.parameters.items())
        return f"{name} ({', '.join(values)})"


class SensorError(NamedTuple):
    """What a force sensor reads along x and y beside the force, by the effects of `SENSOR`.

    Attributes:
        bias: what it reads too much at time 0 [N].
        rate: by how much that grows [N/s].
        gain: of the normal force, that it reads too much [1].
        tau: time constant with which it follows, of a first-order low pass [s].
    """

    bias: float = 0.0
    rate: float = 0.0
    gain: float = 0.0
    tau: float = 0.0

    @property
    def words(self) -> list[str]:
        """As a person reads them, an effect each: `force bias (bias = 0.3 N)`."""
        names = zip(SENSOR, self._asdict().items(), strict=True)
        return [ToldEffect(name, {symbol: value}).words for name, (symbol, value) in names if value != 0.0]


NO_ERROR: Final = SensorError()
"""Of a force sensor that reads what is."""


@dataclass(frozen=True)
class ModelMessage:
    """A model as it crosses the network.

    Attributes:
        theta: (10,) numbers in the order of `THETA`; NaN: not known yet.
        effects: named laws beside them, at most `MOST_EFFECTS`.
        thing: which object it is, a whole number; another one, another object.
        number: of the message, from 1 on; a later one has a greater.
        sensor: what is to be taken off the measured force.

    Raises:
        BadInput: theta is not 10 numbers; numbers that cannot be, be it of the sensor; an effect that is unknown,
            stands twice or beside one that excludes it, or has values that it does not allow. `NotFelt`: an effect that
            is no law of the contact, the body or friction, or whose values are not passive; a clearance beside a law of
            the contact with a memory.
    """

    theta: tuple[float, ...]
    effects: tuple[ToldEffect, ...] = ()
    thing: int = 0
    number: int = 1
    sensor: SensorError = NO_ERROR

    def __post_init__(self) -> None:
        if len(self.theta) != len(THETA):
            raise BadInput(_SOURCE, at="theta", found=f"{len(self.theta)} numbers", expected=len(THETA))
        for symbol, value in zip(THETA, self.theta, strict=True):
            if math.isinf(value):
                raise BadInput(_SOURCE, at=f"theta.{symbol}", found=value, expected="a finite number")
        for name, value in zip(SENSOR, self.sensor, strict=True):
            check_number(_SOURCE, name, value, least=0.0 if name == "force_lag" else -math.inf)
        for name, number, least in (("object", self.thing, 0), ("number", self.number, 1)):
            if isinstance(number, bool) or not isinstance(number, int) or not least <= number < _GREATEST:
                raise BadInput(_SOURCE, at=name, found=number, expected=f"a whole number from {least} on")
        if len(self.effects) > MOST_EFFECTS:
            raise NotFelt(_SOURCE, at="effects", found=len(self.effects), expected=f"{MOST_EFFECTS} at most")
        _ = self.acting

    @property
    def acting(self) -> tuple[tuple[Effect, ActiveLaw], ...]:
        """Its effects that have a law, as that acts in `box_of` its theta; a clearance has none."""
        box = box_of(self.theta)
        for told in self.effects:
            if told.name in LIBRARY:
                effect = LIBRARY[told.name].within(box)
                _check_place(effect)
                self._check_defaults(effect, told.parameters)
        self._check_clearance()
        entries = [{"name": told.name, "parameters": dict(told.parameters)} for told in self.effects]
        model = with_effects(box, entries, _SOURCE)
        for name, values in () if model.handed is None else model.handed.effects:
            passive = LIBRARY[name].passive
            if passive is None or not passive.holds(box, values):
                found = ", ".join(f"{symbol} = {value:g}" for symbol, value in values.items())
                expected = "values that give no energy that was not put in"
                expected += f": {passive.where}" if passive is not None else ", of which nobody knows any"
                raise NotFelt(_SOURCE, at=name, found=found, expected=expected)
        laws = {"": iter(model.additions.laws), "z": iter(model.along_normal.laws)}
        effects = tuple(LIBRARY[told.name] for told in self.effects if told.name != _CLEARANCE)
        return tuple((effect, next(laws[effect.axis])) for effect in effects)

    @property
    def clearance(self) -> float:
        """Of the contact spring [m]."""
        return math.fsum(told.parameters["gap"] for told in self.effects if told.name == _CLEARANCE)

    def _check_clearance(self) -> None:
        """Refuse a clearance beside a law whose memory of the contact stands still within it, and goes on pushing."""
        names = {told.name for told in self.effects}
        for effect in (LIBRARY[name] for name in names if _CLEARANCE in names and name in LIBRARY):
            if effect.law is not None and effect.law.slot == Slot.CONTACT and effect.law.remembers and not effect.axis:
                found, expected = f"{effect.name} beside it", "no law of the contact with a memory"
                raise NotFelt(_SOURCE, at=_CLEARANCE, found=found, expected=expected)

    def _check_defaults(self, effect: Effect, given: Mapping[str, float]) -> None:
        """Refuse numbers that are left to a theta that is not known."""
        if all(map(math.isfinite, self.theta)):
            return
        own = {parameter.symbol for parameter in effect.parameters}
        for parameter in effect.parameters:
            if isinstance(parameter.default, str) and parameter.default not in own and parameter.symbol not in given:
                expected = f"a value: that of {parameter.default} is not known"
                raise BadInput(_SOURCE, at=f"{effect.name}.{parameter.symbol}", found="none", expected=expected)

    def vector(self) -> Array:
        """(MESSAGE_SIZE,) as it crosses the network: `mmt_drake.model.message_layout.MESSAGE`."""
        vector = np.zeros(MESSAGE_SIZE)
        vector[: len(HEAD)] = VERSION, code_of(STRUCTURE), self.thing, self.number
        vector[len(HEAD) : OF_SENSOR.start], vector[OF_SENSOR] = self.theta, self.sensor
        box = box_of(self.theta)
        for i, told in enumerate(self.effects):
            values = LIBRARY[told.name].checked(told.parameters, box, _SOURCE)
            start = EFFECTS + i * ENTRY
            vector[start] = code_of(told.name)
            vector[start + 1 : start + 1 + len(values)] = tuple(values.values())
            first = start + 1 + LAW_PARAMETERS
            vector[first : first + len(values)] = [told.deviation.get(symbol, math.nan) for symbol in values]
        return vector

    @classmethod
    def from_vector(cls, vector: Array) -> ModelMessage | None:
        """The message that a vector is; None: zeros, there is none yet.

        Raises:
            BadInput: another version or structure, an effect that nobody here knows, or as the class.
        """
        if not np.any(vector):
            return None
        version, structure, thing, number = vector[: len(HEAD)]
        if version != VERSION:
            raise BadInput(_SOURCE, at="version", found=f"{version:g}", expected=VERSION)
        if structure != code_of(STRUCTURE):
            raise BadInput(_SOURCE, at="structure", found=f"{structure:.0f}", expected=f"the sum of {STRUCTURE}")
        known = {code_of(name): effect for name, effect in LIBRARY.items()}
        effects = []
        for code, *values in vector[EFFECTS:].reshape(MOST_EFFECTS, ENTRY).tolist():
            if code not in known:
                if code == 0.0:
                    continue
                raise BadInput(_SOURCE, at="effects", found=f"{code:.0f}", expected="the sum of an effect known here")
            effect = known[code]
            symbols = [parameter.symbol for parameter in effect.parameters]
            deviations = zip(symbols, values[LAW_PARAMETERS:], strict=False)
            known_to = {symbol: deviation for symbol, deviation in deviations if math.isfinite(deviation)}
            effects.append(ToldEffect(effect.name, dict(zip(symbols, values, strict=False)), known_to))
        theta, sensor = tuple(vector[len(HEAD) : OF_SENSOR.start].tolist()), SensorError(*vector[OF_SENSOR].tolist())
        return cls(theta, tuple(effects), _whole("object", thing), _whole("number", number), sensor)


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
    """Refuse an effect that is no law beside the numbers of theta."""
    found = f"an effect of the block {effect.block}"
    if effect.block in ("force_sensor", "channel", "geometry", "drive"):
        raise NotFelt(
            _SOURCE, at=effect.name, found=found, expected="one of friction, contact or body: it is never felt"
        )
    if effect.name != _CLEARANCE and (effect.law is None or effect.law.slot not in _SLOTS):
        found, expected = (
            "what is no law with numbers of its own",
            "a law; what adds to a number of theta is told by that",
        )
        raise NotFelt(_SOURCE, at=effect.name, found=found, expected=expected)


def _whole(name: str, number: float) -> int:
    if not (math.isfinite(number) and number == int(number)):
        raise BadInput(_SOURCE, at=name, found=number, expected="a whole number")
    return int(number)
