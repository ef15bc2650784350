"""The thesis's estimator over a whole recording at once."""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from mmt_drake.errors import BadInput
from mmt_drake.estimation import thesis
from mmt_drake.estimation.options import RlsOptions
from mmt_drake.estimation.trace import EstimatorTrace, samples_of
from mmt_drake.numeric.arrays import Array, assign


@njit(cache=True, error_model="numpy")
def _run(measurement: Array, in_contact: Array, out: Array, readout: Array, fixed: Array) -> int:
    for k in range(in_contact.size):
        if not thesis.readout_step(measurement[k], in_contact[k], readout, fixed):
            return k
        assign(out[k], readout[: thesis.READOUT_SIZE])
    return -1


@dataclass(frozen=True, kw_only=True)
class RlsTrace(EstimatorTrace):
    """The knowledge of the estimator after each sample of a recording; of theta, Fs = Fc and v_d = 0.

    Attributes:
        regrouped: a ... g (n, 7).
        covariance: P of a ... g after the last sample (7, 7), in units of the equation error's variance.
    """

    regrouped: Array
    covariance: Array


def estimate(measurement: ArrayLike, in_contact: ArrayLike, options: RlsOptions | None = None) -> RlsTrace:
    """Run the estimator over evenly sampled data, as `RlsEstimator` would sample by sample.

    Args:
        measurement: position, velocity, force (n, 9) in the table frame [m, m/s, N], every `options.step`.
        in_contact: 0 or 1 (n).
        options: `RlsOptions()` where None.

    Raises:
        BadInput: other shapes, or a value that is not finite.
    """
    options = RlsOptions() if options is None else options
    data, contact = samples_of(measurement, in_contact)
    out = np.empty((len(data), thesis.READOUT_SIZE))
    readout = thesis.initial_readout(options)
    bad = _run(data, contact, out, readout, thesis.settings(options))
    if bad >= 0:
        raise BadInput("measurement, in_contact", at=f"row {bad}", found="NaN or infinity", expected="finite numbers")
    return RlsTrace(
        theta=out[:, thesis.THETA],
        regrouped=out[:, thesis.REGROUPED],
        stable=out[:, thesis.STABLE.start],
        estimated_force=out[:, thesis.ESTIMATED],
        filtered_force=out[:, thesis.FILTERED],
        covariance=thesis.covariance(readout),
    )
