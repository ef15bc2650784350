"""The thesis's object under a hand's strokes, made without the package: closed forms, exact matrix integration."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from mmt_drake.numeric.arrays import Array

FREQUENCIES = np.array([0.21, 0.47, 0.83, 1.3, 1.9, 2.7, 3.6])  # Hz, up to the mode that the thesis wants excited
AMPLITUDES = np.array([20.0, 15.0, 10.0, 6.0, 4.0, 3.0, 2.0]) * 1e-3  # m


@dataclass(frozen=True)
class Box:
    """Experiment 1 of the thesis by default."""

    m: float = 1.0
    k1: float = 0.0
    k2: float = 500.0
    b1: float = 60.0
    b2: float = 60.0
    Fc: float = 0.05
    normal_k: float = 500.0
    normal_b: float = 60.0


def phasors(seed: int) -> NDArray[np.complex128]:
    return AMPLITUDES * np.exp(2j * np.pi * np.random.default_rng(seed).uniform(size=FREQUENCIES.size))


def periodic_axis(box: Box, t: Array, seed: int = 0) -> tuple[Array, Array, Array]:
    """x, v, F of a tangential axis without friction, in the steady state: F = -H(j omega) x."""
    s = 2j * np.pi * FREQUENCIES
    body = (box.k2 + box.b2 * s) / (box.m * s**2 + (box.b1 + box.b2) * s + box.k1 + box.k2)
    stiffness = (box.k2 + box.b2 * s) * (1.0 - body)
    waves = phasors(seed) * np.exp(np.outer(t, s))
    return waves.sum(1).real, (s * waves).sum(1).real, -(stiffness * waves).sum(1).real


def sliding_axis(box: Box, t: Array, seed: int = 0, substeps: int = 4) -> tuple[Array, Array, Array]:
    """x, v, F of a tangential axis from rest with Coulomb friction; exact for an input linear in the substep."""
    fine = np.linspace(t[0], t[-1], (len(t) - 1) * substeps + 1)
    s = 2j * np.pi * FREQUENCIES
    waves = phasors(seed) * np.exp(np.outer(fine, s))
    ramp = np.clip(fine - fine[0], 0.0, 1.0)
    window, slope = ramp**3 * (10 - 15 * ramp + 6 * ramp**2), 30 * ramp**2 * (1 - ramp) ** 2
    x, v = waves.sum(1).real, (s * waves).sum(1).real
    x, v = x * window, v * window + x * slope
    h = fine[1] - fine[0]
    system = np.zeros((8, 8))
    system[0, 1] = 1.0
    system[1, :2] = -(box.k1 + box.k2) / box.m, -(box.b1 + box.b2) / box.m
    system[1, 2:5] = box.k2 / box.m, box.b2 / box.m, -1.0 / box.m
    system[2:5, 5:8] = np.eye(3)
    step = expm(system * h)
    A, B0, B1 = step[:2, :2], step[:2, 2:4] - step[:2, 5:7] / h, step[:2, 5:7] / h
    friction = step[:2, 4]
    forced = np.column_stack([x[:-1], v[:-1]]) @ B0.T + np.column_stack([x[1:], v[1:]]) @ B1.T
    q, w = 0.0, 0.0
    out = np.empty((len(fine), 2))
    for i in range(len(fine)):
        out[i] = q, w
        if i < len(forced):
            c = box.Fc if w > 0 else -box.Fc if w < 0 else 0.0
            q, w = (
                A[0, 0] * q + A[0, 1] * w + forced[i, 0] + friction[0] * c,
                A[1, 0] * q + A[1, 1] * w + forced[i, 1] + friction[1] * c,
            )
    F = -(box.k2 * (x - out[:, 0]) + box.b2 * (v - out[:, 1]))
    return x[::substeps], v[::substeps], F[::substeps]


def measurement(box: Box, x_axis: tuple[Array, ...], y_axis: tuple[Array, ...], t: Array) -> Array:
    """(n, 9) as the estimator sees it, pressed down by 2 to 8 mm all the time."""
    w = 2 * np.pi * 0.7
    z, v_z = -0.005 + 0.003 * np.sin(w * t), 0.003 * w * np.cos(w * t)
    normal = (z, v_z, -box.normal_k * z - box.normal_b * v_z)
    return np.column_stack([axis[i] for i in range(3) for axis in (x_axis, y_axis, normal)])


def strokes(box: Box, seconds: float, step: float = 1e-3, noise: float = 0.0, seed: int = 0) -> tuple[Array, Array]:
    """Time and measurement (n, 9) of strokes in x and y with friction; `noise` is the force sensor's [N]."""
    t = np.arange(round(seconds / step)) * step
    data = measurement(box, sliding_axis(box, t, seed), sliding_axis(box, t, seed + 1), t)
    data[:, 6:9] += noise * np.random.default_rng(seed + 2).standard_normal((len(t), 3))
    return t, data


def without_friction(box: Box, seconds: float, step: float = 1e-3) -> Array:
    """Measurement (n, 9) of frictionless strokes in their steady state."""
    t = np.arange(round(seconds / step)) * step
    box = replace(box, Fc=0.0)
    return measurement(box, periodic_axis(box, t, 0), periodic_axis(box, t, 1), t)


def force_error(theta: Array, box: Box, frequency: Array) -> Array:
    """|H_estimated / H_true - 1| at `frequency` [Hz]."""
    s = 2j * np.pi * frequency

    def stiffness(m: float, k1: float, k2: float, b1: float, b2: float) -> NDArray[np.complex128]:
        return (k2 + b2 * s) * (m * s * s + b1 * s + k1) / (m * s * s + (b1 + b2) * s + k1 + k2)

    return np.abs(stiffness(*theta[:5]) / stiffness(box.m, box.k1, box.k2, box.b1, box.b2) - 1.0)
