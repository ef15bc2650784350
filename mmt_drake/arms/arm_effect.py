"""An effect of arms: a small declaration."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from mmt_drake.arms.joint_motion import JointMotion
from mmt_drake.arms.law_torque import along
from mmt_drake.effects import LIBRARY
from mmt_drake.numeric.arrays import Array

Shape = tuple[float, ...]
Numbers = Mapping[str, float | str]


@dataclass(frozen=True)
class ArmEffect:
    """One effect of arms. What is not said of one that the library has is as there.

    It is linear in some of its numbers, which a fit finds; the others, its shape, are tried.

    Attributes:
        name: in model files and reports.
        symbols: its numbers, in the order of files.
        units: theirs, of a joint that turns.
        place: where it acts: a joint, a link, or the whole arm.
        family, block: how deep its name may hold.
        equation, source: for people.
        of_plant: whether the plant of the arm says its torque.
        torque: (motion of a joint, shape) -> (n, k), the torque that its drive has to give [N m] for each of the k
            linear numbers being 1; None: by the law of the library.
        shape: symbols of what is tried.
        shapes: (motion of the joint) -> shapes that are tried.
        to_file: (k numbers, shape) -> numbers by symbol; None: linear ones and shape stand there as they are.
        from_file: numbers by symbol -> (k numbers, shape); None: likewise.
        least: that each of the k numbers may be; 0 unless said.
        check: whether k numbers that each may be go together.
        holds: effects that are special or limiting cases of it.
        replaces: the part of a joint that one law alone may have; empty: it stands beside others.
        near_equal: what logs hardly tell from it -> where: an effect, `link_inertia` (other inertial numbers of a
            link) or `scaled_inertias` (of all links by one factor).
        axis: none; effects of a contact have one.
        optional: symbols that a model file may leave out: they are 0 then.
    """

    name: str
    symbols: tuple[str, ...]
    units: tuple[str, ...]
    place: Literal["joint", "link", "arm"] = "joint"
    family: str = ""
    block: str = ""
    equation: str = ""
    source: str = ""
    of_plant: bool = False
    torque: Callable[[JointMotion, Shape], Array] | None = None
    shape: tuple[str, ...] = ()
    shapes: Callable[[JointMotion], Sequence[Shape]] = lambda motion: [()]
    to_file: Callable[[Array, Shape], Numbers] | None = None
    from_file: Callable[[Numbers], tuple[Array, Shape]] | None = None
    least: tuple[float, ...] = ()
    check: Callable[[Array], bool] = lambda x: True
    holds: tuple[str, ...] = ()
    replaces: str = ""
    near_equal: Mapping[str, str] = field(default_factory=dict)
    axis: str = ""
    optional: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "least", self.least or (0.0,) * len(self._linear))
        for name in ("family", "block", "equation", "source"):
            if not getattr(self, name):
                object.__setattr__(self, name, getattr(LIBRARY[self.name], name))

    @property
    def _linear(self) -> tuple[str, ...]:
        return tuple(symbol for symbol in self.symbols if symbol not in self.shape)

    @property
    def reaches_all(self) -> bool:
        """Whether it changes the torque of other joints than one."""
        return self.place != "joint" or self.of_plant

    def columns(self, motion: JointMotion, form: Shape) -> Array:
        """Torque of a joint for one unit of each linear number (n, k); not of what the plant says."""
        if self.torque is not None:
            return self.torque(motion, form)
        units = [self.values(one, form) for one in np.eye(len(self._linear))]
        return np.stack([along(self.name, motion, {s: float(v) for s, v in unit.items()}) for unit in units], 1)

    def values(self, x: Array, form: Shape) -> Numbers:
        """Numbers by symbol, of k linear ones and a shape."""
        if self.to_file is not None:
            return self.to_file(x, form)
        return dict(zip((*self._linear, *self.shape), map(float, (*x, *form)), strict=True))

    def coefficients(self, values: Numbers) -> tuple[Array, Shape]:
        """The k linear numbers and the shape, of numbers by symbol."""
        if self.from_file is not None:
            return self.from_file(values)
        return np.array([float(values[s]) for s in self._linear]), tuple(float(values[s]) for s in self.shape)

    def at_bounds(self, x: Array, known: Array | float) -> Array:
        """Linear numbers of an effect that the model has, (k,): those found a little below what they may be, at that.

        Friction that the model has and the arm has not is found to be 0, more or less.

        Args:
            x: what was found on top.
            known: what the model has; 0 where it has none.
        """
        whole, least = x + known, np.array(self.least)
        near = (whole < least) & (whole >= least - _NEAR * np.abs(known))
        settled: Array = np.where(near, least, whole)
        return settled

    def allows(self, x: Array) -> bool:
        """Whether k linear numbers each may be, and go together."""
        return not any(x < self.least) and self.check(x)


_NEAR = 0.1
"""... by no more than this part of what the model has."""
ANY = -math.inf
"""`ArmEffect.least` of a number of either sign."""
