"""A hypothesis: a model some of whose numbers are free, and the effects that it may have."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from mmt_drake.effects import LIBRARY
from mmt_drake.effects.effect import Effect, Parameter
from mmt_drake.errors import BadInput
from mmt_drake.model.laws import MOST_REMEMBERING
from mmt_drake.model.over import plain
from mmt_drake.model.parameters import NORMAL
from mmt_drake.model.structure import Handed, Structure
from mmt_drake.numeric.arrays import Array, Flags

SKEW = "skew"
WIDEST, FARTHEST = 4.0, 30.0
"""A structural value is sought between its nominal value over this and times this; where it ran into that, FARTHEST."""


_MOVE_SIZES = (0.04, 0.08, 0.16, 0.3)

_MAY_VANISH = ("Fc", "b", "k", "normal_b")
"""Common symbols of what an object may do without."""

_CONSTANTS = {"constant_force": "offset", "force_bias": "F0", "dahl_friction": "Fc"}
"""Effects that stand for a structural parameter which adds to nothing, or that with it are another one
(`presliding_friction`)."""


@dataclass(frozen=True)
class FreeParameter:
    """Where a free number of a hypothesis belongs.

    Attributes:
        effect: name of the effect, or "" for the structure.
        symbol: of the parameter.
        unit: of the parameter.
        low, high: least and greatest value.
        scale: its natural size; steps and differences are in proportion.
        rough: see `Parameter`.
    """

    effect: str
    symbol: str
    unit: str
    low: float
    high: float
    scale: float
    rough: bool = False

    @property
    def key(self) -> tuple[str, str]:
        """Effect and symbol."""
        return self.effect, self.symbol


def _known(model: Structure, effect: str) -> dict[str, float]:
    """The numbers of the curves of an effect that was handed in, by their names."""
    curves = [curve for curve in model.over if curve.effect == effect and curve.at]
    return {symbol: value for c in curves for symbol, value in zip(c.symbols, c.value, strict=True)}


@dataclass(frozen=True)
class Hypothesis:
    """A nominal model, the structural parameters that are free in it, and effects.

    Structural parameters that are 0 in the nominal model count as left out: effects stand for them.

    The last free number is always the skew between the clocks of input and output. No recording can tell an
    offset below its own sampling interval from the instant at which each of its channels was read, so it is a nuisance
    of every fit, bounded and never reported; a delay that is an effect takes its place.

    Attributes:
        nominal: the model handed in, without the effects that it has already.
        skew: the largest skew allowed [s].
        effects: what is added to it, in the order in which they are applied.
        believed: effects that the model handed in has already, with their values there; they are fitted as its
            parameters are.
        held: effect -> values of parameters with a default that are held at something else.
        doubted: parameters of the structure that are fitted though they are given (`Structure.GIVEN`).
        widened: parameters of the structure that are sought as far as FARTHEST.
        reach: spread of the outputs, the least scale of parameters that may be 0 (`Structure.ALWAYS`).
        unseen: parameters of the structure, and `effect.symbol`, that the recordings do not show (`Problem.unseen`).
    """

    nominal: Structure
    skew: float = 0.0
    effects: tuple[Effect, ...] = ()
    held: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    doubted: tuple[str, ...] = ()
    widened: frozenset[str] = frozenset()
    believed: tuple[tuple[Effect, Mapping[str, Any]], ...] = ()
    reach: float = 1.0
    unseen: tuple[str, ...] = ()

    @classmethod
    def of(cls, model: Structure, skew: float = 0.0) -> Hypothesis:
        """The hypothesis that a model handed in is right but for its numbers, those of its effects included."""
        if model.handed is None:
            return cls(model, skew)
        bare = model.handed.bare
        believed = tuple(
            (LIBRARY[name].within(model), {**values, **_known(bare, name)}) for name, values in model.handed.effects
        )
        return cls(bare, skew, believed=believed)

    @property
    def acting(self) -> tuple[Effect, ...]:
        """All effects of its model: those believed, and those added."""
        return (*(effect for effect, _ in self.believed), *self.effects)

    @property
    def names(self) -> tuple[str, ...]:
        """Of the effects added."""
        return tuple(effect.name for effect in self.effects)

    @property
    def label(self) -> str:
        """The names of the effects added, in one; empty for none."""
        return " + ".join(self.names)

    @property
    def key(self) -> frozenset[str]:
        """The set of the effects added."""
        return frozenset(self.names)

    @property
    def free(self) -> tuple[str, ...]:
        """Structural parameters that are fitted: those not 0, unless an effect replaces them without using them.

        And those that are no less there for being 0 (`Structure.ALWAYS`); of one that is a curve the numbers of that.
        """
        gone = {self.nominal.SYMBOLS.get(e.replaces) for e in self.acting if e.replaces and e.replaces not in e.uses}
        gone |= (set(self.nominal.GIVEN) - set(self.doubted)) | set(self.unseen)
        symbols, always = self.nominal.determinable, self.nominal.ALWAYS
        return tuple(
            number
            for s in symbols
            if s not in gone and (s in always or self._size(s) > 0.0)
            for number in self.nominal.numbers_of(s)
        )

    def _size(self, symbol: str) -> float:
        """Magnitude of a structural parameter, of one that is a curve the largest: its mean may be 0."""
        curve = self.nominal.curve(symbol)
        return max(map(abs, (self.nominal.parameter(symbol),) if curve is None else curve.value))

    def fitted_parameters(self, effect: Effect) -> tuple[Parameter, ...]:
        """The parameters of an effect that are fitted: the numbers that a model file must give, or those of a curve."""
        fitted: list[Parameter] = []
        for p in effect.parameters:
            if p.default is None and p.kind == "number" and f"{effect.name}.{p.symbol}" not in self.unseen:
                curve = self.nominal.curve(f"{effect.name}.{p.symbol}")
                fitted += [p] if curve is None else [replace(p, symbol=symbol) for symbol in curve.symbols]
        return tuple(fitted)

    def free_parameters(self, start: Array | None = None) -> tuple[FreeParameter, ...]:
        """The free numbers in order; effects, and what is widened, have the scales of `start` where it is given."""
        result: list[FreeParameter] = []
        may_vanish = {self.nominal.SYMBOLS.get(common) for common in _MAY_VANISH}
        for symbol in self.free:
            value, size = self.nominal.parameter(plain(symbol)), self._size(plain(symbol))
            quantity = self.nominal.determinable[plain(symbol)]
            wide = symbol in self.widened
            # A curve may go far from its mean.
            reach = FARTHEST if wide or plain(symbol) != symbol else WIDEST
            low, high = (-math.inf, math.inf) if quantity.least < 0.0 else (value / reach, value * reach)
            if plain(symbol) in may_vanish:
                low = 0.0
            if high == 0.0:  # of those that may be 0
                high = math.inf
            begun = 0.0 if start is None or not wide else abs(float(start[len(result)]))
            scale = max(begun, size / FARTHEST) if begun else size
            if plain(symbol) in self.nominal.ALWAYS:
                scale = max(scale, self.reach, 0.0 if size > 0.0 else self.nominal.usual(symbol))
            result.append(FreeParameter("", symbol, quantity.unit, low, high, scale))
        for effect in self.acting:
            for p in self.fitted_parameters(effect):
                scale = 1.0 if start is None else abs(float(start[len(result)]))
                result.append(FreeParameter(effect.name, p.symbol, p.unit, *p.bounds, scale or 1.0, p.rough))
        if self.has_skew:
            result.append(FreeParameter("", SKEW, "s", -self.skew, self.skew, self.skew))
        return tuple(result)

    def limits(self, start: Array) -> tuple[Array, Array, Array]:
        """Lower bounds, upper bounds and scales of the free numbers, (k,) each."""
        parameters = self.free_parameters(start)
        low, high, scale = (np.array([getattr(p, name) for p in parameters]) for name in ("low", "high", "scale"))
        return low, high, scale

    def rough(self, start: Array) -> Flags:
        """(k,) of the free numbers those in which a residual is rough (`Parameter.rough`)."""
        return np.array([p.rough for p in self.free_parameters(start)], dtype=bool)

    @property
    def has_skew(self) -> bool:
        """Whether the skew is free."""
        return self.skew > 0.0 and not any(effect.name == "time_delay" for effect in self.acting)

    def base(self) -> Array:
        """The numbers handed in, and no skew; no effect must have been added."""
        return self.vector({}, {})

    def vector(
        self, structure: Mapping[str, float], effects: Mapping[str, Mapping[str, float]], skew: float = 0.0
    ) -> Array:
        """The free numbers from values by name; what was handed in where nothing is said of it.

        Where nothing is said of one of a curve, it is what the parameter is.
        """
        own = [structure.get(symbol, self.nominal.number(symbol)) for symbol in self.free]
        effects = {**{effect.name: values for effect, values in self.believed}, **effects}
        for effect in self.acting:
            values = effects[effect.name]
            own += [values.get(p.symbol, values[plain(p.symbol)]) for p in self.fitted_parameters(effect)]
        return np.array([*own, skew] if self.has_skew else own)

    def moved(self, x: Array, number: int) -> Array:
        """The numbers moved about by a tenth of themselves or so, and no skew; the same for the same `number`."""
        low, high, scale = self.limits(x)
        size = _MOVE_SIZES[number % len(_MOVE_SIZES)]
        found = x + size * scale * np.random.default_rng(number).standard_normal(len(scale))
        if self.has_skew:
            found[-1] = 0.0
        return np.clip(found, low, high)

    def skew_of(self, x: Array) -> float:
        """How much later the output's clock reads than the input's [s]."""
        return float(x[-1]) if self.has_skew else 0.0

    def structure_values(self, x: Array) -> dict[str, float]:
        """Structural parameters in the vector."""
        return dict(zip(self.free, map(float, x), strict=False))

    def effect_values(self, x: Array) -> dict[str, dict[str, Any]]:
        """Effect, believed or added -> its fitted and held parameters; of a curve its numbers and their mean."""
        result, at = {}, len(self.free)
        held = {**{effect.name: values for effect, values in self.believed}, **self.held}
        for effect in self.acting:
            fitted = self.fitted_parameters(effect)
            values: dict[str, Any] = {p.symbol: float(x[at + i]) for i, p in enumerate(fitted)}
            at += len(fitted)
            for p in effect.parameters:
                curve = self.nominal.curve(f"{effect.name}.{p.symbol}")
                if curve is not None:
                    values[p.symbol] = curve.with_values(values).mean
                elif p.default is None and f"{effect.name}.{p.symbol}" in self.unseen:
                    values[p.symbol] = held.get(effect.name, {}).get(p.symbol, p.vanishes_at)
            result[effect.name] = {**held.get(effect.name, {}), **values}
        return result

    def model(self, x: Array) -> Structure:
        """The model with these numbers.

        Raises:
            BadInput: numbers that no such model can have.
        """
        model, handed = self._built(x)
        return replace(model, handed=handed) if handed.bare.over else model

    def handed(self, x: Array) -> Handed:
        """The model as its file would have it, effects in the order in which they are applied; raises as `model`."""
        return self._built(x)[1]

    def _built(self, x: Array) -> tuple[Structure, Handed]:
        model = bare = self.nominal.with_numbers(self.structure_values(x))
        found, applied = self.effect_values(x), []
        if bare.over:
            curves = (c.with_values(found[c.effect]) if c.at and c.effect in found else c for c in bare.over)
            model = bare = replace(bare, over=tuple(curves))
        # In this order because a default may be a number that another effect has added to.
        for effect in sorted(self.acting, key=lambda e: e.adds_to is None):
            values = {s: v for s, v in found[effect.name].items() if plain(s) == s}
            checked = effect.checked(values, model, effect.name)
            model = effect.apply(model, checked)
            applied.append((effect.name, checked))
        return model, Handed(bare, tuple(applied))

    def admits(self, effect: Effect) -> bool:
        """Whether the effect may be added: its block is there, its place free, it is no parameter by another name."""
        nominal = self.nominal
        if not effect.acts_on(nominal) or effect in self.acting or self._is_unseen(effect):
            return False
        if effect.adds_to is not None and nominal.value(effect.adds_to) != 0.0:
            return False
        if any(nominal.value(symbol) == 0.0 for symbol in effect.sought_beside):
            return False
        constant = _CONSTANTS.get(effect.name)
        if constant in self.nominal.ALWAYS or (
            constant is not None and constant in nominal.determinable and self._size(constant) > 0.0
        ):
            return False
        target, uses = effect.replaces or effect.adds_to, effect.uses
        for other in self.acting:
            taken = other.replaces or other.adds_to
            if target is not None and taken == target:
                builds_on = (effect.adds_to and target in other.uses) or (other.adds_to and target in uses)
                if not builds_on:
                    return False
        beside = [e for e in (*self.acting, effect) if e.axis == effect.axis]
        remembering = [e for e in beside if e.law is not None and e.law.remembers]
        return len(remembering) <= MOST_REMEMBERING - nominal.memories

    def _is_unseen(self, effect: Effect) -> bool:
        """Whether an effect acts along an axis of which the recordings say nothing."""
        along = effect.axis == "z" or effect.block == "geometry"
        return along and "z" in self.nominal.AXES and any(symbol in self.unseen for symbol in NORMAL)

    def adding(self, effect: Effect, held: Mapping[str, Any] | None = None) -> Hypothesis:
        """The hypothesis with one more effect."""
        if not self.admits(effect):
            found = f"{effect.name} beside {self.names}"
            raise BadInput("hypothesis", found=found, expected="an effect with a free place")
        return replace(self, effects=(*self.effects, effect), held={**self.held, effect.name: held or {}})

    def without(self, *names: str) -> Hypothesis:
        """The hypothesis with these effects less."""
        rest = tuple(effect for effect in self.effects if effect.name not in names)
        return replace(self, effects=rest, held={k: v for k, v in self.held.items() if k not in names})
