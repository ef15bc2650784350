"""What a message tells of the force sensor, taken off what it reads."""

from numba import njit

from mmt_drake.estimation.output_error.window import FORCE, TAKEN
from mmt_drake.model.message_layout import OF_SENSOR
from mmt_drake.numeric.arrays import Array


@njit(error_model="numpy")
def read_too_much(sensor: Array, t: float, normal: float) -> float:
    """By how much the sensor reads too much along x and along y [N]; a lag is not in it.

    Args:
        sensor: (4,) of a message, as `mmt_drake.model_message.SensorError`.
        t: [s].
        normal: force along z [N].
    """
    return sensor[0] + sensor[1] * t + sensor[2] * normal


def corrected(samples: Array, now: Array, before: Array | None = None) -> Array:
    """Samples (k, SAMPLE_SIZE) less what the sensor reads too much by a message (MESSAGE_SIZE,).

    Args:
        samples: of the fit.
        now: the message.
        before: that they have been corrected by; None: they are as measured.
    """
    change = now[OF_SENSOR] if before is None else now[OF_SENSOR] - before[OF_SENSOR]
    if not change.any():
        return samples
    found = samples.copy()
    for row in found:
        row[FORCE][:2] -= read_too_much(change, row[TAKEN], row[FORCE.stop - 1])
    return found
