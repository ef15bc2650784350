"""An object of `ObjectsOnTable`: its model, where it stands, how it hangs in a grip, and what is seen of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from mmt_drake.cloud import Cloud
from mmt_drake.errors import BadInput
from mmt_drake.foreign import grasped as foreign
from mmt_drake.model import grasped_box as own
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.model.structure import Additions, Friction
from mmt_drake.numeric.arrays import Array
from mmt_drake.quantities import Checked, Quantity


@dataclass(frozen=True)
class Hang(Checked):
    """How an object hangs in a grip (`mmt_drake.model.carried`).

    Attributes:
        centre: its centre of mass below the grip [m].
        swing: damping ratio of its free swing.
        mu: friction of the grip.

    Raises:
        BadInput: a value out of range.
    """

    centre: Annotated[float, Quantity("m", 0.005, 0.5)] = 0.05
    swing: Annotated[float, Quantity("", 0.0, 1.0)] = 0.05
    mu: Annotated[float, Quantity("1", positive=True)] = 0.6

    CALLED: ClassVar = "hang"


@dataclass(frozen=True)
class OnTable:
    """An object on the table.

    Attributes:
        model: its structure and numbers.
        at: x, y of the middle of its top before it is moved [m].
        size: its sides along x and y, and its height [m]; of a cylinder the first is the diameter.
        round: it is a cylinder.
        top: height of its top in the table frame [m].
        hang: how it hangs in a grip; None: no grip takes it.
        surface: the cloud of its top before it is moved; None: a square lattice.
        name: where its description stands in the scenario's environment, with a dot behind, for what is refused.
    """

    model: FlexibleBoxModel
    at: tuple[float, float] = (0.0, 0.0)
    size: tuple[float, float, float] = (np.inf, np.inf, np.inf)
    round: bool = False
    top: float = 0.0
    hang: Hang | None = None
    surface: Cloud | None = None
    name: str = ""

    def row(self) -> Array:
        """(on_table.ROW,) as the kernels read it."""
        across = self.size[0] if self.round else self.size[1]
        return np.array([*self.at, self.top, 0.5 * self.size[0], 0.5 * across, float(self.round)])

    def hung(self) -> Array:
        """(grasped_box.HUNG,) as the kernels read it.

        Raises:
            BadInput: effects of what a grip may take.
        """
        if self.hang is None:
            return np.zeros(own.HUNG)
        if self.model.additions != Additions():
            expected = "none: what is carried is a rod without them"
            raise BadInput("environment", at=f"{self.name}object.effects", found="effects", expected=expected)
        return np.array((*self._in_the_air(self.hang), self.hang.mu))

    def _in_the_air(self, hang: Hang) -> tuple[float, ...]:
        body, normal = self.model.parameters, self.model.normal
        return body.m, body.k2, body.b2, normal.k, normal.b, hang.centre, hang.swing

    def rod(self) -> Array:
        """(9,) as the other simulation reads it.

        Raises:
            BadInput: effects, which a rod does not have, or one too light for its steps.
        """
        if self.model.additions != Additions():
            at = f"{self.name}object.effects"
            raise BadInput("environment", at=at, found="effects", expected="none: it is a rod")
        hang = self.hang or Hang(centre=0.5 * self.size[2])
        m, k, b, normal_k, normal_b, centre, swing = self._in_the_air(hang)
        rubs = self.model.friction or Friction.coulomb(self.model.parameters.Fc)
        # The grip sits at the rod's end, where its mass counts a quarter.
        rate = max(b, normal_b) / (0.25 * m) + np.sqrt(max(k, normal_k) / (0.25 * m))
        if rate * foreign.STEP > 1.0:
            expected = f"a heavier body, or a softer hold: steps of {foreign.STEP:g} s cannot follow it"
            raise BadInput("environment", at=f"{self.name}object.parameters.m", found=m, expected=expected)
        return np.array((m, k, b, normal_k, normal_b, centre, swing, rubs.Fd, hang.mu))

    def points(self, spacing: float) -> Array:
        """(n, 3) points of its top [m]; none of one without end, or where the spacing is 0."""
        if self.surface is not None:
            return self.surface.points()
        if spacing == 0.0:
            return np.zeros((0, 3))
        x, y = (
            np.linspace(-0.5, 0.5, max(2, round(side / spacing) + 1)) * side
            for side in (self.size[0], self.size[0] if self.round else self.size[1])
        )
        grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        if self.round:
            grid = grid[np.hypot(*grid.T) <= 0.5 * self.size[0]]
        return np.column_stack([grid + self.at, np.full(len(grid), self.top)])
