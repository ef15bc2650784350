"""Motions, and what the trial's engine answers to them."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from mmt_drake.diagrams.trial.laws import Concealed, linear_object, with_effects
from mmt_drake.diagrams.trial.motions import ProbeMotion
from mmt_drake.diagrams.trial.plant import QUICK_STEP_S
from mmt_drake.diagrams.trial.sensor import Sensor
from mmt_drake.diagrams.trial.session import tangential_reading

Array = NDArray[np.float64]
BASE = {"m": 0.5, "k1": 0.0, "k2": 500.0, "b1": 20.0, "b2": 25.0, "Fc": 0.0, "normal_k": 400.0, "normal_b": 8.0}
DEPTH = 0.01


def along_y(
    y: Callable[[Array], Array], v: Callable[[Array], Array], seconds: float, rate: float = 1000.0
) -> ProbeMotion:
    """A probe pressed in by DEPTH throughout, moving along y as a function of time."""
    time = np.arange(round(seconds * rate) + 1) / rate
    still = np.zeros_like(time)
    position = np.column_stack([still, y(time), still - DEPTH])
    return ProbeMotion(time, position, np.column_stack([still, v(time), still]), moves_x=False)


def sine(amplitude: float, hertz: float, seconds: float) -> ProbeMotion:
    w = 2.0 * math.pi * hertz
    return along_y(lambda t: amplitude * np.sin(w * t), lambda t: amplitude * w * np.cos(w * t), seconds)


def ramp(speed: float, seconds: float) -> ProbeMotion:
    return along_y(lambda t: speed * t, lambda t: np.full_like(t, speed), seconds)


def run(motion: ProbeMotion, *effects: Concealed, **base: float) -> tuple[Array, Array]:
    """Reading along y (n,) and the body's motion (n, 2)."""
    physics, sensor = with_effects(linear_object({**BASE, **base}), Sensor(), effects)
    return tangential_reading(physics, sensor, motion, 1, QUICK_STEP_S)  # a quarter of the time, and enough here
