"""Bicubic interpolation of a table, smooth through its points: slopes are central differences (Catmull and Rom 1974).

The weights of four neighbours in a row, at -1, 0, 1 and 2, for a place t from 0 to 1; in two dimensions they multiply.
"""

from numba import njit

Weights = tuple[float, float, float, float]


@njit(cache=True, error_model="numpy")
def weights(t: float) -> Weights:
    """Of the value."""
    return (
        t * (-0.5 + t * (1.0 - 0.5 * t)),
        1.0 + t * t * (-2.5 + 1.5 * t),
        t * (0.5 + t * (2.0 - 1.5 * t)),
        t * t * (-0.5 + 0.5 * t),
    )


@njit(cache=True, error_model="numpy")
def slopes(t: float) -> Weights:
    """Of the slope, per distance of the neighbours."""
    return (-0.5 + t * (2.0 - 1.5 * t), t * (-5.0 + 4.5 * t), 0.5 + t * (4.0 - 4.5 * t), t * (-1.0 + 1.5 * t))


@njit(cache=True, error_model="numpy")
def bends(t: float) -> Weights:
    """Of the second derivative, per distance squared."""
    return 2.0 - 3.0 * t, -5.0 + 9.0 * t, 4.0 - 9.0 * t, -1.0 + 3.0 * t
