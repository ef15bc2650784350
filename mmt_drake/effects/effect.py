"""An effect: a small declaration."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import Any, Literal, NamedTuple, TypeVar, cast, get_args

from mmt_drake.effects.passivity import Passive
from mmt_drake.errors import BadInput
from mmt_drake.model.laws import LAW_PARAMETERS, ActiveLaw, Law
from mmt_drake.model.structure import Axis, Structure

Values = Mapping[str, Any]
"""Parameters of an effect by symbol: numbers, but for those of `tabulated_force`."""
Ranges = Mapping[str, tuple[float, float]]
"""Least and greatest value of the signals of recordings, by name."""
Model = TypeVar("Model", bound=Structure)

NOT_NEGATIVE = (0.0, math.inf)
"""Bounds of a parameter without a sign."""
PHASES = (0.0, 0.5 * math.pi, math.pi, 1.5 * math.pi)
"""Starts of a phase [rad]: an amplitude is not negative, so that it cannot turn a wrong one about."""

Block = Literal["friction", "contact", "body", "force_sensor", "channel", "geometry", "drive", "any"]
"""The part in which an effect acts; `any`: its parameters say where (`Effect.block_of`)."""


class Scales(NamedTuple):
    """The sizes of things in a recording; starting values of a search are made of these.

    Attributes:
        force: RMS of the tangential force, or of the force that moves a driven body [N].
        velocity: RMS of the sliding velocity [m/s].
        position: RMS of the body's displacement about its mean [m].
        deflection: RMS of the contact spring's deflection [m].
        load: mean normal load while in contact [N].
        mass: of the body in the model [kg].
        stiffness: of the contact spring [N/m].
        frequency: the highest in the motion [Hz].
        duration: of the recording [s].
        step: sampling interval [s].
        peaks: frequencies at which what is left of the force is loudest, loudest first [Hz].
        input: RMS of what drives a body, in its unit.
        ripples: lengths of the way over which what is left of the force comes back, strongest first [m].
        peak_force: the largest that was recorded [N].
        normal: the same of the axis along the surface normal, where it is one of several; its deflection is the depth.
    """

    force: float
    velocity: float
    position: float
    deflection: float
    load: float
    mass: float
    stiffness: float
    frequency: float
    duration: float
    step: float
    peaks: tuple[float, ...] = ()
    input: float = 1.0
    ripples: tuple[float, ...] = ()
    peak_force: float = 1.0
    normal: Scales | None = None


@dataclass(frozen=True)
class Parameter:
    """One number of an effect.

    Attributes:
        symbol: its name in model files.
        unit: SI unit.
        bounds: least and greatest value allowed.
        vanishes_at: the value at which the effect does nothing (of several parameters: all at theirs): a number, or
            the common symbol of the structure whose value it then has.
        default: what it is where a model file does not say: a number, the symbol of another parameter of the effect, or
            a common symbol of the structure (`Structure.value`). None: it must be said, and a search fits it;
            one with a default is left at it by a search.
        kind: `number`; `choice`: one of `choices`; `list`: of numbers within the bounds. A search knows numbers only.
        choices: what a `choice`, or a number that may have few values only, can be.
        shape: whether it says how the effect acts, not how strongly: a search for a slighter effect leaves it alone.
        rough: whether what a model leaves of a recording is rough in it over less than a few hundredths of its size, as
            of a place at which forces jump.
        moment: whether it is the time, from the first sample on, at which something happens once.
        seen_along: tangential axes of a contact that must all be compared for it to be told; else it is nothing.
    """

    symbol: str
    unit: str
    bounds: tuple[float, float] = (-math.inf, math.inf)
    vanishes_at: float | str | tuple[float | str, ...] = 0.0
    default: float | str | None = None
    kind: Literal["number", "choice", "list"] = "number"
    choices: tuple[float | str, ...] = ()
    shape: bool = False
    rough: bool = False
    moment: bool = False
    seen_along: str = ""

    def checked(self, value: object, source: str) -> Any:
        """The value, numbers as float and lists as tuples.

        Raises:
            BadInput: it is not of this kind, or outside the bounds.
        """
        if self.kind == "list":
            if not isinstance(value, list | tuple):
                raise BadInput(source, at=self.symbol, found=repr(value), expected=f"a list of numbers [{self.unit}]")
            return tuple(self._number(number, source, f"{self.symbol}[{i}]") for i, number in enumerate(value))
        checked = value if self.kind == "choice" else self._number(value, source, self.symbol)
        if self.choices and (isinstance(checked, list | dict) or checked not in self.choices):
            expected = f"one of {', '.join(map(str, self.choices))}"
            raise BadInput(source, at=self.symbol, found=repr(value), expected=expected)
        return checked

    def _number(self, value: object, source: str, at: str) -> float:
        low, high = self.bounds
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise BadInput(source, at=at, found=repr(value), expected=f"a number [{self.unit}]")
        if not (abs(value) <= _GREATEST and low <= value <= high):
            limits = f"a finite number [{self.unit}]" if math.isinf(high - low) and low == -high else ""
            expected = limits or f"a finite value from {low:g} to {high:g} {self.unit}"
            raise BadInput(source, at=at, found=_short(value), expected=expected)
        return float(value)


@dataclass(frozen=True)
class Effect:
    """Physics that a simulation may have left out.

    Attributes:
        name: in model files and reports.
        block: the part of the system it belongs to: friction, contact, body, force_sensor, channel or drive.
        family: of laws that are mostly alike; unless said its own name, a family of one.
        elsewhere: name of a structure -> family and block there, where they are others: a transmission has no contact.
        only_in: names of the structures in which it acts; by default all that have its block.
        axis: along which it acts in a structure of several axes: "z", the surface normal; else along those that slide.
        twin_of: the effect that is the same along the surface; acts only where the normal is an axis of its own.
        parameters: its numbers.
        equation: its law in one line.
        source: where the law comes from.
        law: its compiled law, whose p are the parameters in order and then the structure's `uses`.
        change: instead of a law: the model with the effect in it.
        check: refuses values (`BadInput`) that each are allowed, but not together or not in this model.
        block_of: of an effect in the block `any`: where it acts with these values.
        uses: common symbols of the structure that the law reads (before `replaces` takes effect).
        needs: of them those that must not be 0, else there is nothing for it to act on.
        sought_beside: common symbols beside which alone a search tries it: a branch beside a spring that is not there
            draws any fall. A model file may say it all the same.
        inertial: whether a body that moves by itself needs inertia for it: friction that falls with speed makes one
            without jump.
        replaces: the common symbol (Fc, b) whose place it takes, if any.
        adds_to: the common symbol that it adds to, if any.
        holds: effects that are special or limiting cases of it. Numbers of the same symbol are then alike.
        equal_to: effects, or sets of effects joined by " + ", that no recording of one axis can tell from it.
        equal_one_way: the same, of a recording whose motion never turns.
        equal_massless: the same, in a body that moves by itself without a mass.
        near_equal: effect -> where recordings hardly tell it from this one.
        stiffness, damping: what it adds at most to the body's [N/m], [N s/m]; integration steps depend on it.
        passive: where it gives no energy that was not put in; None: nowhere, or nobody knows.
        engages: whether with these values it does anything, or anything but what a simpler effect does, within the
            ranges (least, greatest) of the signals of a recording, by name, and of what it `uses` and does not
            replace: a wall that was never met is none.
        starts: where a search should start, given the scales of a recording: values of the parameters without default,
            and of others that are to be tried too.
    """

    name: str
    block: Block
    parameters: tuple[Parameter, ...]
    equation: str
    source: str
    starts: Callable[[Scales], Sequence[Values]]
    law: Law | None = None
    change: Callable[[Structure, Values], Structure] | None = None
    check: Callable[[Structure, Values, str], None] | None = None
    block_of: Callable[[Values], str] | None = None
    uses: tuple[str, ...] = ()
    needs: tuple[str, ...] = ()
    sought_beside: tuple[str, ...] = ()
    inertial: bool = False
    replaces: str | None = None
    adds_to: str | None = None
    holds: tuple[str, ...] = ()
    equal_to: tuple[str, ...] = ()
    equal_one_way: tuple[str, ...] = ()
    equal_massless: tuple[str, ...] = ()
    near_equal: Mapping[str, str] = field(default_factory=dict, hash=False)
    stiffness: Callable[[Values], float] = lambda values: 0.0
    damping: Callable[[Values], float] = lambda values: 0.0
    passive: Passive | None = None
    engages: Callable[[Values, Ranges], bool] = lambda values, ranges: True
    family: str = ""
    elsewhere: Mapping[str, tuple[str, Block]] = field(default_factory=dict, hash=False)
    only_in: tuple[str, ...] = ()
    axis: Axis = ""
    twin_of: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "family", self.family or self.name)
        if (self.law is None) == (self.change is None):
            raise BadInput(self.name, found="a law and a change, or neither", expected="one of them")
        blocks = get_args(Block)
        if self.block not in blocks:
            raise BadInput(self.name, at="block", found=repr(self.block), expected=f"one of {', '.join(blocks)}")
        count = len(self.parameters) + len(self.uses)
        if self.law is not None and count > LAW_PARAMETERS:
            raise BadInput(self.name, found=f"{count} numbers for its law", expected=f"{LAW_PARAMETERS} at most")

    def within(self, model: Structure) -> Effect:
        """The effect with the family, the block and the axis that it has in a structure."""
        if self.axis not in model.AXES:
            return replace(self, axis="")
        family, block = self.place_in(model.NAME)
        return replace(self, family=family, block=block, elsewhere={}) if self.elsewhere else self

    def place_in(self, structure: str) -> tuple[str, Block]:
        """Family and block that it has in a structure of this name."""
        return self.elsewhere.get(structure, (self.family, self.block))

    @property
    def target(self) -> str:
        """The part of a model that it takes for itself: a common symbol, or its own name."""
        return self.replaces or self.adds_to or self.name

    @property
    def numbers(self) -> int:
        """Number of its parameters that have to be given."""
        return sum(p.default is None for p in self.parameters)

    def is_simpler_than(self, other: Effect) -> bool:
        """True for a law with fewer numbers on the same target as another one, or a special case of it."""
        return self.name in other.holds or (self.target == other.target and self.numbers < other.numbers)

    @property
    def builds_on(self) -> frozenset[str]:
        """Common symbols whose value it reads."""
        own = {p.symbol for p in self.parameters}
        return frozenset(self.uses) | {p.default for p in self.parameters if isinstance(p.default, str)} - own

    def acts_on(self, model: Structure) -> bool:
        """Whether a model has what the effect acts on: its block, what it adds to, and the numbers that it `needs`."""
        there = self.place_in(model.NAME)[1] in ("any", *model.BLOCKS)
        return there and self.is_taken_by(model) and self._lacking(model) is None

    def is_taken_by(self, model: Structure | type[Structure]) -> bool:
        """Whether a structure has a place for it, whatever its blocks."""
        return model.NAME in (self.only_in or (model.NAME,)) and (model.TAKES is None or self.name in model.TAKES)

    def _lacking(self, model: Structure) -> str | None:
        """A common symbol that it acts on and that a model has not, or has 0."""
        if self.twin_of and "z" not in model.AXES:
            return "a normal axis of its own"
        if self.adds_to not in (None, "Fc", *model.SYMBOLS):  # friction has its place in every structure
            return self.adds_to
        needs = ("m", *self.needs) if self.inertial and "m" in model.SYMBOLS else self.needs
        return next((symbol for symbol in needs if model.value(symbol) == 0.0), None)

    def checked(self, values: Mapping[str, object], model: Structure, source: str) -> dict[str, Any]:
        """All parameters in the order declared, defaults filled in.

        Raises:
            BadInput: the model lacks the effect's block; a parameter is missing, unknown, not a number or outside its
                bounds; the values do not go together.
        """
        symbols = [p.symbol for p in self.parameters]
        needed = [p.symbol for p in self.parameters if p.default is None]
        if not set(needed) <= set(values) <= set(symbols):
            perhaps = [symbol for symbol in symbols if symbol not in needed]
            optional = f" (and perhaps {', '.join(perhaps)})" if perhaps else ""
            found = f"parameters {', '.join(values) or 'none'}"
            raise BadInput(source, at="parameters", found=found, expected=", ".join(needed) + optional)
        checked: dict[str, Any] = {}
        for p in self.parameters:
            value = values.get(p.symbol, p.default)
            if isinstance(value, str) and p.symbol not in values:
                value = checked[value] if value in checked else model.value(value)
            checked[p.symbol] = p.checked(value, source)
        block = self.block_of(checked) if self.block_of is not None else self.place_in(model.NAME)[1]
        if block not in model.BLOCKS:
            found = f"an effect of the block {block} in a {model.NAME}"
            raise BadInput(source, found=found, expected=f"one of {', '.join(model.BLOCKS)}")
        if not self.is_taken_by(model):
            expected = f"a {' or '.join(self.only_in)}" if self.only_in else f"one of {', '.join(model.TAKES or ())}"
            raise BadInput(source, found=f"{self.name} in a {model.NAME}", expected=expected)
        if (symbol := self._lacking(model)) is not None:
            raise BadInput(source, found=f"{self.name} in a model without {symbol}", expected=f"{symbol} not 0")
        if self.check is not None:
            self.check(model, checked, source)
        return checked

    def vanished(self, model: Structure) -> dict[str, Any]:
        """Parameters with which the effect does nothing to a model."""

        def known(p: Parameter, at: float | str) -> float | str:
            return model.value(at) if isinstance(at, str) and p.kind != "choice" else at

        return {
            p.symbol: tuple(known(p, value) for value in at) if isinstance(at := p.vanishes_at, tuple) else known(p, at)
            for p in self.parameters
        }

    def may_vanish(self, intervals: Mapping[str, tuple[float, float]]) -> bool:
        """True where numbers within these intervals (symbol -> least, greatest) let the effect do nothing.

        It does nothing where every number that says how strongly it acts is at its vanishing value. Those that vanish
        at a number of the structure that they replace, which may have any value, are then alike: no two are further
        apart than their intervals let the difference of two numbers be. Where the law `uses` that number as well,
        `intervals` has it by its common symbol.
        """
        common: dict[str, list[tuple[float, float]]] = {}
        for p in self.parameters:
            if p.symbol not in intervals or p.shape or p.kind != "number":
                continue
            low, high = intervals[p.symbol]
            if isinstance(p.vanishes_at, str):
                beside = [intervals[p.vanishes_at]] if p.vanishes_at in self.uses else []
                common.setdefault(p.vanishes_at, beside).append((low, high))
            elif not (isinstance(p.vanishes_at, float | int) and low <= p.vanishes_at <= high):
                return False
        return not any(_are_apart(one, other) for some in common.values() for one, other in combinations(some, 2))

    def apply(self, model: Model, values: Values) -> Model:
        """The model with the effect in it.

        Args:
            model: any structure that has the effect's block.
            values: all parameters, as `checked` gives them.
        """
        if self.change is not None:
            return cast(Model, self.change(model, values))  # a change gives the structure that it was given
        assert self.law is not None  # by __post_init__
        numbers = tuple(values[p.symbol] for p in self.parameters) + tuple(model.value(symbol) for symbol in self.uses)
        if self.replaces is not None:
            model = model.with_value(self.replaces, 0.0)
        return model.with_law(ActiveLaw(self.law, numbers, self.stiffness(values), self.damping(values)), self.axis)


def both_ways(signal: str) -> Callable[[Values, Ranges], bool]:
    """The `engages` of an effect that shows only where a signal has either sign, by more than a beginning or an end."""

    def turns(values: Values, ranges: Ranges) -> bool:
        low, high = ranges[signal]
        return min(-low, high) > _TURNS * max(-low, high)

    return turns


_TURNS = 0.05  # of the greater speed: what the lesser one must have for a motion that turns
_GREATEST = 1e300  # the whole numbers of Python have no end


def _short(value: float) -> str:
    return f"{value:g}" if isinstance(value, float) or abs(value) <= _GREATEST else "a number of hundreds of digits"


def _are_apart(one: tuple[float, float], other: tuple[float, float]) -> bool:
    """Whether two numbers differ by more than the 95 % interval of a difference, from an interval of each."""
    if not all(map(math.isfinite, (*one, *other))):
        return False
    (a, half_a), (b, half_b) = ((0.5 * (low + high), 0.5 * (high - low)) for low, high in (one, other))
    return abs(a - b) > math.hypot(half_a, half_b)
