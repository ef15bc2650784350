"""A picture in colour beside a depth image, and the colours of points in it."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mmt_drake.hw.realsense.depth import Intrinsics
from mmt_drake.numeric.arrays import Array


@dataclass(frozen=True, eq=False)
class ColourImage:
    """A picture in colour. What is hidden from its camera, which stands beside that of depth, is taken to be seen.

    Attributes:
        pixels: (height, width, 3) sRGB, 0 to 255.
        intrinsics: of its camera.
        rotation: (3, 3) from the optical frame of depth to that of colour.
        translation: (3,) of the camera of depth in the optical frame of colour [m].
    """

    pixels: NDArray[np.uint8]
    intrinsics: Intrinsics
    rotation: Array = field(default_factory=lambda: np.eye(3))
    translation: Array = field(default_factory=lambda: np.zeros(3))

    def at(self, points: Array) -> Array:
        """(n, 3) sRGB from 0 to 1 of points (n, 3) [m] in the optical frame of depth; NaN beyond the picture."""
        seen = points @ self.rotation.T + self.translation
        found = np.full(seen.shape, np.nan)
        ahead = np.flatnonzero(seen[:, 2] > 0.0)
        u, v = np.rint(self.intrinsics.pixels(seen[ahead])).T.astype(np.int64)
        inside = (u >= 0) & (u < self.intrinsics.width) & (v >= 0) & (v < self.intrinsics.height)
        found[ahead[inside]] = self.pixels[v[inside], u[inside]] / 255.0
        return found
