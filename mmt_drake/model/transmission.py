"""A transmission: position in, position out. The kernels are those of `mmt_drake.model.driven_body`."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from mmt_drake.errors import BadInput
from mmt_drake.model.massless import LONGEST_STEP
from mmt_drake.model.parameters import kernel_step, kernel_vector
from mmt_drake.model.structure import Friction, PositionOut
from mmt_drake.numeric.arrays import Array
from mmt_drake.quantities import Damping, Level, Quantity, quantities


@dataclass(frozen=True)
class TransmissionModel(PositionOut):
    """An output that a spring and a damper pull to where its input has it: gears, a belt, cables, a screw.

    With d = ratio u + offset - x the output x moves by::

        m x'' = k d + b d' - c x' - Fc sgn x' + load T

    Only ratios of m, k, b, c, Fc and load show in a recording: k stays what it is, and with k = 1 a force is how far it
    winds up the drive train. Without a mass (m = 0), as in any slow recording, x is where the forces balance: play and
    friction Fc then both draw a loop over u, of width gap and of width 2 Fc/k, and nothing tells them apart.

    Attributes:
        ratio: of the output to the input, not 0; negative where they turn against each other.
        offset: output where the input is 0 [m]: two encoders have two zeros.
        k: stiffness of the drive train [N/m], > 0.
        b: its damping [N s/m], >= 0.
        m: mass of the output [kg], or inertia, >= 0.
        c: damping of the output against the world [N s/m], >= 0.
        Fc: Coulomb friction of the output [N], >= 0.
        load: force on the output, along +, per unit of the recorded load T; 0: the load only presses.

    Raises:
        BadInput: a value outside these ranges.
    """

    ratio: Annotated[float, Quantity("1", -math.inf)]
    offset: Annotated[float, Quantity("m", -math.inf)] = 0.0
    k: Annotated[float, Quantity("N/m", positive=True)] = 1.0
    b: Damping = 0.0
    m: Annotated[float, Quantity("kg")] = 0.0
    c: Damping = 0.0
    Fc: Level = 0.0
    load: Annotated[float, Quantity("1", -math.inf)] = 0.0

    NAME: ClassVar = "transmission"
    BLOCKS: ClassVar = ("friction", "body", "channel", "drive")
    SYMBOLS: ClassVar = {"m": "m", "Fc": "Fc", "b": "c", "k2": "k", "b2": "b", "ratio": "ratio"}
    ALWAYS: ClassVar = ("offset",)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.ratio == 0.0:
            raise BadInput("parameters", at="ratio", found=0, expected="a number other than 0")

    @property
    def determinable(self) -> Mapping[str, Quantity]:
        """See `Structure.determinable`."""
        return {symbol: quantity for symbol, quantity in quantities(TransmissionModel).items() if symbol != "k"}

    def deflection(self, u: Array, x: Array) -> Array:
        """See `PositionOut.deflection`."""
        beyond = u - np.clip(u, -0.5 * self.additions.dead_band, 0.5 * self.additions.dead_band)
        return self.ratio * beyond + self.offset - x

    def driving(self, u: Array, x: Array) -> Array:
        """See `PositionOut.driving`: as if there were no play, and without the damper."""
        return self.k * self.deflection(u, x)

    def resisting(self, u: Array, x: Array, acceleration: Array) -> Array:
        """See `PositionOut.resisting`."""
        return self.driving(u, x) - self.m * acceleration

    def slope(self, x: Array) -> Array:
        """See `PositionOut.slope`."""
        return np.full_like(x, self.k)

    def carried(self, u: Array) -> Array:
        """See `PositionOut.carried`: none."""
        return np.zeros_like(u)

    @property
    def needs_load(self) -> bool:
        """See `PositionOut.needs_load`."""
        return self.load != 0.0

    def kernel_vector(self, max_step: float = math.inf) -> Array:
        """The vector that the compiled functions read, see `FlexibleBoxModel.kernel_vector`."""
        added, step = self.additions, LONGEST_STEP
        if self.m > 0.0:
            step = kernel_step(self.m - added.lightens, added.stiffness, self.k, self.c + added.damping, self.b)
        body = {"m": self.m, "k2": self.k, "b1": self.c, "b2": self.b}
        drive = {"gain": self.ratio, "offset": self.offset, "normal_k": -1.0, "loaded": self.load}
        friction = added.friction or Friction.coulomb(self.Fc)
        return kernel_vector(added, friction, **body, **drive, max_step=min(max_step, step))
