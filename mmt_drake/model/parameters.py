"""Parameters of the flexible object, and the vector form that the compiled kernels read."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Literal, Self

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mmt_drake.errors import BadInput, check_number
from mmt_drake.model.laws import table
from mmt_drake.model.structure import Additions, Friction, Structure

Array = NDArray[np.float64]

#: The numbers that cross the network, in the order of the `theta` port, and their units.
THETA_UNITS = {
    "m": "kg",
    "k1": "N/m",
    "k2": "N/m",
    "b1": "N s/m",
    "b2": "N s/m",
    "Fc": "N",
    "normal_k": "N/m",
    "normal_b": "N s/m",
    "Fs": "N",
    "v_d": "m/s",
}
THETA = tuple(THETA_UNITS)
#: Those of eq. 7, which a recording may have without the others, and these with the normal axis.
TANGENTIAL_THETA, SLIDING_THETA = THETA[:6], THETA[:8]

# Where the kernels find each parameter; the table of laws is the vector's end.
M, K1, K2, B1, B2, FS, FD, VD, NORMAL_K, NORMAL_B, MAX_STEP, DRIVEN, GAIN, OFFSET, PENDULUM, GAP, REST, LAWS = range(18)
KERNEL_SIZE = 18
"""Without laws."""
LAW_TABLE = KERNEL_SIZE

# A Runge-Kutta step is kept below this fraction of the fastest time constant: the error of a
# forced response at 1 ms then stays below 1e-6 of its amplitude (tests/model/test_flexible_box.py).
_STEP_TIMES_RATE = 0.15

_LEAST_STEP = 1e-6
"""[s]; a body that needs shorter ones costs a thousand steps a tick: nothing that fast shows at 1 kHz."""


@dataclass(frozen=True)
class NormalContact:
    """Kelvin-Voigt contact along the surface normal, eq. 8.

    Attributes:
        k: stiffness [N/m], >= 0.
        b: damping [N s/m], >= 0.

    Raises:
        BadInput: a value outside these ranges.
    """

    k: float = 500.0
    b: float = 60.0

    def __post_init__(self) -> None:
        for name in ("k", "b"):
            check_number("normal contact", name, getattr(self, name), least=0.0)


@dataclass(frozen=True)
class BoxParameters:
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

    m: float = 1.0
    k1: float = 0.0
    k2: float = 500.0
    b1: float = 60.0
    b2: float = 60.0
    Fc: float = 0.0

    def __post_init__(self) -> None:
        check_number("parameters", "m", self.m, least=0.0, open_interval=True)
        for name in ("k1", "k2", "b1", "b2", "Fc"):
            check_number("parameters", name, getattr(self, name), least=0.0)


def with_laws(p: Array, additions: Additions) -> Array:
    """The kernel vector with what effects add."""
    p[GAP], p[LAWS] = additions.gap, len(additions.laws)
    return np.concatenate([p, table(additions.laws, LAW_TABLE)]) if additions.laws else p


@dataclass(frozen=True)
class FlexibleBoxModel(Structure):
    """Everything that defines one flexible object: structure, friction, normal axis, and what effects add."""

    parameters: BoxParameters = BoxParameters()
    normal: NormalContact = NormalContact()
    friction: Friction | None = None
    """None: Coulomb friction of level `parameters.Fc`."""

    NAME: ClassVar = "flexible_box"
    BLOCKS: ClassVar = ("friction", "contact", "body", "force_sensor", "channel")
    SYMBOLS: ClassVar = {"m": "m", "Fc": "Fc", "b": "b1", "k": "k1", "k2": "k2", "b2": "b2"}
    PARAMETERS: ClassVar = {symbol: (THETA_UNITS[symbol], False) for symbol in TANGENTIAL_THETA}

    def parameter(self, symbol: str) -> float:
        """See `Structure.parameter`."""
        return float(getattr(self.parameters, symbol))

    def with_parameters(self, **values: float) -> Self:
        """See `Structure.with_parameters`."""
        return replace(self, parameters=replace(self.parameters, **values))

    def value(self, symbol: str) -> float:
        """See `Structure.value`."""
        if symbol == "Fc" and self.friction is not None:
            return self.friction.Fd
        return super().value(symbol)

    def with_value(self, symbol: str, value: float) -> Self:
        """See `Structure.with_value`."""
        changed = super().with_value(symbol, value)
        return replace(changed, friction=None) if symbol == "Fc" else changed

    def kernel_vector(self, max_step: float = math.inf) -> Array:
        """The vector that the compiled functions read: (KERNEL_SIZE,), and the table of laws if there are any.

        Args:
            max_step: upper bound on the integration step [s]; accuracy may ask for less.

        Raises:
            BadInput: accuracy asks for less than a microsecond: the body is too light, or held too stiffly.
        """
        out = np.zeros(KERNEL_SIZE)
        p, added = self.parameters, self.additions
        friction = added.friction or self.friction or Friction.coulomb(p.Fc)
        out[M], out[K1], out[K2], out[B1], out[B2] = p.m, p.k1, p.k2, p.b1, p.b2
        out[FS], out[FD], out[VD] = friction.Fs, friction.Fd, friction.v_d
        out[NORMAL_K], out[NORMAL_B] = self.normal.k, self.normal.b
        step = _step(p.m - added.lightens, p.k1 + added.stiffness, p.k2, p.b1 + added.damping, p.b2)
        out[MAX_STEP] = min(max_step, step)
        return with_laws(out, added)

    def theta(self) -> Array:
        """The model as the (10,) numbers that cross the network."""
        p = self.parameters
        friction = self.additions.friction or self.friction or Friction.coulomb(p.Fc)
        body = p.m, p.k1, p.k2, p.b1, p.b2
        return np.array([*body, friction.Fd, self.normal.k, self.normal.b, friction.Fs, friction.v_d])


@dataclass(frozen=True)
class Gravity:
    """What gravity does to a driven body, see `DrivenBodyModel`.

    Attributes:
        kind: constant or pendulum.
        value: [m/s^2] or [N m].

    Raises:
        BadInput: a value that is not finite.
    """

    kind: Literal["constant", "pendulum"]
    value: float

    def __post_init__(self) -> None:
        check_number("gravity", "value", self.value, least=-math.inf)


@dataclass(frozen=True)
class DrivenBodyModel(Structure):
    """A body that an input drives: m x'' = gain u + offset - b x' - k x - Fc sgn x' - G(x).

    A servo, a carriage, a falling ball. Only ratios of m, b, k, Fc, offset, a pendulum's moment and gain show in a
    recording.

    Attributes:
        m: mass [kg], or inertia, > 0.
        b: damping [N s/m], >= 0.
        k: stiffness [N/m], >= 0.
        Fc: Coulomb friction [N], >= 0.
        offset: constant force [N].
        gain: force per unit of the input.
        gravity: none, constant (G = m value, output up, value in m/s^2) or pendulum (G = value sin(output), in N m, 0
            hanging down).

    Raises:
        BadInput: a value outside these ranges.
    """

    m: float
    b: float = 0.0
    k: float = 0.0
    Fc: float = 0.0
    offset: float = 0.0
    gain: float = 1.0
    gravity: Gravity | None = None

    NAME: ClassVar = "driven_body"
    BLOCKS: ClassVar = ("friction", "contact", "body", "channel")
    SYMBOLS: ClassVar = {"m": "m", "Fc": "Fc", "b": "b", "k": "k", "k2": "k", "b2": "b", "gain": "gain"}
    PARAMETERS: ClassVar = {
        "m": ("kg", False),
        "b": ("N s/m", False),
        "k": ("N/m", False),
        "Fc": ("N", False),
        "offset": ("N", True),
        "pendulum": ("N m", True),
    }
    GIVEN: ClassVar = ("pendulum",)

    def __post_init__(self) -> None:
        check_number("parameters", "m", self.m, least=0.0, open_interval=True)
        for name in ("b", "k", "Fc"):
            check_number("parameters", name, getattr(self, name), least=0.0)
        for name in ("offset", "gain"):
            check_number("parameters", name, getattr(self, name), least=-math.inf)

    def value(self, symbol: str) -> float:
        """See `Structure.value`."""
        if symbol == "g" and self.gravity is not None and self.gravity.kind == "constant":
            return self.gravity.value
        return super().value(symbol)

    def parameter(self, symbol: str) -> float:
        """See `Structure.parameter`; `pendulum` is the moment of gravity [N m], 0 for any other."""
        if symbol == "pendulum":
            return self.gravity.value if self.gravity is not None and self.gravity.kind == "pendulum" else 0.0
        return super().parameter(symbol)

    def with_parameters(self, **values: Any) -> Self:
        """See `Structure.with_parameters`."""
        if "pendulum" in values:
            values["gravity"] = Gravity("pendulum", values.pop("pendulum"))
        return super().with_parameters(**values)

    def kernel_vector(self, max_step: float = math.inf) -> Array:
        """The vector that the compiled functions read, see `FlexibleBoxModel.kernel_vector`."""
        out = np.zeros(KERNEL_SIZE)
        added = self.additions
        friction = added.friction or Friction.coulomb(self.Fc)
        out[M], out[K1], out[B1] = self.m, self.k, self.b
        out[FS], out[FD], out[VD] = friction.Fs, friction.Fd, friction.v_d
        out[DRIVEN], out[GAIN], out[OFFSET] = 1.0, self.gain, self.offset
        out[NORMAL_K] = -1.0  # the height of a driven body is its load, see `body.Surroundings`
        if self.gravity is not None and self.gravity.kind == "constant":
            out[OFFSET] -= self.m * self.gravity.value
        elif self.gravity is not None:
            out[PENDULUM] = self.gravity.value
        stiffness = self.k + abs(out[PENDULUM]) + added.stiffness
        step = _step(self.m - added.lightens, stiffness, 0.0, self.b + added.damping, 0.0)
        out[MAX_STEP] = min(max_step, step)
        return with_laws(out, added)


@njit(cache=True)
def accurate_step(m: float, k1: float, k2: float, b1: float, b2: float) -> float:
    """The largest integration step [s] that the kernels take for these values.

    The bound (b1 + b2)/m + w, w = sqrt((k1 + k2)/m), is never below the fastest eigenvalue's modulus.
    A lightly damped body keeps the error of every step instead of forgetting it, hence the 2 w.
    """
    w = math.sqrt((abs(k1) + abs(k2)) / m)
    rate = max((abs(b1) + abs(b2)) / m + w, 2.0 * w)
    return _STEP_TIMES_RATE / rate if rate > 0.0 else math.inf


def _step(m: float, k1: float, k2: float, b1: float, b2: float) -> float:
    """`accurate_step`, refused where it is too short."""
    step = accurate_step(m, k1, k2, b1, b2) if m > 0.0 else 0.0
    if not step >= _LEAST_STEP:
        found = f"{m:g} on springs of {k1 + k2:g} and dampers of {b1 + b2:g}"
        expected = f"a heavier body, or a softer hold: steps of {_LEAST_STEP:g} s cannot follow it"
        raise BadInput("parameters", at="m", found=found, expected=expected)
    return step


#: What may be wrong with an estimate, see `flaw_of_theta`.
NO_FLAW, NO_MODEL, TOO_STIFF = range(3)


@njit(cache=True)
def flaw_of_theta(theta: Array, least_step: float) -> int:
    """What keeps an estimate from being integrated.

    Args:
        theta: (10,) in the order of `THETA`.
        least_step: smallest step that may be needed [s].

    Returns:
        NO_FLAW; NO_MODEL: a number that is not finite, or a mass that is not positive; TOO_STIFF: a smaller step.
    """
    for i in range(len(theta)):
        if not math.isfinite(theta[i]):
            return NO_MODEL
    m, k1, k2, b1, b2 = theta[0], theta[1], theta[2], theta[3], theta[4]
    if not m > 0.0:
        return NO_MODEL
    return TOO_STIFF if accurate_step(m, k1, k2, b1, b2) < least_step else NO_FLAW


@njit(cache=True)
def write_theta(theta: Array, max_step: float, p: Array) -> None:
    """Make `p` the kernel vector of an estimate without a flaw; a negative Fc counts as none, an Fs below Fc as Fc.

    Args:
        theta: (10,) in the order of `THETA`.
        max_step: upper bound on the integration step [s].
        p: (KERNEL_SIZE,).
    """
    m, k1, k2, b1, b2, Fc, normal_k, normal_b, Fs, v_d = theta
    p[:] = 0.0
    p[M], p[K1], p[K2], p[B1], p[B2] = m, k1, k2, b1, b2
    p[FD] = max(Fc, 0.0)
    p[FS], p[VD] = max(Fs, p[FD]), max(v_d, 0.0)
    p[NORMAL_K], p[NORMAL_B] = normal_k, normal_b
    p[MAX_STEP] = min(max_step, accurate_step(m, k1, k2, b1, b2))


@njit(cache=True)
def adopt_theta(theta: Array, max_step: float, least_step: float, p: Array) -> bool:
    """`write_theta` for an estimate without a flaw, see `flaw_of_theta`; otherwise `p` stays.

    Returns:
        Whether the estimate can be integrated.
    """
    if flaw_of_theta(theta, least_step) != NO_FLAW:
        return False
    write_theta(theta, max_step, p)
    return True
