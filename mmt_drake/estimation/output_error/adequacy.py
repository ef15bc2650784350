"""Adequacy of the fitted model: does it explain the force at all? A person, and whoever renders it, has to know.

A fit always ends somewhere, and its deviations say how sure it is of its numbers *if the model is right*. Whether it is
shows in what the fit leaves of the latest contact, over the noise. Noise is what signals do from sample to sample that
no body can do; a small part of the force itself is allowed beside it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from mmt_drake.estimation.output_error.fit import HALF_KNOWN, LEAST_NOISE
from mmt_drake.estimation.output_error.unknowns import OBJECT, Information
from mmt_drake.estimation.output_error.window import FORCE, POSITION, VELOCITY, Window, white_noise
from mmt_drake.model.parameters import THETA
from mmt_drake.numeric.arrays import Array, Flags

LATEST_S = 0.5
"""Of contact, over which what is left is taken."""
TOO_MUCH = 3.0
"""Times the noise: more is no chance."""
PATIENCE_S = 0.4
"""Of contact, for which too much has to be left."""
_BEGINNING_S, _EARLY_S = 0.5, 2.0
"""Of contact, in which a fit may still be on its way; and in which it may leave twice as much."""
_SHOWN_S = 1.0
"""Of contact, for which a change is shown."""
_LOOKED_FOR_S = (0.8, 3.0)
"""Of contact after the first doubt, between which another object is looked for: of less any could be said."""
_KNOWN_S = 2.0
"""Of contact without doubt, after which an object that does not fit is another one."""
PART = 0.005
"""Of the force: no model of a real thing is better, and what is rendered need not be."""
_K2, _B2 = THETA.index("k2"), THETA.index("b2")


class ModelStatus(IntEnum):
    """What is to be thought of the model."""

    ADEQUATE = 0
    MISFIT = 1  # the object does what the model cannot do
    CHANGED = 2  # the object is another one than before: what was known is forgotten
    UNEXCITED = 3  # this motion does not tell every number: it keeps its prior, and its wide deviation


@dataclass(frozen=True)
class Adequacy:
    """How well the latest contact is explained.

    Attributes:
        status: what is to be thought of it.
        left: what the fit leaves of the latest contact, over the noise; 0 before the first contact.
        doubted: contact for which too much was left without a break [s].
        seen: contact so far with this object [s].
        known: of that the contact that was explained [s].
    """

    status: ModelStatus = ModelStatus.UNEXCITED
    left: float = 0.0
    doubted: float = 0.0
    seen: float = 0.0
    known: float = 0.0

    def after(self, left: float, contact: float, unexcited: bool) -> Adequacy:
        """The adequacy after a fit.

        Args:
            left: of the latest contact, over the noise.
            contact: since the fit before [s].
            unexcited: whether a number is no better known than beforehand.
        """
        seen = self.seen + contact
        if left <= TOO_MUCH:
            status = ModelStatus.UNEXCITED if unexcited else ModelStatus.ADEQUATE
            if self.status == ModelStatus.CHANGED and seen <= _SHOWN_S:
                status = self.status
            return Adequacy(status, left, 0.0, seen, self.known + contact)
        much = left > TOO_MUCH * (2.0 if seen <= _EARLY_S else 1.0)
        doubted = self.doubted + contact if much and seen > _BEGINNING_S else 0.0
        if doubted < PATIENCE_S:
            return Adequacy(self.status, left, doubted, seen, self.known)
        return Adequacy(ModelStatus.MISFIT, left, doubted, seen, self.known)

    @property
    def may_have_changed(self) -> bool:
        """Whether there was an object that fitted before this one did not, not long ago."""
        if self.status != ModelStatus.MISFIT or self.known < _KNOWN_S:
            return False
        return _LOOKED_FOR_S[0] <= self.doubted <= _LOOKED_FOR_S[1]


def left_of_latest(window: Window, difference: Array, theta: Array, h: float) -> float:
    """What is left of the latest contact along x and y, over the noise; 0 without any.

    The noise is that of the force, and that of the motion as the contact spring and damper pass it on.

    Args:
        window: what was fitted.
        difference: (2 n,) simulated less measured force, 0 where it is not compared [N].
        theta: of the fit.
        h: time between samples [s].
    """
    weight = window.weight[:, :2]
    latest = np.flatnonzero(weight.any(axis=1))[-round(LATEST_S / h) :]
    count = float(np.sum(weight[latest]))
    if count == 0.0:
        return 0.0
    left = difference.reshape(2, -1)[:, latest].T
    force = window.samples[latest][:, FORCE][:, :2] * weight[latest]
    size, of_force = (float(np.sqrt(np.sum(values**2) / count)) for values in (left, force))
    passed_on = ((1.0, FORCE), (theta[_K2], POSITION), (theta[_B2], VELOCITY))
    samples = window.samples[latest]
    noise = math.hypot(*(gain * white_noise(samples[:, part][:, :2]) for gain, part in passed_on))
    return size / max(noise, PART * of_force, LEAST_NOISE)


def is_unexcited(covariance: Array, prior: Information, idle: Flags) -> bool:
    """Whether the deviation of a number of the object is still nearly that of its prior.

    Args:
        covariance: of the unknowns (k, k).
        prior: of them.
        idle: (10,) of theta: numbers without effect, which do not count.
    """
    unknown = (np.diag(covariance) > HALF_KNOWN**2 / np.diag(prior.matrix))[OBJECT]
    return bool(np.any(unknown & ~idle[OBJECT]))
