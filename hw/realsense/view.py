"""The view of a simulated depth camera: what it looks at, and from where."""

import math
from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from mmt_drake.errors import BadInput, check_number
from mmt_drake.hw.realsense.depth import Intrinsics
from mmt_drake.hw.realsense.extrinsics import Extrinsics

Point = tuple[float, float]
Colour = tuple[float, float, float]
"""sRGB from 0 to 1."""
GREY: Colour = (0.6, 0.6, 0.6)


class Solid(NamedTuple):
    """A body on a table, before anything moves.

    Attributes:
        size: of it along x, y, z [m]; of a cylinder the first is the diameter.
        at: x, y of its middle [m].
        top: height of its top in the table frame [m].
        round: it is a cylinder.
        colour: of it.
    """

    size: tuple[float, float, float]
    at: Point
    top: float = 0.0
    round: bool = False
    colour: Colour = GREY


@dataclass(frozen=True)
class TableScene:
    """What stands on a table.

    Attributes:
        solids: the bodies; without any it is the bare table, for a calibration.
        low: height of the table in the table frame [m].
        at: x, y of the table's middle [m].
        probe: radius of the probe, a cylinder above its tip that hides what is behind it [m]; None: it is not seen.
    """

    solids: tuple[Solid, ...]
    low: float
    at: Point = (0.0, 0.0)
    probe: float | None = None

    @classmethod
    def of_box(cls, size: tuple[float, float, float], at: Point = (0.0, 0.0)) -> Self:
        """One box, the middle of its undeformed top at z = 0 of the table frame.

        Raises:
            BadInput: a side that is no length.
        """
        for side in size:
            check_number("scene", "size", side, least=0.0, open_interval=True)
        (wide, deep, high), (x, y) = size, at
        return cls((Solid((wide, deep, high), (x, y)),), -high, (x, y))


BOX = TableScene.of_box((0.2, 0.2, 0.08))


@dataclass(frozen=True)
class View:
    """A pinhole camera above an object; it looks at the middle of the object's top from the side of negative y.

    Attributes:
        focal: length of the camera [px]. At 640 x 480 the field of view that the data sheet of a RealSense D415 names
            (50 by 40 deg) is 690 and 660 px, that of a D435 (75 by 62 deg) 420 and 400 px; 610 is between them, and so
            is the noise.
        width: of the part of the image that is used [px]; its height is three quarters of that.
        height: of the camera above the object [m].
        tilt: of the camera from straight down [deg].

    Raises:
        BadInput: a number out of its range.
    """

    focal: float = 610.0
    width: int = 400
    height: float = 0.45
    tilt: float = 20.0

    def __post_init__(self) -> None:
        self.intrinsics()  # refuses a focal length or an image without meaning
        check_number("view", "height", self.height, least=0.0, open_interval=True)
        if not 0.0 <= self.tilt <= 75.0:
            raise BadInput("view", at="tilt", found=self.tilt, expected="0 to 75 deg")

    def intrinsics(self) -> Intrinsics:
        """Of the middle of the camera's image, where the object is."""
        width, height = self.width, self.width * 3 // 4
        return Intrinsics(width, height, self.focal, self.focal, 0.5 * (width - 1), 0.5 * (height - 1))

    def extrinsics(self, at: Point = (0.0, 0.0)) -> Extrinsics:
        """Where the camera is.

        Args:
            at: x, y of the middle of the object's top [m].
        """
        tilt = math.radians(self.tilt)
        # x of the image along the table's x, then turned about it by half a turn and the tilt.
        c, s = -math.cos(tilt), -math.sin(tilt)
        rotation = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
        return Extrinsics.from_matrix(rotation, (at[0], at[1] - self.height * math.tan(tilt), self.height))
