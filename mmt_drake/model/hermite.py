"""Cubic Hermite interpolation: what the probe does between two samples of position and velocity."""

from __future__ import annotations

from numba import njit


@njit(inline="always")
def hermite_coefficients(x0: float, v0: float, x1: float, v1: float, h: float) -> tuple[float, float]:
    """(c2, c3) of x(s) = x0 + v0 s + c2 s^2 + c3 s^3 through both samples, 0 <= s <= h [s]."""
    rate = 1.0 / h
    slope = (x1 - x0) * rate
    c2 = (3.0 * slope - 2.0 * v0 - v1) * rate
    c3 = (v0 + v1 - 2.0 * slope) * (rate * rate)
    return c2, c3


@njit(inline="always")
def hermite_position(x0: float, v0: float, c2: float, c3: float, s: float) -> float:
    """Position at s [s] after the first sample."""
    return x0 + s * (v0 + s * (c2 + s * c3))


@njit(inline="always")
def hermite_velocity(v0: float, c2: float, c3: float, s: float) -> float:
    """Velocity at s [s] after the first sample."""
    return v0 + s * (2.0 * c2 + 3.0 * s * c3)
