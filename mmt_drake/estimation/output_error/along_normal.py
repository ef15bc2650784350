"""What samples say of the axis along the surface normal, whose force is linear in its numbers.

On a surface that is higher by h than it is seen the force is k (h - z) - b v_z: k h is one number more for each
contact, and tells where the surface is.
"""

from dataclasses import dataclass, replace

import numpy as np

from mmt_drake.estimation.output_error.fit import comparable
from mmt_drake.estimation.output_error.knowledge import Knowledge
from mmt_drake.estimation.output_error.lateness import late_means
from mmt_drake.estimation.output_error.options import Prior
from mmt_drake.estimation.output_error.unknowns import LATENESS, NORMAL_DEVIATION, Information
from mmt_drake.estimation.output_error.unsure_touches import begins_and_ends
from mmt_drake.estimation.output_error.window import FORCE
from mmt_drake.numeric.arrays import Array
from mmt_drake.told_laws import ALONG_NORMAL, along_normal, told_by_bytes

_TIMES, _SETTLED = 3, 2e-5  # that the height is found anew, as long as it changes by more than that [m]


@dataclass(frozen=True)
class SaidAlongNormal:
    """What samples say of k and b, and of the force k h of each contact.

    Attributes:
        numbers: of k and b, whatever the heights are.
        certain: (c,) information of each force k h for given k and b, with what is believed of h [1/N^2].
        vector: (c,) and its product with that force, at k = b = 0 [1/N].
        slope: (c, 2) what k and b take off that.
    """

    numbers: Information
    certain: Array
    vector: Array
    slope: Array

    def heights(self, normal: Array, covariance: Array) -> tuple[Array, Array]:
        """Heights of the surface (c,), and their standard deviations [m], for k and b with their covariance (2, 2)."""
        k = normal[0]
        force = (self.vector - self.slope @ normal) / self.certain
        derivative = -self.slope / (k * self.certain[:, np.newaxis])
        derivative[:, 0] -= force / k**2
        variance = 1.0 / (k**2 * self.certain) + np.sum(derivative @ covariance * derivative, axis=1)
        return force / k, np.sqrt(variance)


def said_along_normal(known: Knowledge, h: float, part: slice, surface: float) -> SaidAlongNormal:
    """What a part of the window of samples says of the normal axis, beside the laws that are told of it.

    Args:
        known: with the samples; the force along the normal is as late as the fit along x and y has it.
        h: time between samples [s].
        part: which of them.
        surface: standard deviation of the height at which contact is said to begin [m]; with 0, and beside a law along
            the normal, no height is sought.
    """
    window, laws = known.window, told_by_bytes(known.model.tobytes())
    weight = comparable(window, h)[part, 2] / known.noise
    turns = np.flatnonzero(np.diff(window.contact)) + 1
    changes = h * (turns - 1.0 + window.switch[turns])
    motion = np.ascontiguousarray(window.motion[:, [2, 5]].T)
    push = np.vstack([along_normal(laws, h, motion[0], motion[1], window.contact, changes), window.contact])
    late = np.empty_like(push)
    late_means(push, h, 1, known.x[LATENESS], late)
    psi, held = late[:2].T[part] * weight[:, np.newaxis], late[3, part] * weight
    measured = (window.samples[part, FORCE][:, 2] - late[2, part]) * weight
    numbers = Information(psi.T @ psi, psi.T @ measured)
    begins, _ = begins_and_ends(window.contact[part])
    if surface == 0.0 or laws[ALONG_NORMAL] != 0.0 or len(begins) == 0:
        return SaidAlongNormal(numbers, np.zeros(0), np.zeros(0), np.zeros((0, 2)))
    told = np.add.reduceat(held[:, np.newaxis] * np.column_stack([held, measured, psi]), begins)
    certain, vector, slope = told[:, 0] + (known.normal[0] * surface) ** -2.0, told[:, 1], told[:, 2:]
    share = slope / certain[:, np.newaxis]
    shared = Information(slope.T @ share, vector @ share)
    return SaidAlongNormal(numbers.plus(shared.faded(-1.0)), certain, vector, slope)


def with_normal_axis(known: Knowledge, prior: Prior, h: float, surface: float) -> Knowledge:
    """Knowledge with normal k, b and the heights of the surface by linear least squares, less the laws that are told.

    Where the surface is found elsewhere, the touch was at another time, and what is compared changes: it is found anew.

    Args:
        known: what there is, with the samples.
        prior: what is believed beforehand.
        h: time between samples [s].
        surface: as of `said_along_normal`.
    """
    believed = Information.about(np.array([prior.normal_k, prior.normal_b]), NORMAL_DEVIATION)
    for _ in range(_TIMES):
        said = said_along_normal(known, h, slice(None), surface)
        found = believed.plus(known.normal_memory).plus(said.numbers)
        covariance = found.covariance()
        # A surface pushes back and does not pump energy.
        normal = np.maximum(covariance @ found.vector, [1.0, 0.0])
        before = known.window
        if contacts := len(begins_and_ends(before.contact)[0]):
            height, unsure = np.zeros(contacts), np.full(contacts, surface)
            if len(said.certain):
                height, unsure = said.heights(normal, covariance)
            known = replace(known, window=before.at_heights(height, unsure, h))
        known = replace(known, normal=normal, normal_covariance=covariance)
        if np.abs(known.window.height - before.height).max(initial=0.0) < _SETTLED:
            break
    return known
