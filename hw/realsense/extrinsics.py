"""The camera's pose in the table frame: a file, and a calibration that needs nothing but the bare table."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Self

import numpy as np
import yaml
from numpy.typing import ArrayLike
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RotationMatrix

from mmt_drake.errors import BadInput, check_number
from mmt_drake.numeric.arrays import Array
from mmt_drake.quantities import Checked
from mmt_drake.recording.atomic import replacing
from mmt_drake.typed_yaml import fill, parse, read_text

_TRIES, _TRIED_ON, _LEAST_POINTS = 200, 2000, 100
_LEAST_SHARE = 0.5  # of the points on the plane; less is no bare table
_STEEPEST_DEG = 75.0  # of the optical axis to the table's normal


@dataclass(frozen=True)
class Extrinsics(Checked):
    """A camera's optical frame (x right, y down in the image, z ahead) in the table frame.

    A point p of the optical frame is at R p + `position` in the table frame.

    Attributes:
        position: of the optical centre [m], table frame.
        quaternion: w, x, y, z of R; normalised when read.

    Raises:
        BadInput: a number that is not finite, or a quaternion of no length.
    """

    position: tuple[float, float, float]
    quaternion: tuple[float, float, float, float]

    CALLED: ClassVar = "extrinsics"

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("position", "quaternion"):
            object.__setattr__(self, name, tuple(getattr(self, name)))
        if math.hypot(*self.quaternion) < 1e-6:
            raise BadInput("extrinsics", at="quaternion", found=self.quaternion, expected="a rotation: w, x, y, z")

    @classmethod
    def from_matrix(cls, rotation: Array, position: ArrayLike) -> Self:
        """From R (3, 3) and the optical centre (3) [m]."""
        w, x, y, z = (float(q) for q in RotationMatrix(rotation).ToQuaternion().wxyz())
        px, py, pz = (float(p) for p in np.asarray(position, dtype=np.float64))
        return cls((px, py, pz), (w, x, y, z))

    def rotation(self) -> Array:
        """(3, 3) R, from the optical frame to the table's."""
        w, x, y, z = self.quaternion
        matrix: Array = RotationMatrix(Quaternion(np.array([w, x, y, z]) / math.hypot(w, x, y, z))).matrix()
        return matrix

    @classmethod
    def read(cls, path: str | Path) -> Self:
        """From a YAML file with the two attributes as keys.

        Raises:
            BadInput: the file cannot be read, or says something else.
        """
        said = parse(read_text(path, "a camera's extrinsics"), str(path))
        for key in ("position", "quaternion"):
            if isinstance(said, dict) and key not in said:
                raise BadInput(path, at=key, found="nothing", expected="position (3) [m] and quaternion (w, x, y, z)")
        return fill(cls, said if said is not None else [], str(path))

    def write(self, path: str | Path) -> None:
        """To a YAML file, whole or not at all.

        Raises:
            BadInput: it cannot be written.
        """
        said = {"position": list(self.position), "quaternion": list(self.quaternion)}
        with replacing(path) as temporary:
            head = "# optical frame of a depth camera in the table frame: m; w, x, y, z\n"
            temporary.write_text(head + str(yaml.safe_dump(said, default_flow_style=None)))


@dataclass(frozen=True)
class Calibration:
    """What `calibrate_on_table` found.

    Attributes:
        extrinsics: where the camera is.
        residual: standard deviation of the table's points about the plane [m].
        share: of all points that lie on the plane.
    """

    extrinsics: Extrinsics
    residual: float
    share: float


def calibrate_on_table(
    points: ArrayLike,
    *,
    object_height: float = 0.0,
    foot: tuple[float, float] = (0.0, 0.0),
    heading: float = 0.0,
    tolerance: float = 0.005,
) -> Calibration:
    """Find the camera's height and tilt from a cloud of the bare table.

    A plane tells three of six coordinates; these three decide contact. The other three are said: contact does not
    depend on them, only which part of the table is which. Planes through three random points compete for the most
    points near them (RANSAC; Fischler and Bolles 1981), then total least squares on those.

    Args:
        points: (n, 3) [m], optical frame; rows that are not finite are left out.
        object_height: of the object's undeformed top, where z is 0, above the table [m].
        foot: x, y of the table frame below the optical centre [m].
        heading: direction of the image's x axis on the table, from the table's x towards its y [rad].
        tolerance: how far from the plane a point of the table may be [m]; several times the camera's noise.

    Raises:
        BadInput: too few points, no plane that holds half of them, or one seen at too flat an angle.
    """
    given = np.asarray(points, dtype=np.float64)
    if given.ndim != 2 or given.shape[1] != 3:
        raise BadInput("calibration", at="points", found=f"shape {given.shape}", expected="shape (n, 3)")
    check_number("calibration", "tolerance", tolerance, least=0.0, open_interval=True)
    given = given[np.isfinite(given).all(axis=1)]
    if len(given) < _LEAST_POINTS:
        raise BadInput("calibration", at="points", found=len(given), expected=f"{_LEAST_POINTS} or more of the table")
    normal, middle = _best_plane(given, tolerance, np.random.default_rng(0))
    for _ in range(3):
        near = np.abs((given - middle) @ normal) < tolerance
        normal, middle = _least_squares(given[near])
    distances = (given - middle) @ normal
    near = np.abs(distances) < tolerance
    share = float(near.mean())
    if share < _LEAST_SHARE:
        expected = f"{_LEAST_SHARE:.0%} or more: a bare table"
        raise BadInput("calibration", at="points on one plane", found=f"{share:.0%}", expected=expected)
    if normal @ middle > 0.0:  # the table's normal points to the side that the camera is on
        normal = -normal
    tilt = math.degrees(math.acos(min(1.0, -float(normal[2]))))
    if not tilt < _STEEPEST_DEG:
        raise BadInput("calibration", at="tilt", found=f"{tilt:.0f} deg", expected=f"less than {_STEEPEST_DEG:g} deg")
    across = np.array([1.0, 0.0, 0.0]) - normal[0] * normal
    across /= np.linalg.norm(across)
    level = np.vstack([across, np.cross(normal, across), normal])
    c, s = math.cos(heading), math.sin(heading)
    rotation = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ level
    height = -float(normal @ middle) - object_height
    found = Extrinsics.from_matrix(rotation, (*foot, height))
    return Calibration(found, float(distances[near].std()), share)


def _best_plane(points: Array, tolerance: float, random: np.random.Generator) -> tuple[Array, Array]:
    tried_on = points[random.permutation(len(points))[:_TRIED_ON]]
    best, most = (np.array([0.0, 0.0, 1.0]), points[0]), -1
    for _ in range(_TRIES):
        a, b, c = tried_on[random.choice(len(tried_on), 3, replace=False)]
        normal = np.cross(b - a, c - a)
        size = np.linalg.norm(normal)
        if size < 1e-9:
            continue
        normal = normal / size
        near = int((np.abs((tried_on - a) @ normal) < tolerance).sum())
        if near > most:
            best, most = (normal, a), near
    return best


def _least_squares(points: Array) -> tuple[Array, Array]:
    """Unit normal and middle of the plane with the least sum of squared distances."""
    middle = points.mean(axis=0)
    _, vectors = np.linalg.eigh((points - middle).T @ (points - middle))
    normal: Array = vectors[:, 0]
    return normal, middle
