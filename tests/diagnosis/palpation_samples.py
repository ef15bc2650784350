"""Palpation of a known surface, made by other means than the model's: foot points on a ball, a slider at 2 kHz."""

import math

import numpy as np
from scipy.spatial.transform import Rotation

from mmt_drake.recording import Recording
from mmt_drake.recording.check import completed
from mmt_drake.recording.signals import ORIENTATION

RATE_HZ, SUBSTEPS = 50, 20
STIFFNESS = 450.0


def ball(x, y, radius):
    """Height of a ball's top [m], 0 at its highest; level where there is no radius."""
    return np.sqrt(radius**2 - x**2 - y**2) - radius if math.isfinite(radius) else 0.0 * x


def stiffness_at(x, y, lump):
    """Of the contact over a lump [N/m]."""
    return STIFFNESS * (1.0 + lump * np.exp(-0.5 * ((x - 0.002) ** 2 + (y + 0.006) ** 2) / 0.005**2))


def palpation(
    *, radius=math.inf, mu=0.0, seconds=40.0, noise=0.003, seed=0, tool=None, lump=0.0, hardens=0.0
) -> Recording:
    """A tip in a raster over a ball, pressing 1 to 5 mm deep at 1.3 Hz; white noise on force and position.

    The load acts along the line to the nearest point of the surface, N = k depth. Friction is a spring of 0.8 k with a
    slider (Jenkins), fastened to that point. With a `tool` (3,) [m] the hand turns by 10 degrees, and recorded is the
    position of a point from which the tip is so far off in the hand's frame. A `lump` of 5 mm at (2, -6) mm is stiffer
    by so much of k; the contact `hardens` by k3 [N/m^3] times the depth cubed.
    """
    rng = np.random.default_rng(seed)
    t = np.arange(int(seconds * RATE_HZ * SUBSTEPS)) / (RATE_HZ * SUBSTEPS)
    x, y = 0.011 * np.sin(2.0 * np.pi * t / 5.3), 0.034 * (t / seconds - 0.5) + 0.002 * np.sin(2.0 * np.pi * t / 3.1)
    depth = 0.003 + 0.0018 * np.sin(2.0 * np.pi * 1.3 * t) + 0.0003 * np.sin(1.7 * t)
    if math.isfinite(radius):  # along the radius the depth is exact
        up = np.column_stack([x, y, ball(x, y, radius) + radius]) / radius
        tip = (radius - depth)[:, np.newaxis] * up - [0.0, 0.0, radius]
        foot = radius * up
    else:
        up = np.tile([0.0, 0.0, 1.0], (len(t), 1))
        foot = np.column_stack([x, y, 0.0 * x])
        tip = foot - depth[:, np.newaxis] * up
    load = stiffness_at(x, y, lump) * depth + hardens * depth**3
    force, stretch, k = load[:, np.newaxis] * up, np.zeros(3), 0.8 * STIFFNESS
    for i in range(1, len(t)) if mu > 0.0 else ():
        stretch = stretch + foot[i] - foot[i - 1]
        stretch = stretch - (stretch @ up[i]) * up[i]
        size = math.sqrt(stretch @ stretch)
        stretch = stretch * min(1.0, mu * load[i] / (k * max(size, 1e-12)))
        force[i] -= k * stretch
    columns = {}
    if tool is not None:
        turns = 0.2 * np.column_stack([np.sin(2.0 * np.pi * t / 7.3), np.sin(2.0 * np.pi * t / 4.1 + 1.0), 0.0 * t])
        hand = Rotation.from_rotvec(turns) * Rotation.from_rotvec([math.pi, 0.0, 0.0])
        tip = tip - hand.apply(tool)
        quaternion = hand.as_quat() * np.where(np.arange(len(t)) % 3, 1.0, -1.0)[:, np.newaxis]  # both are the same
        columns |= zip(ORIENTATION, quaternion[::SUBSTEPS].T, strict=True)
    for i, axis in enumerate("xyz"):
        columns[f"position_{axis}"] = (tip[:, i] + 3e-6 * rng.standard_normal(len(t)))[::SUBSTEPS]
        columns[f"force_{axis}"] = (force[:, i] + noise * rng.standard_normal(len(t)))[::SUBSTEPS]
    columns["in_contact"] = np.ones(len(t[::SUBSTEPS]))
    return completed(t[::SUBSTEPS], columns, "palpation")
