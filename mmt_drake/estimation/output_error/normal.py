"""The normal axis, F_z = -k z - b v_z, by linear least squares."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

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


@dataclass(frozen=True)
class NormalAxis:
    """What is known of k and b.

    Attributes:
        information: prior and samples.
    """

    information: Information

    @classmethod
    def believed(cls, prior: Prior) -> Self:
        """Nothing but the prior."""
        return cls(Information.about(np.array([prior.normal_k, prior.normal_b]), NORMAL_DEVIATION))

    @property
    def values(self) -> Array:
        """k and b [N/m], [N s/m]."""
        return pushing_back(*self.information.mean())

    @property
    def deviation(self) -> Array:
        """Of both."""
        return np.sqrt(np.diag(self.information.covariance()))

    @property
    def known(self) -> bool:
        """Whether the samples have said more of k than the prior."""
        return bool(self.deviation[0] < 0.7 * NORMAL_DEVIATION[0])

    def learned(self, window: Window, rows: range, noise: float) -> Self:
        """With rows of a window, see `said_along_normal`."""
        said = said_along_normal(window, slice(rows.start, rows.stop), noise)
        return replace(self, information=self.information.plus(said))
