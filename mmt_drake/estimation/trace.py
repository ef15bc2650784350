"""The trace of an estimator: what it knows after each sample of a recording."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mmt_drake.errors import BadInput
from mmt_drake.numeric.arrays import Array


@dataclass(frozen=True, kw_only=True)
class EstimatorTrace:
    """The output of every estimator.

    Attributes:
        theta: (n, 10) in the order of `mmt_drake.model.parameters.THETA`; NaN until known.
        stable: 0.0 or 1.0 (n).
        estimated_force, filtered_force: (n, 3) what it holds against each other [N].
        held_body: (n, 7) where friction holds the body (`mmt_drake.model.held_body`), by the clock of the samples; None
            of an estimator that does not know.
    """

    theta: Array
    stable: Array
    estimated_force: Array
    filtered_force: Array
    held_body: Array | None = None


def samples_of(measurement: ArrayLike, in_contact: ArrayLike) -> tuple[Array, Array]:
    """What every estimator reads: measurements (n, 9) and contact (n,).

    Raises:
        BadInput: other shapes.
    """
    data = np.ascontiguousarray(measurement, dtype=float)
    contact = np.ascontiguousarray(in_contact, dtype=float)
    if data.ndim != 2 or data.shape[1] != 9 or contact.shape != data.shape[:1]:
        found = f"shapes {data.shape} and {contact.shape}"
        raise BadInput("measurement, in_contact", found=found, expected="(n, 9) and (n,)")
    return data, contact
