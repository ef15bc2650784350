"""What an effect of arms is, and the two kinds that most of them are."""

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
    """One effect of arms.

    Attributes:
        name: in model files and reports.
        place: where it acts: a joint, a link, or the whole arm.
        family, block: how deep its name may hold.
        symbols: its numbers, in the order of files.
        units: theirs, of a joint that turns.
        columns: (motion of a joint, shape) -> (n, k), the torque that its drive has to give [N m] for each of the k
            numbers being 1; None where the plant of the arm says it.
        shapes: (motion of the joint) -> shapes that are tried.
        values: (k numbers, shape) -> numbers by symbol.
        coefficients: numbers by symbol -> (k numbers, shape).
        least: that each of the k numbers may be.
        check: whether k numbers that each may be go together.
        holds: effects that are special or limiting cases of it.
        replaces: the part of a joint that one law alone may have; empty: it stands beside others.
        equation, source: for people.
        near_equal: what logs hardly tell from it -> where: an effect, `link_inertia` (other inertial numbers of a
            link) or `scaled_inertias` (of all links by one factor).
        axis: none; effects of a contact have one.
        optional: symbols that a model file may leave out: they are 0 then.
    """

    name: str
    place: Literal["joint", "link", "arm"]
    family: str
    block: str
    symbols: tuple[str, ...]
    units: tuple[str, ...]
    values: Callable[[Array, Shape], Numbers]
    coefficients: Callable[[Numbers], tuple[Array, Shape]]
    equation: str
    source: str
    columns: Callable[[JointMotion, Shape], Array] | None = None
    shapes: Callable[[JointMotion], Sequence[Shape]] = lambda motion: [()]
    least: tuple[float, ...] = (-math.inf,)
    check: Callable[[Array], bool] = lambda x: True
    holds: tuple[str, ...] = ()
    replaces: str = ""
    near_equal: Mapping[str, str] = field(default_factory=dict)
    axis: str = ""
    optional: tuple[str, ...] = ()

    @property
    def reaches_all(self) -> bool:
        """Whether it changes the torque of other joints than one."""
        return self.place != "joint" or self.columns is None


def of_library(
    name: str,
    symbols: tuple[str, ...],
    units: tuple[str, ...],
    parts: Callable[[Shape], Sequence[tuple[Mapping[str, float], Mapping[str, float]]]],
    *,
    shape: tuple[str, ...] = (),
    shapes: Callable[[JointMotion], Sequence[Shape]] = lambda motion: [()],
    least: float = 0.0,
    check: Callable[[Array], bool] = lambda x: True,
    holds: tuple[str, ...] = (),
    replaces: str = "",
    near_equal: Mapping[str, str] | None = None,
) -> ArmEffect:
    """An effect of the library on a joint, linear in its numbers but those of its shape."""
    strong = tuple(s for s in symbols if s not in shape)

    def columns(motion: JointMotion, form: Shape) -> Array:
        return np.stack([along(name, motion, values, uses) for values, uses in parts(form)], 1)

    law = LIBRARY[name]
    return ArmEffect(
        name,
        "joint",
        law.family,
        law.block,
        symbols,
        units,
        values=lambda x, form: {**dict(zip(strong, map(float, x), strict=True)), **dict(zip(shape, form, strict=True))},
        coefficients=lambda v: (np.array([float(v[s]) for s in strong]), tuple(float(v[s]) for s in shape)),
        equation=law.equation,
        source=law.source,
        columns=columns,
        shapes=shapes,
        least=(least,) * len(strong),
        check=check,
        holds=holds,
        replaces=replaces,
        near_equal=near_equal or {},
    )


def _one(symbol: str) -> tuple[Callable[[Array, Shape], Numbers], Callable[[Numbers], tuple[Array, Shape]]]:
    return lambda x, form: {symbol: float(x[0])}, lambda values: (np.array([float(values[symbol])]), ())


def of_one_number(
    name: str,
    symbol: str,
    unit: str,
    column: Callable[[JointMotion], Array],
    family: str,
    block: str,
    equation: str,
    source: str,
    least: float = -math.inf,
    near_equal: Mapping[str, str] | None = None,
) -> ArmEffect:
    """An effect of one number on one joint, which the library has not or has for other structures."""
    values, coefficients = _one(symbol)
    return ArmEffect(
        name,
        "joint",
        family,
        block,
        (symbol,),
        (unit,),
        values=values,
        coefficients=coefficients,
        equation=equation,
        source=source,
        columns=lambda motion, form: column(motion)[:, None],
        least=(least,),
        near_equal=near_equal or {},
    )
