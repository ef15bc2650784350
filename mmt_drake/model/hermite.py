"""Cubic Hermite interpolation: what the probe does between two samples of position and velocity."""

from typing import NamedTuple

from numba import njit


class Cubic(NamedTuple):
    """x(s) = x0 + v0 s + c2 s^2 + c3 s^3, s [s] from the first of two samples."""

    x0: float
    v0: float
    c2: float
    c3: float


@njit(cache=True)
def cubic(x0: float, v0: float, x1: float, v1: float, h: float) -> Cubic:
    """The cubic through position and velocity of both samples, h [s] apart."""
    rate = 1.0 / h
    slope = (x1 - x0) * rate
    return Cubic(x0, v0, (3.0 * slope - 2.0 * v0 - v1) * rate, (v0 + v1 - 2.0 * slope) * (rate * rate))


@njit(cache=True)
def position_at(c: Cubic, s: float) -> float:
    """x(s)."""
    return c.x0 + s * (c.v0 + s * (c.c2 + s * c.c3))


@njit(cache=True)
def velocity_at(c: Cubic, s: float) -> float:
    """x'(s)."""
    return c.v0 + s * (2.0 * c.c2 + 3.0 * s * c.c3)
