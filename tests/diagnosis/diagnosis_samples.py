"""Recordings whose every figure is known: formulas for the motion, a plain integration of its own for the object."""

from dataclasses import dataclass

import numba
import numpy as np

from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel, NormalContact
from mmt_drake.recording import Recording

M, K1, K2, B1, B2, NORMAL_K, NORMAL_B = 0.5, 0.0, 400.0, 18.0, 17.0, 400.0, 8.0
MODEL = FlexibleBoxModel(BoxParameters(m=M, k1=K1, k2=K2, b1=B1, b2=B2), NormalContact(k=NORMAL_K, b=NORMAL_B))
POSITION_NOISE, VELOCITY_NOISE, FORCE_NOISE = 1e-5, 5e-4, 0.015
TOUCHES, RELEASES = (1.5, 11.5), (10.0, 19.0)
TOP_HZ = 3.6


@dataclass(frozen=True)
class Strokes:
    """A probe that presses twice and strokes along y; every signal at any time (n,)."""

    seed: int = 0

    def y(self, t, order=0):
        rng = np.random.default_rng(self.seed)
        frequency = np.array([0.15, 0.31, 0.77, 1.3, 2.1, 2.9, TOP_HZ])
        amplitude = 0.03 * 0.3 / (0.3 + frequency) / frequency**0.5
        phase = 2 * np.pi * frequency * t[:, None] + rng.uniform(0, 2 * np.pi, len(frequency))
        if order == 0:
            return np.sin(phase) @ amplitude
        return np.cos(phase) @ (2 * np.pi * frequency * amplitude)

    def z(self, t, order=0):
        """From 12 mm above to about 8 mm below, with a swell of 3 mm, by quintic steps that cross z = 0 on time."""
        high, low = 12e-3, -8e-3 + 3e-3 * np.sin(2 * np.pi * 0.4 * t)
        low_rate = 3e-3 * 2 * np.pi * 0.4 * np.cos(2 * np.pi * 0.4 * t)
        down, rate = np.zeros_like(t), np.zeros_like(t)
        for touch, release in zip(TOUCHES, RELEASES, strict=True):
            for middle, sign in ((touch, 1.0), (release, -1.0)):
                s = np.clip((t - (middle - 0.15)) / 0.3, 0.0, 1.0)
                down += sign * s**3 * (10 - 15 * s + 6 * s**2)
                rate += sign * 30 * s**2 * (1 - s) ** 2 / 0.3
        return high + (low - high) * down if order == 0 else (low - high) * rate + low_rate * down


def contact_recording(
    seconds=20.0, rate=1000.0, seed=0, noise=1.0, velocity=True, flag=True, friction=0.0, motion=None, time=None
) -> Recording:
    """The object of `MODEL` under `Strokes`, with white noise on every channel.

    Args:
        noise: times the usual levels.
        velocity, flag: whether the columns `velocity_*` and `in_contact` are there.
        friction: smooth Coulomb friction at the table [N].
        motion: function t -> (position, velocity) of y, in the place of the strokes.
        time: sample times, in the place of an even clock.
    """
    t = np.arange(round(seconds * rate)) / rate if time is None else time
    strokes, fine = Strokes(seed), 2
    grid = np.interp(np.arange(fine * (len(t) - 1) + 1) / fine, np.arange(len(t)), t)
    move = motion or (lambda s: (strokes.y(s), strokes.y(s, 1)))
    y, vy, z, vz = *move(grid), strokes.z(grid), strokes.z(grid, 1)
    contact = z < 0
    force_y = _slide(grid, y, vy, contact, friction)[::fine]
    force_z = np.where(contact, -NORMAL_K * z - NORMAL_B * vz, 0.0)[::fine]
    zero = np.zeros(len(t))
    rng = np.random.default_rng(seed + 1000)
    tables = {
        "position": (np.column_stack([zero + 0.4, y[::fine], z[::fine]]), POSITION_NOISE),
        "velocity": (np.column_stack([zero, vy[::fine], vz[::fine]]), VELOCITY_NOISE),
        "force": (np.column_stack([zero, force_y, force_z]), FORCE_NOISE),
    }
    columns = {}
    for name, (table, level) in tables.items():
        noisy = table + noise * level * rng.standard_normal(table.shape)
        columns |= {f"{name}_{axis}": noisy[:, i] for i, axis in enumerate("xyz")}
    columns["in_contact"] = contact[::fine].astype(float)
    derived = set()
    if not velocity:
        derived |= {f"velocity_{axis}" for axis in "xyz"}
        columns |= {f"velocity_{axis}": np.gradient(columns[f"position_{axis}"], t) for axis in "xyz"}
    if not flag:
        derived.add("in_contact")
        columns["in_contact"] = (columns["position_z"] < 0).astype(float)
    return Recording(t, columns, "made.csv", derived=frozenset(derived))


@numba.njit(cache=True)
def _slide(t, y, vy, contact, friction):
    """Force on the probe (n,), by the implicit Euler rule with the touch on a sample."""
    body, speed, anchor, force = 0.0, 0.0, 0.0, np.zeros(len(t))
    for i in range(1, len(t)):
        h = t[i] - t[i - 1]
        if contact[i] and not contact[i - 1]:
            anchor = y[i] - body
        k, b, push = 0.0, 0.0, 0.0
        if contact[i]:
            k, b, push = K2, B2, K2 * (y[i] - anchor) + B2 * vy[i]
        drag = friction * np.tanh(speed / 2e-4)
        slope = B1 + b + friction / 2e-4 / np.cosh(min(abs(speed) / 2e-4, 300.0)) ** 2
        # Linearised about the old state, implicit in the new one.
        wanted = push - (K1 + k) * body - (B1 + b) * speed - drag
        change = h * (wanted - h * (K1 + k) * speed) / (M + h * slope + h * h * (K1 + k))
        speed += change
        body += h * speed
        if contact[i]:
            force[i] = -(K2 * (y[i] - body - anchor) + B2 * (vy[i] - speed))
    return force


def driven_recording(seconds=10.0, rate=1000.0, noise=1e-6, seed=0) -> Recording:
    """m = 2 kg on nothing: x'' = u / 2, u a sum of sines, x its double integral from rest."""
    t = np.arange(round(seconds * rate)) / rate
    w = 2 * np.pi * np.array([0.5, 1.3])
    u = np.sin(w * t[:, None]).sum(axis=1)
    x = ((t[:, None] / w - np.sin(w * t[:, None]) / w**2) / 2.0).sum(axis=1)
    noisy = x + noise * np.random.default_rng(seed).standard_normal(len(t))
    return Recording(
        t,
        {"input": u, "output": noisy, "output_rate": np.gradient(noisy, t)},
        "driven.csv",
        derived=frozenset({"output_rate"}),
    )
