"""Samples as the compiled recursions take them, and the plant's step from one to the next."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mmt_drake.estimation.output_error.fit import COARSE
from mmt_drake.estimation.output_error.replay import replay_window
from mmt_drake.estimation.output_error.unknowns import write_unknowns
from mmt_drake.estimation.output_error.window import FORCE, MOTION_GOOD, Window
from mmt_drake.model.parameters import MAX_STEP, write_theta

Array = NDArray[np.float64]


class Samples(NamedTuple):
    """A window, one row per tangential axis.

    Attributes:
        h: time between samples [s].
        probe, rate: (2, n) of the probe [m], [m/s].
        contact, switch: (n,) as in `mmt_drake.estimation.output_error.window.Window`.
        good: (n,) 1 where the motion is known.
        force: (2, n) measured [N].
        weight: (2, n) 1 where the force counts.
    """

    h: float
    probe: Array
    rate: Array
    contact: Array
    switch: Array
    good: Array
    force: Array
    weight: Array


def samples_of(window: Window, h: float) -> Samples:
    """A window whose samples are h [s] apart."""
    rows = np.ascontiguousarray
    return Samples(
        h,
        rows(window.motion[:, :2].T),
        rows(window.motion[:, 3:5].T),
        window.contact,
        window.switch,
        rows(window.samples[:, MOTION_GOOD]),
        rows(window.samples[:, FORCE][:, :2].T),
        rows(window.weight[:, :2].T),
    )


@njit(cache=True, error_model="numpy")
def write_parameters(x: Array, stick: tuple[float, float], theta: Array, p: Array) -> None:
    """The kernel vector of unknowns and static friction (Fs - Fc, v_d), by way of theta (10,) with its normal axis."""
    write_unknowns(x, stick[0], stick[1], theta)
    write_theta(theta, math.inf, p)
    p[MAX_STEP] *= COARSE


@njit(cache=True, error_model="numpy")
def advance(samples: Samples, i: int, k: int, p: Array, axis: Array, force: Array) -> None:
    """Axis i from sample k - 1 to k with the plant's own kernel; the force at both into `force` (2,) [N].

    Raises:
        RuntimeError: see `mmt_drake.model.body.advance_axis`.
    """
    a, b = k - 1, k + 1
    probe, rate = samples.probe[i, a:b], samples.rate[i, a:b]
    replay_window(samples.h, 1, probe, rate, samples.contact[a:b], samples.switch[a:b], p, axis, force)
