"""Palpation of a known surface, made by the trial's means, which share nothing with the model."""

import math

import numpy as np
from scipy.spatial.transform import Rotation

from mmt_drake.diagrams.proof.trial.palpation import RATE_HZ, SUBSTEPS, level, palpated, recorded
from mmt_drake.diagrams.proof.trial.palpation import ball as ball_surface

STIFFNESS = 450.0


def ball(x, y, radius):
    """Height of a ball's top [m], 0 at its highest; level where there is no radius."""
    return ball_surface(radius)(x, y)[0] if math.isfinite(radius) else 0.0 * x


def stiffness_at(x, y, lump):
    """Of the contact over a lump [N/m]."""
    return STIFFNESS * (1.0 + lump * np.exp(-0.5 * ((x - 0.002) ** 2 + (y + 0.006) ** 2) / 0.005**2))


def palpation(*, radius=math.inf, mu=0.0, seconds=40.0, noise=0.003, seed=0, tool=None, lump=0.0, hardens=0.0):
    """A tip in a raster over a ball, pressing 1 to 5 mm deep at 1.3 Hz.

    With a `tool` (3,) [m] the hand turns by 10 degrees, and recorded is the position of a point from which the tip is
    so far off in the hand's frame. A `lump` of 5 mm at (2, -6) mm is stiffer by so much of k; the contact
    `hardens` by k3 [N/m^3] times the depth cubed.
    """
    t = np.arange(int(seconds * RATE_HZ * SUBSTEPS)) / (RATE_HZ * SUBSTEPS)
    x, y = 0.011 * np.sin(2.0 * np.pi * t / 5.3), 0.034 * (t / seconds - 0.5) + 0.002 * np.sin(2.0 * np.pi * t / 3.1)
    depth = 0.003 + 0.0018 * np.sin(2.0 * np.pi * 1.3 * t) + 0.0003 * np.sin(1.7 * t)
    surface = ball_surface(radius) if math.isfinite(radius) else level
    k = stiffness_at(x, y, lump) + hardens * depth**2
    tip = palpated(surface, np.column_stack([x, y]), depth, k, mu=mu)
    hand = None
    if tool is not None:
        turns = 0.2 * np.column_stack([np.sin(2.0 * np.pi * t / 7.3), np.sin(2.0 * np.pi * t / 4.1 + 1.0), 0.0 * t])
        hand = Rotation.from_rotvec(turns) * Rotation.from_rotvec([math.pi, 0.0, 0.0])
        tool = dict(zip("xyz", tool, strict=True))
    return recorded(tip, noise, np.random.default_rng(seed), hand, tool)
