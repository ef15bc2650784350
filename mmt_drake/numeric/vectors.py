"""Three numbers as a vector, in compiled code: tuples live in registers, where arrays would have to be allocated."""

import math

from numba import njit

from mmt_drake.numeric.arrays import Array

Vector = tuple[float, float, float]

ZERO: Vector = (0.0, 0.0, 0.0)
UP: Vector = (0.0, 0.0, 1.0)


@njit(cache=True)
def plus(a: Vector, b: Vector) -> Vector:
    """a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@njit(cache=True)
def minus(a: Vector, b: Vector) -> Vector:
    """a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@njit(cache=True)
def times(s: float, a: Vector) -> Vector:
    """s a."""
    return s * a[0], s * a[1], s * a[2]


@njit(cache=True)
def dot(a: Vector, b: Vector) -> float:
    """a·b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True)
def length(a: Vector) -> float:
    """‖a‖."""
    return math.sqrt(dot(a, a))


@njit(cache=True)
def get(values: Array, at: int) -> Vector:
    """The vector whose components begin at `at` of a longer array."""
    return values[at], values[at + 1], values[at + 2]


@njit(cache=True)
def put(values: Array, at: int, a: Vector) -> None:
    """Write a vector into a longer array from `at` on."""
    values[at], values[at + 1], values[at + 2] = a


@njit(cache=True)
def cross(a: Vector, b: Vector) -> Vector:
    """a x b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@njit(cache=True)
def unit(a: Vector, otherwise: Vector) -> Vector:
    """The unit vector along a; `otherwise` where a is too short to have a direction."""
    size = length(a)
    return times(1.0 / size, a) if size > 1e-12 else otherwise


@njit(cache=True)
def across(a: Vector, n: Vector) -> Vector:
    """The part of a across the unit vector n."""
    return minus(a, times(dot(a, n), n))
