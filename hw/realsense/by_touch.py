"""The camera's whole pose from touches of what it sees: where an arm's tip touched, the cloud has to be.

Touches are laid onto the cloud's surface by point-to-plane least squares (Chen and Medioni 1991). The search begins at
many headings and places, since what nobody has measured may be anything. What touches do not tell stays as it was
said: a plane is the same after a shift along it and a turn about its normal, a ball after any turn about its centre.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import null_space
from scipy.spatial.transform import Rotation
from scipy.stats import f as f_distribution
from scipy.stats import t as t_distribution

from mmt_drake.cloud import Cloud
from mmt_drake.errors import BadInput, check_number
from mmt_drake.hw.realsense.extrinsics import Extrinsics
from mmt_drake.hw.realsense.poses_on_cloud import Pose, TouchedTop
from mmt_drake.numeric.arrays import Array

LEAST_TOUCHES = 12
_LEAST_POINTS = 100
_LEAST_WIDTH = 0.01  # of the touches, standard deviation along the longest way [m]
_MOST_AWAY = 0.005  # RMS of the touches from the cloud [m]
_KNOWN_TO = 2e-4  # no touch and no cloud is better than this [m]
_MOVED = 0.01  # what touches that tell a direction rule out [m], at the touches
_BY_CHANCE = 1e-7  # where that passes for told: the pose is the best of a thousand tried
_AS_GOOD = 1e-3  # poses whose misfit chance makes as often as this are not told apart
_STEPS, _MENDED = 8, 2
_LARGEST_STEP, _SHORTEST_STEP = 0.01, 1e-4  # [m] at the touches
_TURN = 0.1  # share of a turn in what counts as one
_KEPT = 0.1  # share of what cannot be told in a coordinate that counts as kept


@dataclass(frozen=True)
class PoseCoordinate:
    """One coordinate of the correction, about the middle of the touches, table frame.

    Attributes:
        name: of the coordinate.
        unit: `deg` or `mm`.
        change: from what was said.
        half: half the 95 % interval; NaN where it is not told.
    """

    name: str
    unit: str
    change: float
    half: float

    @property
    def told(self) -> bool:
        """Whether the touches tell it."""
        return not math.isnan(self.half)


@dataclass(frozen=True)
class TouchCalibration:
    """What `calibrate_by_touch` found.

    Attributes:
        extrinsics: where the camera is.
        coordinates: of heading, tilt about y and x, x, y and z those that were sought.
        kept: what these touches cannot tell, in words; it is as it was said.
        others: other poses that fit as well; `extrinsics` is the one that is nearest to what was said.
        residual: RMS of the touches from the cloud's surface [m].
        touches: how many there are.
    """

    extrinsics: Extrinsics
    coordinates: tuple[PoseCoordinate, ...]
    kept: tuple[str, ...]
    others: tuple[Extrinsics, ...]
    residual: float
    touches: int

    def lines(self) -> list[str]:
        """For a person: each coordinate's change and 95 % interval, what is kept, and what else fits."""
        lines = [f"{self.touches} touches, {1e3 * self.residual:.2f} mm from the cloud (RMS)"]
        for c in self.coordinates:
            told = f"{c.change:+.2f} {c.unit}, within {c.half:.2f} (95 %)" if c.told else "not told by these touches"
            lines.append(f"{c.name}: {told}")
        lines += [f"cannot be told, and stays as it was said: {move}" for move in self.kept]
        if self.others:
            fit = "another pose fits" if len(self.others) == 1 else f"{len(self.others)} other poses fit"
            lines.append(f"{fit} as well; this one is nearest to what was said: measure heading and foot by hand")
        return lines


def calibrate_by_touch(
    cloud: Cloud,
    touches: ArrayLike,
    said: Extrinsics,
    *,
    spread: ArrayLike = 0.0,
    tip_radius: float = 0.0,
    keep_level: bool = False,
) -> TouchCalibration:
    """Find the camera's pose from touches of what its cloud shows.

    A direction of the six is told if a move of 10 mm at the touches along it, all others fitted again, makes the sum
    of squares larger than chance does once in ten million times (F): the pose is the best of many. Intervals are of
    least squares, from what the touches leave over, or from what is known of touches and cloud where that is more.

    Args:
        cloud: of the undisturbed object [m], in the table frame by `said`.
        touches: (n, 3) positions of the tip [m], table frame of the arm.
        said: the camera's pose as it is known so far.
        spread: (n,) or one for all: by how much a position may be off [m].
        tip_radius: of the ball at the tip, whose centre the positions are [m].
        keep_level: height and tilt are as said, from the bare table; only heading and foot are sought.

    Raises:
        BadInput: fewer than 12 touches, or all in one place; fewer than 100 points; touches that no pose lays onto the
            cloud.
    """
    tip = np.asarray(touches, dtype=np.float64)
    if tip.ndim != 2 or tip.shape[1] != 3 or not np.isfinite(tip).all():
        raise BadInput("touches", found=f"an array of shape {tip.shape}", expected="(n, 3) finite positions [m]")
    check_number("touches", "tip radius", tip_radius, least=0.0)
    if len(tip) < LEAST_TOUCHES:
        raise BadInput("touches", found=len(tip), expected=f"{LEAST_TOUCHES} or more, over all of the object")
    if len(cloud) < _LEAST_POINTS:
        raise BadInput("cloud", found=f"{len(cloud)} points", expected=f"{_LEAST_POINTS} or more of the object's top")
    middle = tip.mean(axis=0)
    width = math.sqrt(float(np.linalg.eigvalsh(np.cov((tip - middle).T))[-1]))
    if width < _LEAST_WIDTH:
        expected = f"{1e3 * _LEAST_WIDTH:g} mm or more (standard deviation): touch all over the object"
        raise BadInput("touches", at="width", found=f"{1e3 * width:.1f} mm", expected=expected)
    top = TouchedTop(cloud if cloud.normals is not None else cloud.with_normals(), tip - middle, tip_radius)
    deviation = np.hypot(np.broadcast_to(np.asarray(spread, dtype=np.float64), len(tip)), max(_KNOWN_TO, top.noise()))
    free = np.eye(6)[2:5] if keep_level else np.eye(6)
    touched = _Touched(top, deviation, width, free, Pose(np.eye(3), middle))
    best, others = touched.poses()
    residual = float(np.sqrt(np.mean(top.distances(best).along ** 2)))
    if residual > _MOST_AWAY:
        expected = f"{1e3 * _MOST_AWAY:g} mm or less: touches of this object, which has not moved"
        raise BadInput("touches", at="RMS from the cloud", found=f"{1e3 * residual:.1f} mm", expected=expected)
    return TouchCalibration(
        extrinsics=_corrected(said, best, middle),
        coordinates=touched.coordinates(best),
        kept=touched.kept(best),
        others=tuple(_corrected(said, other, middle) for other in others),
        residual=residual,
        touches=len(tip),
    )


def _corrected(said: Extrinsics, pose: Pose, middle: Array) -> Extrinsics:
    """The camera where the pose has the cloud: a point q of it at Rᵀ (q - t) + middle."""
    back = pose.rotation.T
    return Extrinsics.from_matrix(back @ said.rotation(), back @ (np.array(said.position) - pose.place) + middle)


class _Touched:
    """What the touches tell, and the poses that they leave.

    Moves are counted by how far they move the touches [m]: a turn is multiplied with their width.

    Args:
        top: what was touched.
        deviation: (n,) of a touch [m].
        width: of the touches [m].
        free: (k, 6) unit vectors along which the pose is sought.
        said: the pose as it is known so far.
    """

    def __init__(self, top: TouchedTop, deviation: Array, width: float, free: Array, said: Pose) -> None:
        self.top, self.said = top, said
        self._deviation, self._free = deviation, free
        self._turns = np.array([1.0 / width] * 3 + [1.0] * 3)
        self._dof = len(deviation) - len(free)
        self._untold = 0

    def poses(self) -> tuple[Pose, list[Pose]]:
        """The best one, of several as good the nearest to what was said; and the others."""
        found = sorted((self._fitted(p, self._free) for p in self.top.poses(self._free, self.said)), key=self._squares)
        limit = self._as_good_as(self._squares(found[0]))
        self._untold = self._count_untold(found[0])
        near = [p for p in found if self._squares(p) <= limit]
        found = self._apart([self._pulled(pose, self.said, limit, self._squares) for pose in self._apart(near)])
        limit = self._as_good_as(min(map(self._squares, found)))
        good = [p for p in found if self._squares(p) <= limit]
        best, *others = sorted(good, key=lambda p: self._size(p.way_to(self.said)))
        # The touches may be kept from going further by the end of the cloud alone.
        others = [p for p in others if len(self._apart([best, self._pulled(p, best, limit, self._along)])) > 1]
        return best, others

    def coordinates(self, pose: Pose) -> tuple[PoseCoordinate, ...]:
        """What has changed: a turn about the touches' middle and their shift."""
        _, rows = self._rows(pose)
        told, held = self._told_moves(pose), self._held(pose)
        wide = self._variance(self._squares(pose)) * float(t_distribution.ppf(0.975, self._dof)) ** 2
        spread = told.T @ np.linalg.inv(told @ rows.T @ rows @ told.T) @ told if len(told) else np.zeros((6, 6))
        halves = np.sqrt(wide * np.diag(spread)) * self._turns
        halves[np.sum(held**2, axis=0) > _KEPT] = math.nan
        angles = Rotation.from_matrix(pose.rotation.T).as_euler("ZYX", degrees=True)
        turns = zip(("heading", "tilt about y", "tilt about x"), angles, np.degrees(halves[2::-1]), strict=True)
        shifts = zip("xyz", 1e3 * (self.said.place - pose.place), 1e3 * halves[3:], strict=True)
        found = [PoseCoordinate(name, "deg", float(angle), float(half)) for name, angle, half in turns]
        found += [PoseCoordinate(name, "mm", float(shift), float(half)) for name, shift, half in shifts]
        free = self._free.sum(axis=0)[[2, 1, 0, 3, 4, 5]]
        return tuple(coordinate for coordinate, sought in zip(found, free, strict=True) if sought)

    def kept(self, pose: Pose) -> tuple[str, ...]:
        """What cannot be told, in the table frame: shifts, and turns about an axis."""
        turns, shifts = (moves * self._turns @ np.kron(np.eye(2), pose.rotation) for moves in self._untold_moves(pose))
        told = list[str]()
        for turn in turns:
            axis, shift = turn[:3], turn[3:]
            through = np.cross(axis, shift) / (axis @ axis) + self.said.place
            told.append(f"a turn about ({_told(axis / np.linalg.norm(axis))}) through ({_told(through)}) m")
        told += [f"a shift along ({_told(shift[3:] / np.linalg.norm(shift[3:]))})" for shift in shifts]
        return tuple(told)

    def _size(self, way: Array) -> float:
        return float(np.linalg.norm(way / self._turns))

    def _apart(self, poses: Sequence[Pose]) -> list[Pose]:
        """Those that none before is near to."""
        apart = list[Pose]()
        for pose in poses:
            if all(self._size(pose.way_to(other)) > 0.5 * _MOVED for other in apart):
                apart.append(pose)
        return apart

    def _variance(self, squares: float) -> float:
        return max(squares / self._dof, 1.0)

    def _as_good_as(self, squares: float) -> float:
        """Up to which sum of squares a pose is as good as one with a smaller sum."""
        k = len(self._free)
        return squares + self._variance(squares) * k * float(f_distribution.isf(_AS_GOOD, k, self._dof))

    def _along(self, pose: Pose) -> float:
        """Sum of squares of the distances along the normals alone: what is beyond the cloud goes on level."""
        return float(np.sum(self._rows(pose)[0] ** 2))

    def _squares(self, pose: Pose) -> float:
        away = self.top.distances(pose)
        return float(np.sum((away.along**2 + away.beyond**2) / self._deviation**2))

    def _rows(self, pose: Pose) -> tuple[Array, Array]:
        """(n,) distances along the normals and (n, 6) how moves change them, over the deviation."""
        away = self.top.distances(pose)
        return away.along / self._deviation, away.jacobian * self._turns / self._deviation[:, None]

    def _moves(self, pose: Pose) -> Array:
        """(k, 6) moves that do not mix in the squares, from the one that they show least."""
        rows = self._rows(pose)[1] @ self._free.T
        moves: Array = np.linalg.eigh(rows.T @ rows)[1].T @ self._free
        return moves

    def _untold_moves(self, pose: Pose) -> tuple[Array, Array]:
        """What is not told: turns, each about an axis of its own, and shifts; rows (., 6)."""
        untold = self._moves(pose)[: self._untold]
        mixed, turning, _ = np.linalg.svd(untold[:, :3])
        moves = mixed.T @ untold
        n = int(np.sum(turning > _TURN))
        return moves[:n], moves[n:]

    def _held(self, pose: Pose) -> Array:
        """What stays as it was said, orthonormal rows (., 6): the turning of such a turn, wherever its axis is."""
        turns, shifts = self._untold_moves(pose)
        held = np.concatenate([turns * ([1.0] * 3 + [0.0] * 3), shifts])
        made: Array = np.linalg.qr(held.T)[0].T if len(held) else held
        return made

    def _told_moves(self, pose: Pose) -> Array:
        """Orthonormal rows (., 6) along which nothing that is held changes."""
        made: Array = null_space(self._held(pose) @ self._free.T, rcond=1e-9).T @ self._free
        return made

    def _fitted(self, pose: Pose, along: Array, steps: int = _STEPS) -> Pose:
        """The pose with the least squares that moves along some directions, (k, 6), lead to."""
        for _ in range(steps):
            left, rows = self._rows(pose)
            by = -np.linalg.lstsq(rows @ along.T, left, rcond=1e-6)[0] @ along
            pose = pose.moved(by * self._turns / max(np.linalg.norm(by) / _LARGEST_STEP, 1.0))
        return pose

    def _count_untold(self, best: Pose) -> int:
        """How many directions, from the one that shows least, the touches do not tell."""
        least = self._along(best)
        limit = self._variance(least) * float(f_distribution.isf(_BY_CHANCE, 1, self._dof))
        moves = self._moves(best)
        count = 0
        for i, move in enumerate(moves):
            others = np.delete(moves, i, axis=0)[count:]  # a long way along what is not told can be any other way
            moved = [self._fitted(best.moved(far * move * self._turns), others) for far in (-_MOVED, _MOVED)]
            if min(map(self._along, moved)) - least < limit:
                count = i + 1
        return count

    def _pulled(self, pose: Pose, to: Pose, limit: float, squares: Callable[[Pose], float]) -> Pose:
        """Led to another pose along what cannot be told, as far as that is as good."""
        far = _LARGEST_STEP
        while self._untold and far > _SHORTEST_STEP:
            turns, shifts = self._untold_moves(pose)
            way = pose.way_to(to) / self._turns
            by = (way[:3] @ turns[:, :3].T / np.sum(turns[:, :3] ** 2, axis=1)) @ turns
            by += (way - by) @ shifts.T @ shifts
            size = float(np.linalg.norm(by))
            if size < _SHORTEST_STEP:
                break
            after = pose.moved(by * self._turns * min(1.0, far / size))
            after = self._fitted(after, self._told_moves(after), steps=_MENDED)
            if squares(after) <= limit:
                pose = after
            else:
                far *= 0.5
        return pose


def _told(vector: Array) -> str:
    return ", ".join(f"{value:.2f}" for value in vector + 0.0)
