"""Surfaces in closed form, as a scenario has them."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

import numpy as np

from mmt_drake.cloud.cloud import Cloud
from mmt_drake.cloud.plane import plane
from mmt_drake.numeric.arrays import Array
from mmt_drake.quantities import Checked, Length, Quantity
from mmt_drake.surfaces import layout

FixedTo = Literal["body", "world"]
Layout = Literal["regular", "jittered", "random"]


@dataclass(frozen=True, kw_only=True)
class Shape(Checked, ABC):
    """Base of the surfaces. Each says by a patch what part of it is near its origin.

    Attributes:
        at: where its origin, a point on it, is [m], table frame; of a body that slides before it has moved.
        turned: how far it is turned about z at its origin [deg].
        mu: friction of the tip on it; null: the tip never slips.
        fixed_to: `world`: it stays, and the body slides along it, as under the flat top that knows no end; `body`: it
            goes with the body, which slides on the table, and the force along its normal pushes that, too.

    Raises:
        BadInput: a number out of range.
    """

    at: tuple[float, float, float] = (0.0, 0.0, 0.0)
    turned: Annotated[float, Quantity("deg", -360.0, 360.0)] = 0.0
    fixed_to: FixedTo = "world"
    mu: Annotated[float | None, Quantity("1", positive=True)] = None

    CALLED: ClassVar = "surface"
    KIND: ClassVar[float]
    LAID: ClassVar = True
    """Whether a hand that is told a motion over a level surface makes it over this one, where it stays."""

    @abstractmethod
    def own_numbers(self) -> Array:
        """(n,) what the kernels of this kind read behind `layout.OWN`."""

    @abstractmethod
    def patch(self, uv: Array) -> Array:
        """Points of the surface by lengths along it, as far as there are any.

        Args:
            uv: (n, 2) along x and y from the origin, before it is turned [m].

        Returns:
            (m, 3) from the origin, before it is turned [m]; m may be less than n.
        """

    def packed(self) -> Array:
        """The vector that `locate` reads."""
        turned = math.radians(self.turned)
        how = 1.0 if self.fixed_to == "world" else 0.0, math.inf if self.mu is None else self.mu
        return np.concatenate(
            [[self.KIND, *how, *self.at, math.cos(turned), math.sin(turned)], np.ravel(self.own_numbers())]
        )

    def points(self, uv: Array) -> Array:
        """`patch` in the table frame [m]."""
        c, s = math.cos(math.radians(self.turned)), math.sin(math.radians(self.turned))
        placed: Array = self.patch(np.asarray(uv, dtype=float)) @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        return placed + self.at

    def cloud(
        self, n: int, size: tuple[float, float] = (0.3, 0.3), *, arranged: Layout = "regular", seed: int = 0
    ) -> Cloud:
        """About n points of a patch, evenly over it.

        Args:
            n: number of points; fewer where the surface ends within the patch.
            size: lengths along the surface [m].
            arranged: see `mmt_drake.cloud.plane`.
            seed: of what is drawn.

        Raises:
            BadInput: a size or number without meaning.
        """
        return Cloud(self.points(plane(n, size, layout=arranged, seed=seed).base[:, :2])).with_normals()


@dataclass(frozen=True, kw_only=True)
class Plane(Shape):
    """A plane of any tilt, which falls along x before it is turned.

    Attributes:
        tilt: against the table [deg].
    """

    tilt: Annotated[float, Quantity("deg", 0.0, 89.0)] = 0.0
    KIND: ClassVar = layout.PLANE

    def own_numbers(self) -> Array:
        """(2,) sine and cosine of the tilt."""
        return np.array([math.sin(math.radians(self.tilt)), math.cos(math.radians(self.tilt))])

    def patch(self, uv: Array) -> Array:
        """See `Shape.patch`."""
        s, c = self.own_numbers()
        return np.column_stack([c * uv[:, 0], uv[:, 1], -s * uv[:, 0]])


@dataclass(frozen=True, kw_only=True)
class _Curved(Shape):
    """Base of the surfaces that a radius tells.

    Attributes:
        radius: of the curvature at the origin [m].
    """

    radius: Length = 0.06

    def own_numbers(self) -> Array:
        """(1,) the radius."""
        return np.array([self.radius])


@dataclass(frozen=True, kw_only=True)
class Sphere(_Curved):
    """A ball, whose top is the origin; its patch is the upper half."""

    KIND: ClassVar = layout.SPHERE

    def patch(self, uv: Array) -> Array:
        """See `Shape.patch`."""
        r = np.hypot(*uv.T)
        uv, r = uv[r <= 0.5 * math.pi * self.radius], r[r <= 0.5 * math.pi * self.radius]
        out = np.sinc(r / self.radius / math.pi)
        return np.column_stack([out * uv[:, 0], out * uv[:, 1], self.radius * (np.cos(r / self.radius) - 1.0)])


@dataclass(frozen=True, kw_only=True)
class Cylinder(_Curved):
    """A cylinder that lies along y before it is turned; its highest line goes through the origin."""

    KIND: ClassVar = layout.CYLINDER

    def patch(self, uv: Array) -> Array:
        """See `Shape.patch`."""
        uv = uv[np.abs(uv[:, 0]) <= 0.5 * math.pi * self.radius]
        angle = uv[:, 0] / self.radius
        return np.column_stack([self.radius * np.sin(angle), uv[:, 1], self.radius * (np.cos(angle) - 1.0)])


@dataclass(frozen=True, kw_only=True)
class Saddle(_Curved):
    """A saddle, z = (x² - y²)/(2 radius) before it is turned."""

    radius: Length = 0.1
    KIND: ClassVar = layout.SADDLE

    def patch(self, uv: Array) -> Array:
        """See `Shape.patch`; lengths are those across z."""
        return np.column_stack([uv, (uv[:, 0] ** 2 - uv[:, 1] ** 2) / (2.0 * self.radius)])


@dataclass(frozen=True, kw_only=True)
class Step(Shape):
    """A step down: level up to x = 0, where a wall falls to a lower level, before it is turned.

    Attributes:
        fall: height of the wall [m].
    """

    fall: Length = 0.02
    LAID: ClassVar = False
    KIND: ClassVar = layout.STEP

    def own_numbers(self) -> Array:
        """(1,) height of the wall."""
        return np.array([self.fall])

    def patch(self, uv: Array) -> Array:
        """See `Shape.patch`: unrolled over the edge."""
        u, v = uv.T
        down = np.clip(u, 0.0, self.fall)
        return np.column_stack([np.minimum(u, 0.0) + np.maximum(u - self.fall, 0.0), v, -down])
