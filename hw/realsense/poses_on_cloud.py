"""Poses that lay touches onto the surface of a cloud: how far off each is, and where to begin."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from mmt_drake.cloud import Cloud
from mmt_drake.cloud.facet import surface_near
from mmt_drake.numeric.arrays import Array

Indices = NDArray[np.intp]

_HEADINGS, _PLACES = 24, 40  # from which the search begins
_TRIED_WITH = 60  # touches
_TRIED_POINTS = 200
_STEPS, _KEPT = 25, 12
_LARGEST_TURN, _LARGEST_SHIFT = 0.3, 0.05  # in a step [rad], [m]
_DAMPED = 1e-4  # of a step's squares: along what nothing tells it stays
_WIDEST = 3.0  # spacings about a point that count as its surface
_NARROWEST = 0.004  # [m]


class Pose(NamedTuple):
    """Where the touches are in the frame of the cloud: one at x from their middle is at `rotation` x + `place`.

    Attributes:
        rotation: (3, 3).
        place: (3,) of the touches' middle [m].
    """

    rotation: Array
    place: Array

    def moved(self, by: Array) -> "Pose":
        """Turned about the touches' middle by a rotation vector, `by[:3]` [rad], and shifted by `by[3:]` [m]."""
        return Pose(Rotation.from_rotvec(by[:3]).as_matrix() @ self.rotation, self.place + by[3:])

    def way_to(self, other: "Pose") -> Array:
        """(6,) what `moved` would have to be given to come to another pose."""
        turn = Rotation.from_matrix(other.rotation @ self.rotation.T).as_rotvec()
        return np.concatenate([turn, other.place - self.place])


class Distances(NamedTuple):
    """Of touches from the surface, where a pose puts them.

    Attributes:
        along: (n,) along the surface's normal, outwards [m].
        beyond: (n,) how far from the nearest point of the cloud across it, less what its spacing explains [m].
        jacobian: (n, 6) of `along`, over what `Pose.moved` takes.
    """

    along: Array
    beyond: Array
    jacobian: Array


class TouchedTop:
    """A cloud's surface, and the touches of it.

    Args:
        cloud: with normals.
        touches: (n, 3) about their middle [m].
        tip_radius: how far from the surface they are [m].
    """

    def __init__(self, cloud: Cloud, touches: Array, tip_radius: float) -> None:
        normals = cloud.normals
        assert normals is not None  # what the class is handed by this package
        self.touches = touches
        self._cloud, self._tip_radius = cloud, tip_radius
        self._points, self._normals = cloud.points(), normals
        self._tree = cKDTree(self._points)
        self._radius = max(_WIDEST * cloud.spacing, _NARROWEST)

    def noise(self) -> float:
        """Standard deviation of the surface that is made of the points, by how they lie about their planes [m]."""
        some = np.random.default_rng(0).permutation(len(self._points))[:_TRIED_POINTS]
        around = self._tree.query_ball_point(self._points[some], self._radius)
        away = [
            np.mean((self._points[j] - self._points[i]) @ self._normals[i]) for i, j in zip(some, around, strict=True)
        ]
        return float(np.std(away) / math.sqrt(np.median([len(j) for j in around])))

    def distances(self, pose: Pose) -> Distances:
        """By the plane that touches the surface where each touch is nearest to it."""
        at = self.touches @ pose.rotation.T + pose.place
        near, away, beyond, _ = self._nearest(at)
        depths, normals = surface_near(self._cloud, at, self._normals[near], self._radius)
        alone = np.isnan(depths)
        depths[alone] = -np.sum(away * self._normals[near], axis=-1)[alone]
        jacobian = np.concatenate([np.cross(at - pose.place, normals), normals], axis=-1)
        return Distances(-depths - self._tip_radius, beyond, jacobian)

    def poses(self, free: Array, said: Pose) -> list[Pose]:
        """A few that may be the best ones, found from `said`, and from headings all around and places all over.

        Args:
            free: (k, 6) unit vectors of what `Pose.moved` takes: along which a pose may differ from `said`.
            said: the pose as it is known so far.
        """
        rotations, places = self._beginnings(free, said)
        tried = self.touches[:: -(-len(self.touches) // _TRIED_WITH)]
        for _ in range(_STEPS):
            rotations, places = self._step(tried, rotations, places, free)
        squares = self._squares(tried, rotations, places)
        order = [0, *np.argsort(squares)[:_KEPT]]
        return [Pose(rotations[i], places[i]) for i in order]

    def _beginnings(self, free: Array, said: Pose) -> tuple[Array, Array]:
        turns = np.linspace(0.0, 2.0 * math.pi, _HEADINGS, endpoint=False)
        rotations = Rotation.from_rotvec(turns[:, None] * [0.0, 0.0, 1.0]).as_matrix() @ said.rotation
        random = np.random.default_rng(0)
        points = self._points[random.permutation(len(self._points))[:_PLACES]]
        shifts = free[:, 3:].T @ free[:, 3:]
        places = said.place + (points - said.place) @ shifts
        every = np.repeat(rotations, len(places), axis=0), np.tile(places, (_HEADINGS, 1))
        return np.concatenate([said.rotation[None], every[0]]), np.concatenate([said.place[None], every[1]])

    def _nearest(self, at: Array) -> tuple[Indices, Array, Array, Array]:
        """Number of the nearest point, the way from it, how far that is beyond, and the unit vector of that."""
        _, near = self._tree.query(at)
        away, normals = at - self._points[near], self._normals[near]
        across = away - np.sum(away * normals, axis=-1, keepdims=True) * normals
        width = np.linalg.norm(across, axis=-1)
        return near, away, np.maximum(width - self._radius, 0.0), across / np.maximum(width, 1e-12)[..., None]

    def _step(self, tried: Array, rotations: Array, places: Array, free: Array) -> tuple[Array, Array]:
        """One of Gauss and Newton, of all poses at once: (m, 3, 3) and (m, 3)."""
        arms = np.einsum("mij,nj->mni", rotations, tried)
        near, away, beyond, sideways = self._nearest(arms + places[:, None])
        normals = self._normals[near]
        along = np.sum(away * normals, axis=-1) - self._tip_radius
        rows = (
            np.concatenate([_rows(arms, normals), _rows(arms, sideways) * (beyond > 0.0)[..., None]], axis=1) @ free.T
        )
        left = np.concatenate([along, beyond], axis=1)
        squares = np.einsum("mni,mnj->mij", rows, rows)
        size = _DAMPED * np.einsum("mii->mi", squares).mean(axis=0)
        squares += np.diag(np.maximum(size, 1e-12))
        by = -np.linalg.solve(squares, np.einsum("mni,mn->mi", rows, left)[..., None])[..., 0] @ free
        turn = np.linalg.norm(by[:, :3], axis=1) / _LARGEST_TURN
        shift = np.linalg.norm(by[:, 3:], axis=1) / _LARGEST_SHIFT
        by /= np.maximum(np.maximum(turn, shift), 1.0)[:, None]
        return Rotation.from_rotvec(by[:, :3]).as_matrix() @ rotations, places + by[:, 3:]

    def _squares(self, tried: Array, rotations: Array, places: Array) -> Array:
        at = np.einsum("mij,nj->mni", rotations, tried) + places[:, None]
        near, away, beyond, _ = self._nearest(at)
        along = np.sum(away * self._normals[near], axis=-1) - self._tip_radius
        total: Array = np.sum(along**2 + beyond**2, axis=1)
        return total


def _rows(arms: Array, normals: Array) -> Array:
    return np.concatenate([np.cross(arms, normals), normals], axis=-1)
