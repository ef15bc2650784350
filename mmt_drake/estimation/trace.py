"""The trace of an estimator: what it knows after each sample of a recording."""

from dataclasses import dataclass

from mmt_drake.numeric.arrays import Array


@dataclass(frozen=True, kw_only=True)
class EstimatorTrace:
    """The output of every estimator.

    Attributes:
        theta: (n, 10) in the order of `mmt_drake.model.parameters.THETA`; NaN until known.
        stable: 0.0 or 1.0 (n).
        estimated_force, filtered_force: (n, 3) what it holds against each other [N].
        held_body: (n, 6) where friction holds the body (`mmt_drake.model.held_body`), by the clock of the samples; None
            of an estimator that does not know.
    """

    theta: Array
    stable: Array
    estimated_force: Array
    filtered_force: Array
    held_body: Array | None = None
