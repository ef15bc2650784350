"""What samples say of the axis along the surface normal, whose force is linear in its numbers."""

from dataclasses import replace

import numpy as np

from mmt_drake.estimation.output_error.fit import comparable
from mmt_drake.estimation.output_error.knowledge import Knowledge
from mmt_drake.estimation.output_error.lateness import late_means
from mmt_drake.estimation.output_error.options import Prior
from mmt_drake.estimation.output_error.unknowns import LATENESS, NORMAL_DEVIATION, Information
from mmt_drake.estimation.output_error.window import FORCE
from mmt_drake.told_laws import along_normal, told_by_bytes


def said_along_normal(known: Knowledge, h: float, part: slice) -> Information:
    """What a part of the window of samples says of k and b of the normal axis, beside the laws that are told of it.

    Args:
        known: with the samples; the force along the normal is as late as the fit along x and y has it.
        h: time between samples [s].
        part: which of them.
    """
    window, laws = known.window, told_by_bytes(known.model.tobytes())
    weight = comparable(window, h)[part, 2] / known.noise
    turns = np.flatnonzero(np.diff(window.contact)) + 1
    changes = h * (turns - 1.0 + window.switch[turns])
    motion = np.ascontiguousarray(window.motion[:, [2, 5]].T)
    push = along_normal(laws, h, motion[0], motion[1], window.contact, changes)
    late = np.empty_like(push)
    late_means(push, h, 1, known.x[LATENESS], late)
    psi = late[:2].T[part] * weight[:, np.newaxis]
    return Information(psi.T @ psi, psi.T @ ((window.samples[part, FORCE][:, 2] - late[2, part]) * weight))


def with_normal_axis(known: Knowledge, prior: Prior, h: float) -> Knowledge:
    """Knowledge with normal k and b by linear least squares on F_z = -k z - b v_z, less the laws that are told.

    Args:
        known: what there is, with the samples.
        prior: what is believed beforehand.
        h: time between samples [s].
    """
    believed = Information.about(np.array([prior.normal_k, prior.normal_b]), NORMAL_DEVIATION)
    found = believed.plus(known.normal_memory).plus(said_along_normal(known, h, slice(None)))
    covariance = found.covariance()
    # A surface pushes back and does not pump energy.
    return replace(known, normal=np.maximum(covariance @ found.vector, [1.0, 0.0]), normal_covariance=covariance)
