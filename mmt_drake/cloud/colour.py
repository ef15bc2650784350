"""Colours by how they look to the eye: CIELAB, in which equal distances are about equally different.

IEC 61966-2-1 (sRGB) and CIE 15 (CIELAB) with the white of D65 and the 2 degree observer.
"""

import numpy as np

from mmt_drake.numeric.arrays import Array

_TO_XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
_WHITE = _TO_XYZ.sum(axis=1)
_LINEAR = (6.0 / 29.0) ** 3


def cielab(srgb: Array) -> Array:
    """(..., 3) L* from 0 (black) to 100 (white), a* from green to red, b* from blue to yellow; of sRGB from 0 to 1."""
    srgb = np.asarray(srgb, dtype=np.float64)
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((np.maximum(srgb, 0.0) + 0.055) / 1.055) ** 2.4)
    share = linear @ _TO_XYZ.T / _WHITE
    f = np.where(share > _LINEAR, np.cbrt(share), share / (3.0 * (6.0 / 29.0) ** 2) + 4.0 / 29.0)
    x, y, z = np.moveaxis(f, -1, 0)
    return np.stack([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)], axis=-1)
