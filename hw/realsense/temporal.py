"""Averages the depth of a pixel over frames, until it jumps."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mmt_drake.hw.realsense.depth import DepthImage
from mmt_drake.quantities import Checked, Length, Quantity

Image = NDArray[np.float32]


@dataclass(frozen=True)
class TemporalFilter(Checked):
    """A first-order low-pass in every pixel, as depth cameras offer it, here with its memory outside.

    White noise comes out √(`alpha`/(2 - `alpha`)) times as large; a surface that rises is seen (1 - alpha)/alpha frames
    late. A surface that slides along itself looks the same all the time, and is not late.

    Attributes:
        alpha: weight of the new frame, above 0, 1 at most.
        step: a pixel that changes by more than this starts anew [m].

    Raises:
        BadInput: a number out of its range.
    """

    alpha: Annotated[float, Quantity("", 0.0, 1.0, positive=True)] = 0.2
    step: Length = 0.01

    CALLED: ClassVar = "temporal filter"

    def __call__(self, before: Image | None, depth: DepthImage, unit: float) -> Image:
        """The next image of the filter; nothing is changed in place.

        Args:
            before: (height, width) its last image [m], 0 without depth; None for the first frame, or another size.
            depth: (height, width) the new frame, in units.
            unit: of it [m].

        Returns:
            (height, width) [m]; a pixel without depth now has none, whatever it had before.
        """
        if before is None or before.shape != depth.shape:
            before = np.zeros(depth.shape, np.float32)
        return _filtered(before, np.ascontiguousarray(depth), unit, self.alpha, self.step)


@njit(cache=True, nogil=True)
def _filtered(before: Image, depth: DepthImage, unit: float, alpha: float, step: float) -> Image:
    out = np.zeros(depth.shape, np.float32)
    for v in range(depth.shape[0]):
        for u in range(depth.shape[1]):
            if depth[v, u] == 0:
                continue
            new, old = depth[v, u] * unit, before[v, u]
            known = old > 0.0 and abs(new - old) <= step
            out[v, u] = old + alpha * (new - old) if known else new
    return out
