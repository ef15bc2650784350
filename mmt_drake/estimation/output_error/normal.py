"""The normal axis, F_z = -k z - b v_z, by linear least squares."""

import numpy as np
from numpy.typing import NDArray

from mmt_drake.estimation.output_error.options import Prior
from mmt_drake.estimation.output_error.unknowns import NORMAL_DEVIATION, Information
from mmt_drake.estimation.output_error.window import FORCE, Window

Array = NDArray[np.float64]


def said_along_normal(window: Window, part: slice, noise: float) -> Information:
    """What a part of a window says of k and b; `noise` is the deviation of the force of each sample [N]."""
    weight = window.weight[part, 2] / noise
    psi = -window.motion[part][:, [2, 5]] * weight[:, np.newaxis]
    return Information(psi.T @ psi, psi.T @ (window.samples[part, FORCE][:, 2] * weight))


def pushing_back(k: float, b: float) -> Array:
    """k and b [N/m], [N s/m] of a surface that pushes back and does not pump energy."""
    return np.array([max(k, 1.0), max(b, 0.0)])


def believed_along_normal(prior: Prior) -> Information:
    """What is believed of k and b beforehand."""
    return Information.about(np.array([prior.normal_k, prior.normal_b]), NORMAL_DEVIATION)
