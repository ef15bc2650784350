"""A body that an input drives, as a structure of a model file; its kernels stand in `mmt_drake.model.driven_body`."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np

from mmt_drake.errors import BadInput
from mmt_drake.model.controller import Controller
from mmt_drake.model.parameters import kernel_step, kernel_vector
from mmt_drake.model.structure import Friction, PositionOut
from mmt_drake.numeric.arrays import Array
from mmt_drake.quantities import Checked, Damping, Level, Mass, Quantity, Stiffness, quantities

_MOMENT = Quantity("N m", -math.inf)


@dataclass(frozen=True)
class Gravity(Checked):
    """Gravity on a driven body, see `DrivenBodyModel`.

    Attributes:
        kind: constant or pendulum.
        value: [m/s^2] or [N m].

    Raises:
        BadInput: a value that is not finite.
    """

    kind: Literal["constant", "pendulum"]
    value: Annotated[float, _MOMENT]

    CALLED: ClassVar = "gravity"


@dataclass(frozen=True)
class DrivenBodyModel(PositionOut):
    """A body that an input drives: m x'' = gain u + offset - b x' - k x - Fc sgn x' - G(x).

    A servo, a carriage, a falling ball. Only ratios of m, b, k, Fc, offset, a pendulum's moment and gain show in a
    recording. Behind a controller u is what that makes of the input, a goal (`mmt_drake.model.controller`).

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

    m: Mass
    b: Damping = 0.0
    k: Stiffness = 0.0
    Fc: Level = 0.0
    offset: Annotated[float, Quantity("N", -math.inf)] = 0.0
    gain: Annotated[float, Quantity("N", -math.inf)] = 1.0
    gravity: Gravity | None = None
    controller: Controller | None = None
    """Of a closed loop, whose input is the goal; None: the input drives the body itself."""

    NAME: ClassVar = "driven_body"
    BLOCKS: ClassVar = ("friction", "contact", "body", "channel", "drive")
    SYMBOLS: ClassVar = {
        "m": "m",
        "Fc": "Fc",
        "b": "b",
        "k": "k",
        "k2": "k",
        "b2": "b",
        "gain": "gain",
        "pendulum": "pendulum",
    }
    GIVEN: ClassVar = ("pendulum",)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.controller is not None and self.gain == 0.0:
            raise BadInput("parameters", at="gain", found="0 behind a controller", expected="a gain that is not 0")

    @property
    def memories(self) -> int:
        """See `Structure.memories`."""
        return 0 if self.controller is None else int("i" in self.controller.kind)

    @property
    def determinable(self) -> Mapping[str, Quantity]:
        """See `Structure.determinable`."""
        own = {symbol: quantity for symbol, quantity in quantities(DrivenBodyModel).items() if symbol != "gain"}
        return {**own, "pendulum": _MOMENT}

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

    def weight(self, x: Array) -> Array:
        """(n,) G(x) [N]: what gravity pulls against the output x."""
        if self.gravity is None:
            return np.zeros_like(x)
        value = self.gravity.value
        return value * np.sin(x) if self.gravity.kind == "pendulum" else np.full_like(x, self.m * value)

    def driving(self, u: Array, x: Array) -> Array:
        """See `PositionOut.driving`."""
        return self.gain * u

    def commanded(self, time: Array, u: Array, x: Array, v: Array) -> Array:
        """See `PositionOut.commanded`: what a controller makes of its goal, where there is one."""
        return u if self.controller is None else self.controller.commanded(time, u, x, v)

    def resisting(self, u: Array, x: Array, acceleration: Array) -> Array:
        """See `PositionOut.resisting`; its spring is part of it, its weight is not."""
        return self.gain * u + self.offset - self.m * acceleration - self.weight(x)

    def slope(self, x: Array) -> Array:
        """See `PositionOut.slope`."""
        slope: Array = self.parameter("pendulum") * np.cos(x)
        return slope

    def carried(self, u: Array) -> Array:
        """See `PositionOut.carried`: the force of the drive, which its gears carry; a controller's the kernels know."""
        return self.carried_by(u) if self.controller is None else np.full_like(u, math.nan)

    def carried_by(self, u: Array) -> Array:
        """See `PositionOut.carried_by`."""
        return np.abs(self.gain * u)

    def kernel_vector(self, max_step: float = math.inf) -> Array:
        """The vector that the compiled functions read, see `FlexibleBoxModel.kernel_vector`."""
        added, pendulum = self.additions, self.parameter("pendulum")
        if self.controller is not None:
            controlled = self.controller.laws(self.gain, added.dead_band)
            added = replace(added, laws=(*controlled, *added.laws), dead_band=0.0)
        stiffness = self.k + abs(pendulum) + added.stiffness
        step = kernel_step(self.m - added.lightens, stiffness, 0.0, self.b + added.damping, 0.0)
        friction, offset = added.friction or Friction.coulomb(self.Fc), self.offset - self.m * self.value("g")
        body = {"m": self.m, "k1": self.k, "b1": self.b, "pendulum": pendulum}
        # The height of a driven body is its load, see `forces.Surroundings`.
        drive = {"driven": 1.0, "gain": self.gain, "offset": offset, "normal_k": -1.0}
        return kernel_vector(added, friction, **body, **drive, max_step=min(max_step, step))
