"""An arrow in Meshcat, which is drawn once and from then on only moved and stretched."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import Cylinder, Meshcat, MeshcatCone, Rgba
from pydrake.math import RigidTransform, RollPitchYaw

Array = NDArray[np.float64]

_HEAD = 0.25  # share of the arrow's length
_SHORTEST = 1e-3  # [m]; what is shorter is not shown


class Arrow:
    """An arrow of any length and direction.

    Args:
        meshcat: where it is drawn.
        path: in the scene tree.
        radius: of its shaft [m].
        colour: of all of it.
    """

    def __init__(self, meshcat: Meshcat, path: str, radius: float, colour: Rgba) -> None:
        self._meshcat, self._path = meshcat, path
        shaft = 1.0 - _HEAD
        meshcat.SetObject(f"{path}/shaft", Cylinder(radius, shaft), colour)
        meshcat.SetTransform(f"{path}/shaft", RigidTransform([0.0, 0.0, 0.5 * shaft]))
        meshcat.SetObject(f"{path}/head", MeshcatCone(_HEAD, 2.5 * radius, 2.5 * radius), colour)
        # Meshcat's cone has its tip at the origin and opens along +z.
        tip = RigidTransform(RollPitchYaw(math.pi, 0.0, 0.0), [0.0, 0.0, 1.0])
        meshcat.SetTransform(f"{path}/head", tip)
        self._shown = True
        self.show(np.zeros(3), np.zeros(3))

    def show(self, foot: Sequence[float] | Array, vector: Sequence[float] | Array) -> None:
        """Have it stand at `foot` (3) and reach to `foot + vector` (3) [m], table frame.

        It is hidden while it is shorter than 1 mm, or a number is not finite.
        """
        matrix = stretched(foot, vector)
        if (matrix is not None) != self._shown:
            self._shown = matrix is not None
            self._meshcat.SetProperty(self._path, "visible", self._shown)
        if matrix is not None:
            self._meshcat.SetTransform(self._path, matrix)


def stretched(foot: Sequence[float] | Array, vector: Sequence[float] | Array) -> Array | None:
    """The (4, 4) matrix that takes the unit vector along z, at the origin, to `vector` (3) at `foot` (3).

    Across its axis nothing is stretched. None where the length is below 1 mm or anything is not finite.
    """
    x, y, z = (float(value) for value in vector)
    px, py, pz = (float(value) for value in foot)
    length = math.sqrt(x * x + y * y + z * z)
    if not (length >= _SHORTEST and math.isfinite(length + px + py + pz)):
        return None
    a, b, c = x / length, y / length, z / length
    # An orthonormal frame about (a, b, c) without a branch at the pole: Duff et al., JCGT 6(1), 2017.
    sign = math.copysign(1.0, c)
    p = -1.0 / (sign + c)
    q = a * b * p
    return np.array(
        [
            [1.0 + sign * a * a * p, q, x, px],
            [sign * q, sign + b * b * p, y, py],
            [-sign * a, -b, z, pz],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )
