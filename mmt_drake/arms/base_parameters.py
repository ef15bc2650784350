"""Base parameters: what of an arm's inertial numbers its torques can tell at all, and what a motion tells of these.

Columns of the regressor that are multiples of others are found by QR with column pivoting, W P = Q [R1 R2]: the first
`rank` columns are independent, and x1 + R1^-1 R2 x2 are the base parameters (Gautier 1991, J. Robotic Systems 8(4);
Khalil and Dombre 2002, Modeling, Identification and Control of Robots, ch. 12). Rows are in parts of each joint's
torque, columns in parts of what a number may be. First it is done for random states: what no motion tells. Then for a
motion, beside Coulomb and viscous friction of every joint that moves.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from mmt_drake.analysis.wording import significant
from mmt_drake.arms.arm_file import INERTIA, INERTIA_UNITS
from mmt_drake.arms.joint_motion import REST
from mmt_drake.arms.motion import ArmMotion
from mmt_drake.arms.plant import ArmPlant
from mmt_drake.arms.problem import STILL, expected_sizes
from mmt_drake.arms.regressor import regressor
from mmt_drake.numeric.arrays import Array

TELLS = 1e-3
"""A base parameter that is off by its size has to change the torque by this part of its size: less is not told."""
BARELY = 0.3
"""One whose standard deviation is more than this part of its size is barely told."""
_EXACT = 1e-8
"""Of the largest diagonal element of R: smaller ones are rounding, in a regressor that is known exactly."""
_APART = 1e-2
"""A base parameter beside which a motion sees no more than this of another one, by their sizes, is told by itself."""
_LAST = 1e-2
"""Masses are regrouped into moments rather than the other way round."""
_WIDTH = 0.9
"""Band of white noise that is as loud behind the filter of a motion, in parts of its edge: samples hang together."""
_STATES = 40
_FRICTION = 0.1
"""Of a joint's torque may be friction."""


def grouped(matrix: Array, least: float, preferred: Array | None = None) -> tuple[Array, list[int]]:
    """Independent columns, and the combinations of numbers that they tell.

    Args:
        matrix: (rows, k) a column for each number.
        least: diagonal elements of R that are smaller count as 0.
        preferred: (k,) columns with larger factors are rather kept than regrouped; 1 by default.

    Returns:
        (rank, k): each row a combination of numbers, 1 at its own; and the columns that are independent.
    """
    factor = np.ones(matrix.shape[1]) if preferred is None else preferred
    upper, order = linalg.qr(matrix * factor, mode="r", pivoting=True)
    size = np.abs(np.diag(upper))
    rank = int(np.sum(size > least * factor[order[: len(size)]]))
    combinations = np.zeros((rank, matrix.shape[1]))
    whole = linalg.solve_triangular(upper[:rank, :rank], upper[:rank]) if rank else upper[:0]
    whole[np.abs(whole) < _EXACT] = 0.0
    combinations[:, order] = whole * factor[order[:rank], None] / factor[order]
    rows = np.argsort(order[:rank])
    return combinations[rows], [int(column) for column in order[:rank][rows]]


@dataclass(frozen=True)
class BaseParameter:
    """A combination of inertial numbers that the torques tell.

    Attributes:
        terms: `link.symbol` -> factor; the first is 1.
        value: as handed in.
        size: what it may be, by mass and size of its links.
        unit: of both.
        deviation: standard deviation that a motion attains; None where none was looked at.
    """

    terms: Mapping[str, float]
    value: float
    size: float
    unit: str
    deviation: float | None = None

    @property
    def name(self) -> str:
        """In words: `Iyy of upper_arm + 0.1764 m of forearm`."""
        return self.said(len(self.terms))

    def said(self, most: int) -> str:
        """The name with so many terms at most."""
        text, more = "", len(self.terms) - most
        for key, factor in list(self.terms.items())[:most]:
            link, _, symbol = key.rpartition(".")
            times = "" if abs(abs(factor) - 1.0) < 5e-5 else f"{significant(abs(factor), 4)} "
            text += f" {'-' if factor < 0.0 else '+'} {times}{symbol} of {link}"
        return text.removeprefix(" + ") + (f" and {more} more" if more > 0 else "")

    @property
    def relative(self) -> float | None:
        """The standard deviation in parts of the value; None where one of them is not known, or the value is 0."""
        known = self.deviation is not None and abs(self.value) > _EXACT * self.size
        return self.deviation / abs(self.value) if known and self.deviation is not None else None

    @property
    def barely(self) -> bool:
        """Whether a motion that tells it hardly does."""
        return self.deviation is not None and self.deviation > BARELY * self.size

    def to_data(self) -> dict[str, Any]:
        """As it stands in a document."""
        said = {"name": self.name, "terms": dict(self.terms), "value": self.value, "unit": self.unit}
        if self.deviation is None:
            return said
        return {**said, "deviation": self.deviation, "relative_deviation": self.relative, "barely": self.barely}


@dataclass(frozen=True)
class BaseParameters:
    """What a motion tells of an arm.

    Attributes:
        parameters: base parameters of this motion; where a joint hardly moves they are fewer than those of the arm.
        structural: those of the arm, whatever the motion, with what this one attains where it tells them apart.
        unexcited: inertial numbers, `link.symbol`, that nothing in this motion depends on, and in another one may.
        never: those that no motion tells.
        condition: of the regressor of all base parameters of the arm and of friction; infinite where that is singular.
    """

    parameters: tuple[BaseParameter, ...]
    structural: tuple[BaseParameter, ...]
    unexcited: tuple[str, ...]
    never: tuple[str, ...]
    condition: float

    @property
    def untold(self) -> tuple[BaseParameter, ...]:
        """Base parameters of the arm that this motion does not tell by themselves; another motion would."""
        return tuple(one for one in self.structural if one.deviation is None)

    @property
    def well_told(self) -> tuple[BaseParameter, ...]:
        """Those that this motion tells, and not barely."""
        return tuple(one for one in self.structural if one.deviation is not None and not one.barely)

    def to_data(self) -> dict[str, Any]:
        """The key `base_parameters` of a diagnosis."""
        return {
            "rank": len(self.parameters),
            "structural_rank": len(self.structural),
            "condition_number": self.condition if np.isfinite(self.condition) else None,
            "parameters": [one.to_data() for one in self.parameters],
            "another_motion_tells": [one.to_data() for one in self.untold],
            "unexcited": list(self.unexcited),
            "never_told": list(self.never),
        }


@dataclass(frozen=True)
class RowsOfMotion:
    """Regressor of a motion: a row for each sample of each joint that moves there; rest tells nothing.

    Attributes:
        base: (rows, rank) of base parameters, rows in parts of the joint's torque, columns in parts of their sizes.
        friction: (rows, 2 joints) the same of Coulomb friction of every joint, then of viscous friction.
        every: (rows, 10 links) the same of all inertial numbers.
        joint: (rows,) its number.
        torque: (samples, joints) that the motion asks of the links as handed in [N m].
    """

    base: Array
    friction: Array
    every: Array
    joint: NDArray[np.int64]
    torque: Array

    @classmethod
    def joined(cls, parts: Sequence[RowsOfMotion]) -> RowsOfMotion:
        """Several, one after the other."""
        names = [field.name for field in fields(cls)]
        return cls(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))

    @property
    def samples(self) -> int:
        """Of the motion."""
        return len(self.torque)

    @property
    def whole(self) -> Array:
        """Of base parameters and friction, for one sample in the mean, (rows, rank + 2 joints)."""
        return np.column_stack([self.base, self.friction]) / np.sqrt(self.samples)

    @property
    def condition(self) -> float:
        """Condition number of it, every column over its norm: nearly the least that any scaling of the columns gives.

        van der Sluis 1969, Numerische Mathematik 14(1). Infinite where it is singular.
        """
        whole = self.whole
        norm = np.linalg.norm(whole, axis=0)
        if len(whole) < len(norm) or not norm.min() > _EXACT:
            return float("inf")
        sizes = linalg.svdvals(whole / norm)
        return float(sizes[0] / sizes[-1]) if sizes[-1] > _EXACT else float("inf")


@dataclass(frozen=True)
class BaseStructure:
    """The base parameters of an arm, whatever its motion.

    Attributes:
        arm: whose.
        nominal: (10 links,) inertial numbers as handed in.
        scale: (10 links,) what each of them may be.
        torque: (joints,) RMS of the torques that random states ask for [N m].
        combinations: (rank, 10 links), as of `grouped`.
        independent: the columns that stand for them.
        never: numbers that no motion tells.
    """

    arm: ArmPlant
    nominal: Array
    scale: Array
    torque: Array
    combinations: Array
    independent: tuple[int, ...]
    never: tuple[int, ...]

    @classmethod
    def of(cls, arm: ArmPlant, nominal: Array, seed: int = 0) -> BaseStructure:
        """That of an arm, from random states within its joints' limits.

        Args:
            arm: whose.
            nominal: (10 links,) inertial numbers as handed in.
            seed: of the states.
        """
        rng, joints = np.random.default_rng(seed), len(arm.joints)
        low, high = (np.clip(limit, -np.pi, np.pi) for limit in arm.position_limits)
        q = rng.uniform(low, high, (_STATES + 10 * joints, joints))
        v, a = rng.uniform(-2.0, 2.0, q.shape), rng.uniform(-5.0, 5.0, q.shape)
        asked = regressor(arm, q, v, a, tilted=False).inertial
        torque = np.sqrt(np.mean((asked @ nominal) ** 2, axis=0))
        torque = np.maximum(torque, 1e-6 * max(float(torque.max()), 1e-9))
        matrix = (asked / torque[:, None]).reshape(-1, len(nominal))
        size = np.linalg.norm(matrix, axis=0)
        felt = size > _EXACT * size.max()
        unit = np.where(felt, matrix / np.where(felt, size, 1.0), 0.0)
        rather = np.where(np.arange(len(nominal)) % len(INERTIA) == 0, _LAST, 1.0)
        found, independent = grouped(unit, _EXACT, rather)
        combinations = found * size / size[independent][:, None]
        never = tuple(int(i) for i in np.flatnonzero(~felt))
        return cls(arm, nominal, expected_sizes(nominal), torque, combinations, tuple(independent), never)

    @property
    def size(self) -> Array:
        """What each base parameter may be, (rank,)."""
        return np.asarray(np.sqrt(self.combinations**2 @ self.scale**2))

    def named(self, combinations: Array, deviations: Array | None = None) -> tuple[BaseParameter, ...]:
        """Base parameters of combinations of inertial numbers.

        Args:
            combinations: (k, 10 links).
            deviations: (k,) that a motion attains, each in the unit of its combination.
        """
        found = []
        for i, row in enumerate(combinations):
            share = np.round(np.abs(row) * self.scale, 9)
            own = sorted(np.flatnonzero(row).tolist(), key=lambda at: (abs(row[at] - 1.0) > _EXACT, -share[at], at))
            terms = {key: float(row[at]) for key, at in zip(self._keys(own), own, strict=True)}
            size = float(np.sqrt(row**2 @ self.scale**2))
            deviation = None if deviations is None else float(deviations[i])
            found.append(BaseParameter(terms, float(row @ self.nominal), size, INERTIA_UNITS[own[0] % 10], deviation))
        return tuple(found)

    def regressor(self, q: Array, v: Array, a: Array) -> RowsOfMotion:
        """What base parameters and friction ask for over a motion (n, joints) of each."""
        joints = q.shape[1]
        fastest = np.maximum(np.abs(v).max(axis=0), 1e-9)
        moves = np.ptp(q, axis=0) > STILL
        inertial = regressor(self.arm, q, v, a, tilted=False).inertial
        asked = inertial / self.torque[:, None]
        friction, every = np.zeros((len(q), joints, 2, joints)), np.arange(joints)
        friction[:, every, 0, every] = _FRICTION * np.clip(v / (REST * fastest), -1.0, 1.0) * moves
        friction[:, every, 1, every] = _FRICTION * v / fastest * moves
        counted = moves & (np.abs(v) >= REST * fastest)
        return RowsOfMotion(
            (asked[:, :, list(self.independent)] * self.size)[counted],
            friction.reshape(len(q), joints, -1)[counted],
            (asked * self.scale)[counted],
            np.nonzero(counted)[1],
            inertial @ self.nominal,
        )

    def told(self, motions: Sequence[ArmMotion], noise: Array) -> BaseParameters:
        """What motions tell, together.

        Args:
            motions: of the arm.
            noise: (joints,) standard deviation of what is left of each torque within the band [N m].
        """
        parts = [self.regressor(*(x[one.thinning] for x in (one.q, one.v, one.a))) for one in motions]
        one = RowsOfMotion.joined(parts)
        rub = one.friction[:, np.linalg.norm(one.friction, axis=0) > 0.0]
        plane = linalg.qr(rub, mode="economic")[0]
        groups, first = grouped((one.base - plane @ (plane.T @ one.base)) / np.sqrt(one.samples), TELLS)
        weight = (self.torque / np.maximum(noise, _EXACT * self.torque))[one.joint]
        weighed = np.column_stack([one.base[:, first], rub]) * weight[:, None]
        inverse = linalg.pinv(linalg.qr(weighed, mode="r")[0][: weighed.shape[1]])[: len(first)]
        alike = max(1.0, *(1.0 / (2.0 * _WIDTH * m.band_hz * m.step * m.thinning.step) for m in motions))
        deviation = np.linalg.norm(inverse, axis=1) * np.sqrt(alike) * self.size[first]
        apart = {first[i]: deviation[i] for i, row in enumerate(groups) if np.sum(np.abs(row) > _APART) == 1}
        own = self.named(self.combinations)
        own = tuple(replace(p, deviation=float(apart[i])) if i in apart else p for i, p in enumerate(own))
        felt = np.linalg.norm(one.every, axis=0) > TELLS * np.sqrt(one.samples)
        return BaseParameters(
            self.named((groups * self.size[first][:, None] / self.size) @ self.combinations, deviation),
            own,
            self._keys([int(i) for i in np.flatnonzero(~felt) if i not in self.never]),
            self._keys(self.never),
            one.condition,
        )

    def _keys(self, numbers: Iterable[int]) -> tuple[str, ...]:
        return tuple(f"{self.arm.links[i // 10]}.{INERTIA[i % 10]}" for i in numbers)
