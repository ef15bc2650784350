"""Parameters of the flexible object, and the vector form that the compiled kernels read."""

import math
from collections.abc import Mapping
from dataclasses import asdict, astuple, dataclass, field, replace
from typing import ClassVar, Literal, NamedTuple, Self

import numpy as np
from numba import njit

from mmt_drake.errors import BadInput
from mmt_drake.model.law_table import table
from mmt_drake.model.laws import ActiveLaw, Slot
from mmt_drake.model.structure import Additions, Axis, Friction, Structure
from mmt_drake.model.turned import rotation
from mmt_drake.numeric.arrays import Array
from mmt_drake.quantities import Checked, Damping, Level, Mass, Quantity, Stiffness, quantities


class Constants(NamedTuple):
    """A kernel vector as its kernels pass it on, in plain numbers. Up to `laws` this is how the vector is laid out.

    An array as an argument would be counted as a reference to it, by atomic operations that cost more than the physics.

    Attributes:
        driven: 1 where an input drives the body by its force, else 0.
        dead: total width within which an input does nothing.
        loaded: force on the body per unit of a recorded load; else this only presses.
        coarsening: how much longer steps may be that are implicit in friction in the plane; 0: no longer at all.
        laws: in the vector how many there are, and their table is its end. Here its address, contiguous; 0: there are
            none. The vector must outlive this.
        course: where in the vector the numbers stand that change in the course of a recording (`model.over`); 0: none.
        planar: address of `mmt_drake.model.plane_call` where friction is a vector; 0: each tangential axis has its own.
        normal_axis: where in the vector the numbers of `mmt_drake.model.turned` stand, and behind them those of
            `mmt_drake.model.normal_axis`, whose spring and damper are those of the body's vector, be they others in
            their own; what is then given to the body's kernels as the height is the load, so that here normal_k is -1
            and normal_b 0. 0: the normal axis is a spring and a damper alone, and the sensor is not askew.
        inverse_mass: of the body alone [1/kg].
        remembers: a law on the body has a memory.
        smooth: there is no set-valued friction.
        coupled: what one tangential axis does depends on the other, by its friction or by what looks across.
        looks_across: the clearance, or a law, looks at the other axis.
    """

    m: float
    k1: float
    k2: float
    b1: float
    b2: float
    Fs: float
    Fd: float
    v_d: float
    normal_k: float
    normal_b: float
    max_step: float
    driven: float
    gain: float
    offset: float
    pendulum: float
    gap: float
    rest: float
    dead: float
    loaded: float
    coarsening: float
    course: float
    planar: float
    normal_axis: float
    laws: int
    inverse_mass: float
    remembers: bool
    smooth: bool
    coupled: bool
    looks_across: bool


KERNEL_SIZE = LAW_TABLE = Constants._fields.index("laws") + 1
"""Of a kernel vector without laws."""
M, K1, K2, B1, B2, FS, FD, VD, NORMAL_K, NORMAL_B, MAX_STEP, *_ = range(KERNEL_SIZE)
GAP = Constants._fields.index("gap")
*_, COARSENING, COURSE, PLANAR, NORMAL_AXIS, LAWS = range(KERNEL_SIZE)

# A Runge-Kutta step is kept below this fraction of the fastest time constant: the error of a
# forced response at 1 ms then stays below 1e-6 of its amplitude (tests/model/test_flexible_box.py).
_STEP_TIMES_RATE = 0.15

_LEAST_STEP = 1e-6
"""[s]; a body that needs shorter ones costs a thousand steps a tick: nothing that fast shows at 1 kHz."""


@dataclass(frozen=True)
class NormalContact(Checked):
    """Kelvin-Voigt contact along the surface normal, eq. 8.

    Attributes:
        k: stiffness [N/m], >= 0.
        b: damping [N s/m], >= 0.

    Raises:
        BadInput: a value outside these ranges.
    """

    k: Stiffness = 500.0
    b: Damping = 60.0

    CALLED: ClassVar = "normal contact"


@dataclass(frozen=True)
class BoxParameters(Checked):
    """The flexible object of figure 3 of the thesis; the defaults are its set-up 1 (section 4.1).

    Attributes:
        m: body mass [kg], > 0.
        k1: spring from the body to the world [N/m], >= 0.
        k2: contact spring from the probe to the body [N/m], >= 0.
        b1: damper to the world [N s/m], >= 0.
        b2: contact damper [N s/m], >= 0.
        Fc: Coulomb friction at the table [N], >= 0.

    Raises:
        BadInput: a value outside these ranges.
    """

    m: Mass = 1.0
    k1: Stiffness = 0.0
    k2: Stiffness = 500.0
    b1: Damping = 60.0
    b2: Damping = 60.0
    Fc: Level = 0.0

    CALLED: ClassVar = "parameters"


#: The numbers that cross the network, in the order of the `theta` port, and their units.
THETA_UNITS = {
    **{symbol: quantity.unit for symbol, quantity in quantities(BoxParameters).items()},
    **{f"normal_{symbol}": quantity.unit for symbol, quantity in quantities(NormalContact).items()},
    **{symbol: quantity.unit for symbol, quantity in quantities(Friction).items() if symbol != "Fd"},
}
THETA = tuple(THETA_UNITS)
#: Where in a kernel vector each of them stands: Fc as the level of friction while sliding.
THETA_AT = tuple(Constants._fields.index("Fd" if symbol == "Fc" else symbol) for symbol in THETA)
#: Those of eq. 7, which a recording may have without the others, and these with the normal axis.
TANGENTIAL_THETA, SLIDING_THETA = THETA[:6], THETA[:8]
#: How late an estimator takes the measured force to be [s]: delay, time constant of a low pass, their sum, how sure.
FORCE_LATENESS = tuple(f"{name}{of}" for of in ("", "_deviation") for name in ("delay", "lag", "sum"))


def kernel_vector(added: Additions, friction: Friction, **numbers: float) -> Array:
    """A kernel vector of numbers by their names in `Constants`, 0 where there is none, with what effects add."""
    p = np.zeros(KERNEL_SIZE)
    additional = {"gap": added.gap, "dead": added.dead_band, "laws": len(added.laws)}
    for name, number in (numbers | asdict(friction) | additional).items():
        p[Constants._fields.index(name)] = number
    if added.laws:
        p = np.concatenate([p, table(added.laws, LAW_TABLE)])
    if added.course is not None:
        p[COURSE], p[MAX_STEP] = len(p), min(p[MAX_STEP], added.course.max_step)
        p = np.concatenate([p, added.course.numbers()])
    return p


InPlane = Literal["vector", "per_axis"]
_OF_NORMAL = "normal."
NORMAL = tuple(f"{_OF_NORMAL}{symbol}" for symbol in quantities(NormalContact))
"""Symbols of the numbers of the normal axis."""


@dataclass(frozen=True)
class FlexibleBoxModel(Structure):
    """Everything that defines one flexible object: structure, friction, normal axis, and what effects add.

    The normal axis' own numbers are called normal.k and normal.b.
    """

    parameters: BoxParameters = BoxParameters()
    normal: NormalContact = NormalContact()
    friction: Friction | None = None
    """None: Coulomb friction of level `parameters.Fc`."""
    in_plane: InPlane | None = "vector"
    """Whether friction looks at both tangential axes, F = -Fc v/|v|, or each has its own, as in eq. 7.

    None: nobody said. It is a vector then, and a diagnosis looks at both.
    """
    along_normal: Additions = field(default=Additions(), metadata={"in_files": False})
    """All that effects have added to the normal axis."""

    NAME: ClassVar = "flexible_box"
    BLOCKS: ClassVar = ("friction", "contact", "body", "force_sensor", "channel", "geometry")
    SYMBOLS: ClassVar = {
        **{"m": "m", "Fc": "Fc", "b": "b1", "k": "k1", "k2": "k2", "b2": "b2"},
        **{"normal_k": "normal.k", "normal_b": "normal.b"},
    }
    AXES: ClassVar = ("", "z")
    ALWAYS: ClassVar = NORMAL

    @property
    def determinable(self) -> Mapping[str, Quantity]:
        """See `Structure.determinable`."""
        own = zip(NORMAL, quantities(NormalContact).values(), strict=True)
        return {**quantities(BoxParameters), **dict(own)}

    def parameter(self, symbol: str) -> float:
        """See `Structure.parameter`."""
        owner, own = (self.normal, symbol.removeprefix(_OF_NORMAL)) if symbol in NORMAL else (self.parameters, symbol)
        return float(getattr(owner, own))

    def with_parameters(self, **values: float) -> Self:
        """See `Structure.with_parameters`."""
        normal = {s.removeprefix(_OF_NORMAL): values.pop(s) for s in NORMAL if s in values}
        return replace(self, parameters=replace(self.parameters, **values), normal=replace(self.normal, **normal))

    def usual(self, symbol: str) -> float:
        """See `Structure.usual`: what it is along the surface."""
        return self.parameter(f"{symbol.removeprefix(_OF_NORMAL)}2") if symbol in NORMAL else 0.0

    def with_law(self, law: ActiveLaw, axis: Axis = "") -> Self:
        """See `Structure.with_law`; the force sensor's that read every axis read the normal one, too."""
        if axis == "z":
            more = replace(self.along_normal, laws=(*self.along_normal.laws, law))
            return replace(self, along_normal=more)
        model = super().with_law(law)
        return model.with_law(law, "z") if law.law.every_axis else model

    def value(self, symbol: str) -> float:
        """See `Structure.value`."""
        if symbol == "Fc" and self.friction is not None:
            return self.friction.Fd
        return super().value(symbol)

    def with_value(self, symbol: str, value: float) -> Self:
        """See `Structure.with_value`."""
        changed = super().with_value(symbol, value)
        return replace(changed, friction=None) if symbol == "Fc" else changed

    @property
    def couples(self) -> bool:
        """True where what one tangential axis does depends on the other: friction, a clearance, laws in the plane."""
        depends = any(active.law.slot == Slot.FRICTION or active.law.in_plane for active in self.additions.laws)
        depends = depends or self.additions.gap > 0.0 or self._acting_friction.Fs > 0.0
        return self.in_plane != "per_axis" and depends

    @property
    def pushed_at_rest(self) -> bool:
        """True where laws push the body along an axis in which it rests, the tip where it touched."""
        return any(active.pushes_at_rest for active in self.additions.laws)

    def kernel_vector(self, max_step: float = math.inf) -> Array:
        """The vector that the compiled functions read: (KERNEL_SIZE,), and the table of laws if there are any.

        Args:
            max_step: upper bound on the integration step [s]; accuracy may ask for less.

        Raises:
            BadInput: accuracy asks for less than a microsecond: the body is too light, or held too stiffly.
        """
        p, added = self.parameters, self.additions
        step = kernel_step(p.m - added.lightens, p.k1 + added.stiffness, p.k2, p.b1 + added.damping, p.b2)
        body = {"m": p.m, "k1": p.k1, "k2": p.k2, "b1": p.b1, "b2": p.b2}
        normal = {"normal_k": self.normal.k, "normal_b": self.normal.b}
        planar = 0.0
        if self.in_plane == "vector" or self.couples:
            from mmt_drake.model import plane_call  # late: its kernels read what is laid out here

            planar = plane_call.planar("vector")
        numbers = {**body, **normal, "planar": planar, "max_step": min(max_step, step)}
        vector = kernel_vector(added, self._acting_friction, **numbers)
        if self.along_normal == Additions() and not any(added.turn):
            return vector
        from mmt_drake.model.kelvin_voigt import KelvinVoigt  # late, too

        vector[NORMAL_AXIS] = len(vector)
        spring = KelvinVoigt(k=self.normal.k, b=self.normal.b, additions=self.along_normal)
        return np.concatenate([vector, rotation(*added.turn), spring.kernel_vector(max_step)])

    def theta(self) -> Array:
        """The model as the (10,) numbers that cross the network."""
        friction, body = self._acting_friction, astuple(self.parameters)[:-1]
        return np.array([*body, friction.Fd, *astuple(self.normal), friction.Fs, friction.v_d])

    @property
    def _acting_friction(self) -> Friction:
        return self.additions.friction or self.friction or Friction.coulomb(self.parameters.Fc)


@njit(cache=True)
def accurate_step(m: float, k1: float, k2: float, b1: float, b2: float) -> float:
    """The largest integration step [s] that the kernels take for these values.

    The bound (b1 + b2)/m + w, w = sqrt((k1 + k2)/m), is never below the fastest eigenvalue's modulus.
    A lightly damped body keeps the error of every step instead of forgetting it, hence the 2 w.
    """
    w = math.sqrt((abs(k1) + abs(k2)) / m)
    rate = max((abs(b1) + abs(b2)) / m + w, 2.0 * w)
    return _STEP_TIMES_RATE / rate if rate > 0.0 else math.inf


def kernel_step(m: float, k1: float, k2: float, b1: float, b2: float) -> float:
    """`accurate_step`, refused where it is too short."""
    step = accurate_step(m, k1, k2, b1, b2) if m > 0.0 else 0.0
    if not step >= _LEAST_STEP:
        found = f"{m:g} on springs of {k1 + k2:g} and dampers of {b1 + b2:g}"
        expected = f"a heavier body, or a softer hold: steps of {_LEAST_STEP:g} s cannot follow it"
        raise BadInput("parameters", at="m", found=found, expected=expected)
    return step
