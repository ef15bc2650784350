"""The output-error estimator over a whole recording at once."""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from mmt_drake.errors import BadInput
from mmt_drake.estimation.output_error import layout as at
from mmt_drake.estimation.output_error.gate import hand_over, initial_readout, settings, take_samples, tick
from mmt_drake.estimation.output_error.knowledge import Knowledge
from mmt_drake.estimation.output_error.layout import LearningSettings
from mmt_drake.estimation.output_error.learn import Learner
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.estimation.trace import EstimatorTrace, samples_of
from mmt_drake.numeric.arrays import Array, assign


@dataclass(frozen=True, kw_only=True)
class OutputErrorTrace(EstimatorTrace):
    """What the estimator puts out after each sample of a recording, and what it knows in the end.

    Attributes:
        deviation: of theta (n, 10).
        regrouped: a ... g (n, 7).
        status: (n) of `Status`.
        model_status: (n) of `ModelStatus`.
        residual_ratio: (n) what is left of the latest contact, over the noise of the force.
        force_lateness: (n, 6), in the order of `FORCE_LATENESS` [s].
        knowledge: after the last sample.
    """

    deviation: Array
    regrouped: Array
    status: Array
    model_status: Array
    residual_ratio: Array
    force_lateness: Array
    knowledge: Knowledge


@njit(cache=True, error_model="numpy")
def _ticks(
    data: Array,
    reading: Array,
    contact: Array,
    time: Array,
    span: tuple[int, int],
    readout: Array,
    fixed: LearningSettings,
    out: Array,
) -> None:
    for k in range(span[0], span[1]):
        tick(data[k], reading[k], contact[k], time[k], time[k], readout, fixed)
        assign(out[k], readout[: at.READOUT_SIZE])


def estimate_output_error(
    measurement: ArrayLike,
    in_contact: ArrayLike,
    options: OutputErrorOptions | None = None,
    *,
    time: ArrayLike | None = None,
    reading: ArrayLike | None = None,
) -> OutputErrorTrace:
    """Run the estimator over data as `OutputErrorEstimator` would, tick by tick.

    Args:
        measurement: position, velocity, force (n, 9) in the table frame [m, m/s, N], every `options.step`; may be bad.
        in_contact: 0 or 1 (n).
        options: `OutputErrorOptions()` by default.
        time: of the samples (n) [s], where it is not every `options.step` from 0.
        reading: what the force sensor itself says (n, 3) [N], where the force has been made of it and of other things.

    Raises:
        BadInput: other shapes.
    """
    options = OutputErrorOptions() if options is None else options
    learner = Learner(options)
    data, contact = samples_of(measurement, in_contact)
    times: Array = np.arange(len(data), dtype=np.float64) * options.step
    if time is not None:
        times = np.ascontiguousarray(time, dtype=np.float64)
    if times.shape != contact.shape:
        raise BadInput("time", found=f"shape {times.shape}", expected=f"{contact.shape}")
    raw = np.ascontiguousarray(data[:, 6:] if reading is None else reading, dtype=float)
    if raw.shape != (len(data), 3):
        raise BadInput("reading", found=f"shape {raw.shape}", expected=f"({len(data)}, 3)")
    fixed = settings(options)
    known = learner.beginning()
    readout = initial_readout(fixed, known)
    out = np.empty((len(data), at.READOUT_SIZE))
    every = options.samples_per_fit * options.ticks
    for first in range(0, len(data), every):
        hand_over(readout, known.told)
        known = learner.learned(known, *take_samples(readout, fixed))
        _ticks(data, raw, contact, times, (first, min(first + every, len(data))), readout, fixed, out)
    return OutputErrorTrace(
        theta=out[:, at.THETA_PART],
        deviation=out[:, at.DEVIATION],
        regrouped=out[:, at.REGROUPED],
        stable=out[:, at.STABLE.start],
        estimated_force=out[:, at.ESTIMATED],
        filtered_force=out[:, at.FILTERED],
        status=out[:, at.STATUS.start],
        model_status=out[:, at.MODEL_STATUS.start],
        residual_ratio=out[:, at.RESIDUAL.start],
        force_lateness=out[:, at.LATE],
        held_body=out[:, at.HELD],
        knowledge=known,
    )
