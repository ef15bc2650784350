"""Settings of the way from a depth image to the cloud of a surface."""

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from mmt_drake.errors import BadInput
from mmt_drake.quantities import Checked, Quantity

Cells = tuple[int, int, int]
Vector = tuple[float, float, float]
_MOST_CELLS = 20_000_000


@dataclass(frozen=True)
class CloudSettings(Checked):
    """Crop, edge filter and voxel filter; lengths in metres.

    Attributes:
        low: least x, y, z kept, table frame.
        high: greatest x, y, z kept, table frame.
        near: least depth that is believed; cameras tell nonsense below their minimum.
        far: greatest depth that is believed.
        edge: a pixel whose depth differs by more than this from one of its four neighbours is dropped: between two
            surfaces a camera reports points that are on neither (flying pixels). Well above the noise of the depth;
            null leaves the filter out.
        voxel: edge of the cubes whose points are replaced by their mean; null keeps all. They are fixed in the table
            frame with the origin in the middle of one: the object's top, at z = 0, would otherwise fall into two layers
            of cubes, a surface into a higher and a lower one.
        support: so many pixels a cube needs, else what it holds is dropped.

    Raises:
        BadInput: a number out of its range, an empty box, or more cubes than memory should hold.
    """

    low: Vector = (-0.25, -0.25, -0.02)
    high: Vector = (0.25, 0.25, 0.02)
    near: float = 0.1
    far: float = 2.0
    edge: Annotated[float | None, Quantity("m", positive=True)] = 0.01
    voxel: Annotated[float | None, Quantity("m", positive=True)] = 0.003
    support: Annotated[int, Quantity("px", 1, whole=True)] = 2

    CALLED: ClassVar = "camera"

    def __post_init__(self) -> None:
        super().__post_init__()
        for low, high, axis in zip(self.low, self.high, "xyz", strict=True):
            if not low < high:
                raise BadInput("camera", at=f"low, high of {axis}", found=f"{low}, {high}", expected="low < high [m]")
        if not 0.0 < self.near < self.far < math.inf:
            raise BadInput("camera", at="near, far", found=f"{self.near}, {self.far}", expected="0 < near < far [m]")
        if self.voxel is not None and math.prod(self.cells()[1]) > _MOST_CELLS:
            found = f"{self.voxel} m in a box of {' x '.join(map(str, self.cells()[1]))} cubes"
            raise BadInput("camera", at="voxel", found=found, expected=f"{_MOST_CELLS} cubes at most")

    def cells(self) -> tuple[Cells, Cells]:
        """Number, counted from the cube around the origin, of the first cube along x, y, z, and how many there are.

        Raises:
            ValueError: there is no voxel filter.
        """
        if self.voxel is None:
            raise ValueError("no voxel filter")
        corners = np.floor(np.array([self.low, self.high]) / self.voxel + 0.5).astype(int)
        (x, y, z), (nx, ny, nz) = corners[0].tolist(), (corners[1] - corners[0] + 1).tolist()
        return (x, y, z), (nx, ny, nz)
