"""The interface of every structure (flexible box, driven body, transmission, Kelvin-Voigt contact) to effects."""

from __future__ import annotations

import math
import re
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, ClassVar, Literal, Self

from mmt_drake.errors import BadInput
from mmt_drake.model.laws import MOST_REMEMBERING, ActiveLaw, Slot
from mmt_drake.model.over import Course, Over, plain
from mmt_drake.numeric.arrays import Array
from mmt_drake.quantities import Checked, Level, Quantity, quantities

#: What a common symbol stands for in a structure that has no such thing.
ABSENT = {
    "m": 0.0,
    "Fc": 0.0,
    "b": 0.0,
    "k": 0.0,
    "k2": 0.0,
    "b2": 0.0,
    "normal_k": 0.0,
    "normal_b": 0.0,
    "normal_m": 0.0,
    "g": 0.0,
    "gain": 1.0,
    "pendulum": 0.0,
    "ratio": 0.0,
    "height": 0.0,
    "surface": 0.0,
    "mu": 0.0,
}

Initial = Literal["rest", "fitted"]
Axis = Literal["", "z"]
"""Along which a law acts: that, or those, along which the structure moves; or the surface normal."""


@dataclass(frozen=True)
class Units:
    """What a structure's position and force are measured in, for reports: `units` in a model file.

    Attributes:
        position: in the place of m.
        force: in the place of N.

    Raises:
        BadInput: something that is no name of a unit.
    """

    position: str = "m"
    force: str = "N"

    def __post_init__(self) -> None:
        for at, name in (("position", self.position), ("force", self.force)):
            if not isinstance(name, str) or not re.fullmatch(r"[^\W\d_]+( [^\W\d_]+)*", name):
                raise BadInput("units", at=at, found=repr(name), expected="letters, as in rad, A or N m")

    def of(self, unit: str) -> str:
        """A unit of m, N, kg and s in these: of rad and N m, `N s/m` is `N m s/rad`, and `kg` is `N m s^2/rad`."""
        if self == Units():
            return unit
        if unit == "N m":  # of gravity on a pendulum: it acts as the force does
            return self.force
        above, _, below = unit.replace("kg", "N s^2/m").partition("/")
        above, below = (
            re.sub(r"\b(m|N)\b", lambda found: self.position if found[0] == "m" else self.force, part)
            for part in (above, below)
        )
        return f"{above}/{below}" if below else above


@dataclass(frozen=True)
class Friction(Checked):
    """Friction at the table (Karnopp 1985).

    The body sticks (v_m = 0) while |v_m| < v_d and the force that friction would have to hold is
    below Fs; otherwise friction is Fd sgn v_m. Fs = Fd and v_d = 0 is Coulomb friction. Along each tangential axis, or
    in the plane, where amounts are norms and sgn v_m is v_m/|v_m| (`FlexibleBoxModel.in_plane`).

    Attributes:
        Fs: break-away level [N].
        Fd: sliding level [N], at most Fs.
        v_d: half-width of the stick band [m/s].

    Raises:
        BadInput: a negative level or band, or Fd above Fs.
    """

    Fs: Level = 0.0
    Fd: Level = 0.0
    v_d: Annotated[float, Quantity("m/s")] = 0.0

    CALLED: ClassVar = "friction"

    @classmethod
    def coulomb(cls, Fc: float) -> Friction:
        """Friction of level Fc [N] whether it holds or slides."""
        return cls(Fs=Fc, Fd=Fc, v_d=0.0)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.Fd > self.Fs:
            raise BadInput("friction", at="Fd", found=self.Fd, expected=f"at most Fs = {self.Fs:g}")


@dataclass(frozen=True)
class Additions(Checked):
    """All that effects have added to a structure beyond its own parameters.

    Attributes:
        laws: compiled laws with their numbers.
        friction: instead of the structure's Coulomb friction, or None.
        gap: total clearance of the contact spring, or of a transmission [m].
        dead_band: total width within which an input does nothing, in its unit.
        delay: by which the force (or output) comes later than the position (or input) [s].
        lag: time constant of the first-order lag behind which an input arrives [s]; who drives a model puts it before
            it (`mmt_drake.motion.delay`), as the delay.
        turn: by which the frame of forces is turned against that of positions, about x, y and z [rad].
        tool: where the tip is, from what was recorded, in the frame of a hand that turns [m]; who drives a model moves
            the motion there (`mmt_drake.motion.hand`), as it delays it.
        course: numbers that change in the course of a recording (`mmt_drake.over`).

    Raises:
        BadInput: a gap, dead band, delay or lag that is negative or not finite; more laws with a memory than there is
            room for.
    """

    laws: tuple[ActiveLaw, ...] = ()
    friction: Friction | None = None
    gap: Annotated[float, Quantity("m")] = 0.0
    dead_band: Annotated[float, Quantity("1")] = 0.0
    delay: Annotated[float, Quantity("s")] = 0.0
    lag: Annotated[float, Quantity("s")] = 0.0
    turn: tuple[float, float, float] = (0.0, 0.0, 0.0)
    tool: tuple[float, float, float] = (0.0, 0.0, 0.0)
    course: Course | None = field(default=None, compare=False, repr=False)

    CALLED: ClassVar = "effects"

    def __post_init__(self) -> None:
        super().__post_init__()
        for part, sensor in (("body", False), ("force sensor", True)):
            count = sum(active.law.remembers and (active.law.slot == Slot.SENSOR) == sensor for active in self.laws)
            if count > MOST_REMEMBERING:
                found = f"{count} effects with a memory of their own on one {part}"
                raise BadInput("effects", found=found, expected=f"{MOST_REMEMBERING} at most")

    @property
    def stiffness(self) -> float:
        """At most added to the body's stiffness by all laws [N/m]."""
        return math.fsum(law.stiffness for law in self.laws)

    @property
    def damping(self) -> float:
        """At most added to the body's damping by all laws [N s/m]."""
        return math.fsum(law.damping for law in self.laws)

    @property
    def lightens(self) -> float:
        """At most taken from the body's mass by all laws [kg]."""
        return math.fsum(law.lightens for law in self.laws)


@dataclass(frozen=True)
class Handed:
    """A model as its file has it: what effects were added to, and these.

    Attributes:
        bare: the model without its effects.
        effects: name and parameters of each, in the order in which they are applied.
    """

    bare: Structure
    effects: tuple[tuple[str, Mapping[str, Any]], ...]


@dataclass(frozen=True, kw_only=True)
class Structure(Checked):
    """Base of the models. Effects change a model through these methods only, so an effect fits every structure.

    A structure's numbers go by the same symbols everywhere: m, Fc, b, k (friction and spring to the world), k2, b2 (the
    contact spring and damper), normal_k, normal_b, normal_m (those of the axis along the surface normal, and what they
    move: nothing), height and mu (of a surface, and the friction of a tip on it), surface (1 where there is one), gain
    (force per unit of the input), ratio (position per unit of the input), g (constant gravity along the output) and
    pendulum (the moment of gravity on it). What stands for each is said by `SYMBOLS`.
    """

    NAME: ClassVar[str]
    """In model files."""
    BLOCKS: ClassVar[tuple[str, ...]]
    """The blocks in which an effect may act."""
    SYMBOLS: ClassVar[Mapping[str, str]]
    """Common symbol -> the structure's own."""
    GIVEN: ClassVar[tuple[str, ...]] = ()
    """Those of them that are known better from elsewhere: fitted only where all is explained, or much more, by it."""
    AXES: ClassVar[tuple[Axis, ...]] = ("",)
    """Along which laws may act."""
    TAKES: ClassVar[tuple[str, ...] | None] = None
    """Effects of its blocks that act in it; None: all of them."""
    ALWAYS: ClassVar[tuple[str, ...]] = ()
    """Its own numbers that are fitted where they are 0, too: 0 does not say that they were left out."""
    additions: Additions = field(default=Additions(), metadata={"in_files": False})
    handed: Handed | None = field(default=None, compare=False, repr=False, metadata={"in_files": False})
    """The origin of `additions`, of a model that was read with effects in it."""
    units: Units | None = field(default=None, compare=False, repr=False, metadata={"in_files": False})
    """What position and force are measured in; None: nobody said."""
    window_s: float | None = field(default=None, compare=False, repr=False, metadata={"in_files": False})
    """Length of the windows over which it is held against recordings [s] (`mmt_drake.windows`); None: whole ones."""
    initial: Initial = field(default="rest", compare=False, repr=False, metadata={"in_files": False})
    """How a body whose output is recorded begins: at rest, or with the position and velocity that fit it best."""
    over: tuple[Over, ...] = field(default=(), metadata={"in_files": False})
    """Its numbers, and those of effects, that are curves over something recorded; where nobody asks over what, a number
    counts as it is among the others."""

    CALLED: ClassVar = "parameters"

    @property
    def determinable(self) -> Mapping[str, Quantity]:
        """The structure's own parameters that a recording can determine."""
        return quantities(type(self))

    @property
    def memories(self) -> int:
        """Number of laws with a memory on the body that it has by itself."""
        return 0

    def unit(self, unit: str) -> str:
        """A unit of m, N, kg and s in the model's own, see `Units.of`."""
        return unit if self.units is None else self.units.of(unit)

    def value(self, symbol: str) -> float:
        """The number that a common symbol stands for, or `ABSENT` where the structure has none."""
        return self.parameter(self.SYMBOLS[symbol]) if symbol in self.SYMBOLS else ABSENT[symbol]

    def with_value(self, symbol: str, value: float) -> Self:
        """The same model with another number for a common symbol."""
        return self.with_parameters(**{self.SYMBOLS[symbol]: value})

    def parameter(self, symbol: str) -> float:
        """A number by the structure's own symbol."""
        return float(getattr(self, symbol))

    def with_parameters(self, **values: Any) -> Self:
        """The same model with numbers replaced, by the structure's own symbols."""
        return replace(self, **values)

    def curve(self, number: str) -> Over | None:
        """The curve of a number of the structure, or of an `effect.symbol`, that has knots; None: it is one number."""
        return next((curve for curve in self.over if curve.number == number and curve.at), None)

    def numbers_of(self, symbol: str) -> tuple[str, ...]:
        """The free numbers that a parameter of the structure is made of: itself, or those of its curve."""
        curve = self.curve(symbol)
        return (symbol,) if curve is None else curve.symbols

    def usual(self, symbol: str) -> float:
        """How large a number of `ALWAYS` may be that is 0, as far as the structure knows; else 0."""
        return 0.0

    def number(self, symbol: str) -> float:
        """`parameter`, or one of those of a curve by its name."""
        curve = self.curve(plain(symbol))
        if curve is None or symbol not in curve.symbols:
            return self.parameter(symbol)
        return curve.value[curve.symbols.index(symbol)]

    def with_numbers(self, values: Mapping[str, float]) -> Self:
        """`with_parameters`, those of curves by their names; the parameter then is the mean of its curve."""
        own = {symbol: value for symbol, value in values.items() if plain(symbol) == symbol}
        curves = tuple(c.with_values(values) if c.at and not c.effect else c for c in self.over)
        means = {c.symbol: c.mean for c in curves if c.at and not c.effect}
        return replace(self.with_parameters(**{**own, **means}), over=curves)

    def with_additions(self, **changes: Any) -> Self:
        """The same model with fields of `additions` replaced."""
        return replace(self, additions=replace(self.additions, **changes))

    def with_law(self, law: ActiveLaw, axis: Axis = "") -> Self:
        """The same model with one more law, along an axis."""
        return self.with_additions(laws=(*self.additions.laws, law))


@dataclass(frozen=True, kw_only=True)
class PositionOut(Structure, ABC):
    """Base of the structures whose recordings are an input and an output: of a body that the input moves."""

    @abstractmethod
    def kernel_vector(self, max_step: float = math.inf) -> Array:
        """The vector that the compiled functions of `mmt_drake.model.driven_body` read."""

    @abstractmethod
    def driving(self, u: Array, x: Array) -> Array:
        """(n,) force with which the input u, (n,), drives the body [N] where the output is x, (n,)."""

    @abstractmethod
    def resisting(self, u: Array, x: Array, acceleration: Array) -> Array:
        """(n,) all that resists the body [N]: what drives it less m x''; (n,) each."""

    @abstractmethod
    def slope(self, x: Array) -> Array:
        """(n,) by how much what drives the body falls with its output x, (n,) [N/m]."""

    def deflection(self, u: Array, x: Array) -> Array:
        """(n,) of its spring [m]; the one to the world unless said."""
        return x

    @abstractmethod
    def carried(self, u: Array) -> Array:
        """(n,) the load of friction where none is recorded [N]; NaN where only the kernels know it."""

    def carried_by(self, drive: Array) -> Array:
        """(n,) the same where it is known what drives the body, `commanded`."""
        return self.carried(drive)

    def commanded(self, time: Array, u: Array, x: Array, v: Array) -> Array:
        """(n,) what drives the body at times [s] where the output is x and its rate v, (n,) each: the input u."""
        return u

    @property
    def needs_load(self) -> bool:
        """Whether it can do nothing without a recorded load."""
        return False
