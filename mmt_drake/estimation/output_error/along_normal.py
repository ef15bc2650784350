"""What samples say of the axis along the surface normal, whose force is linear in its numbers."""

from dataclasses import replace

import numpy as np

from mmt_drake.estimation.output_error.fit import comparable
from mmt_drake.estimation.output_error.knowledge import Knowledge
from mmt_drake.estimation.output_error.lateness import late_means
from mmt_drake.estimation.output_error.options import Prior
from mmt_drake.estimation.output_error.unknowns import LATENESS, NORMAL_DEVIATION, Information
from mmt_drake.estimation.output_error.window import FORCE, Window
from mmt_drake.numeric.arrays import Array


def said_along_normal(window: Window, h: float, part: slice, x: Array, noise: float) -> Information:
    """What a part of a window says of k and b of the normal axis.

    Args:
        window: the samples.
        h: time between them [s].
        part: which of them.
        x: unknowns of the fit along x and y: the force along the normal is as late.
        noise: deviation of the force of each sample [N].
    """
    weight = comparable(window, h)[part, 2] / noise
    push = -window.motion[:, [2, 5]].T * window.contact
    late = np.empty_like(push)
    late_means(push, h, 1, x[LATENESS], late)
    psi = late.T[part] * weight[:, np.newaxis]
    return Information(psi.T @ psi, psi.T @ (window.samples[part, FORCE][:, 2] * weight))


def with_normal_axis(known: Knowledge, prior: Prior, h: float) -> Knowledge:
    """Knowledge with normal k and b by linear least squares on F_z = -k z - b v_z.

    Args:
        known: what there is, with the samples.
        prior: what is believed beforehand.
        h: time between samples [s].
    """
    believed = Information.about(np.array([prior.normal_k, prior.normal_b]), NORMAL_DEVIATION)
    said = said_along_normal(known.window, h, slice(None), known.x, known.noise)
    found = believed.plus(known.normal_memory).plus(said)
    covariance = found.covariance()
    # A surface pushes back and does not pump energy.
    return replace(known, normal=np.maximum(covariance @ found.vector, [1.0, 0.0]), normal_covariance=covariance)
