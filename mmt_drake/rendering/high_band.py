"""A second model for high frequencies, fused with the first (thesis, appendix H.2.2).

The thesis proposes to model the environment as a variable spring above the band in which the first model is reliable.
At the telerobot, k (and on demand a damper b, since above its mode the thesis's object is one) is fitted to the
high-passed force and motion of a short time past,

    F_h = -(k x_h + b v_h),

by least squares with a forgetting memory. There the two models can also be held against the truth: both predict the
measured force from the measured motion, and the mean squares e1, e2 of what they miss in the high band give the second
the weight w = e1 / (e1 + e2), which is best where the errors are independent. At the operator

    F = F1 + w (-(k x_h + b v_h) - (F1)_h),

the high-pass of the first model's force being replaced, in part, by the second's. Where the first is right w is small
and nothing is lost.
"""

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar, NamedTuple

import numpy as np
import scipy.signal
from numba import njit

from mmt_drake.errors import BadInput
from mmt_drake.model.held_body import HELD_SIZE
from mmt_drake.numeric.arrays import Array, assign
from mmt_drake.numeric.butterworth import lowpass as filter_bank
from mmt_drake.numeric.layout import Layout
from mmt_drake.quantities import Checked, Quantity, Time
from mmt_drake.rendering import impedance
from mmt_drake.rendering.finite import all_finite
from mmt_drake.rendering.impedance import render
from mmt_drake.rendering.updates import AtOnce, rule

# Motions that count as none, so that k and b go to 0 without excitation [m], [m/s].
_LEAST_X, _LEAST_V = 1e-4, 1e-3


@dataclass(frozen=True)
class HighBand(Checked):
    """The second model.

    Attributes:
        crossover: above it the second model may take over [Hz], > 0.
        memory: time constant of the fit and of the mean squares [s], > 0.
        damper: fit a damper beside the spring; the thesis has the spring alone (false).

    Raises:
        BadInput: a number outside these ranges.
    """

    crossover: Annotated[float, Quantity("Hz", positive=True)] = 3.0
    memory: Time = 0.1
    damper: bool = True

    CALLED: ClassVar = "high band"


class HighBandSettings(NamedTuple):
    """`HighBand` in the form the compiled steps take."""

    sos: Array
    forgetting: float
    damper: bool
    rule: Array


def settings(options: HighBand, period: float) -> HighBandSettings:
    """Design the filter for ticks of a period [s].

    Raises:
        BadInput: a crossover that is not below half the rate of the ticks.
    """
    most = 0.5 / period
    if options.crossover >= most:
        expected = f"less than half the clock's rate, {most:g} Hz"
        raise BadInput("renderer", at="high_band.crossover", found=options.crossover, expected=expected)
    sos = scipy.signal.butter(2, options.crossover, "highpass", fs=1.0 / period, output="sos")
    forgetting = float(np.exp(-period / options.memory))
    return HighBandSettings(np.ascontiguousarray(sos), forgetting, options.damper, rule(AtOnce(), period, period))


# High-passed: x, y, their rates, the force that was measured along both, and what the first model says.
_SIGNALS = 8

# The telerobot's memory: first what it puts out (k, b, w), then these.
_next = Layout()
_next(3)
_SUMS = _next(7)  # forgetting ones: xx, xv, vv, xF, vF, and the squares of what the first and the second model miss
_VALUES = _next(_SIGNALS)
_BANK = _next(2 * _SIGNALS)
_MODEL = _next(impedance.MEMORY_SIZE)
_PUT_OUT = _next(sum(impedance.READOUT_SIZES))
# Zeros: the force that a body held elsewhere makes is constant, and nothing of it is left in the band.
_NO_REPORT = _next(HELD_SIZE)
ESTIMATE_SIZE = _next.size
_MODEL_MEMORY = sum(impedance.READOUT_SIZES) - impedance.MEMORY_SIZE


@njit(cache=True)
def estimate(
    memory: Array, t: float, measurement: Array, in_contact: float, theta: Array, stable: float, fixed: HighBandSettings
) -> None:
    """One tick of the second model's estimator at the telerobot, in place; a sample that is not finite is skipped.

    Args:
        memory: (ESTIMATE_SIZE,): k [N/m], b [N s/m], w, and what is remembered; zeros before the first tick.
        t: [s].
        measurement: (9,) position [m], velocity [m/s], force [N].
        in_contact: 0 or 1.
        theta, stable: the first model's latest set, and whether it may be rendered.
        fixed: `settings`.
    """
    if not (all_finite(measurement) and math.isfinite(in_contact)):
        return
    out, held, motion = memory[_PUT_OUT:_NO_REPORT], memory[_NO_REPORT:], measurement[:6]
    render(memory[_MODEL:_PUT_OUT], t, motion, motion, theta, stable, in_contact, fixed.rule, False, held, out)
    assign(memory[_MODEL:_PUT_OUT], out[_MODEL_MEMORY:])
    values = memory[_VALUES:_BANK]
    for i in range(2):
        values[i], values[2 + i] = measurement[i], measurement[3 + i]
        values[4 + i], values[6 + i] = measurement[6 + i], out[i]
    filter_bank(fixed.sos, values, memory[_BANK:_MODEL].reshape((1, 2, _SIGNALS)))
    if in_contact == 0.0:
        return
    sums = memory[_SUMS:_VALUES]
    for n in range(sums.size):
        sums[n] *= fixed.forgetting
    for i in range(2):
        x, v, F, first = values[i], values[2 + i], values[4 + i], values[6 + i]
        sums[5] += (F - first) ** 2
        sums[6] += (F + memory[0] * x + memory[1] * v) ** 2
        sums[0] += x * x
        sums[1] += x * v
        sums[2] += v * v
        sums[3] -= x * F
        sums[4] -= v * F
    count = 2.0 / (1.0 - fixed.forgetting)
    xx, xv, vv = sums[0] + count * _LEAST_X**2, sums[1], sums[2] + count * _LEAST_V**2
    if fixed.damper:
        determinant = xx * vv - xv * xv
        memory[0] = (vv * sums[3] - xv * sums[4]) / determinant
        memory[1] = (xx * sums[4] - xv * sums[3]) / determinant
    else:
        memory[0] = sums[3] / xx
    total = sums[5] + sums[6]
    memory[2] = sums[5] / total if total > 0.0 else 0.0


# The renderer's memory beside that of the first model: state of the filters of x, y, their rates and the first model's
# force, then what they put out, then by how much the force was changed last along x and y [N].
_FUSED = 6
_CHANGED = 3 * _FUSED
FUSE_SIZE = _CHANGED + 2


@njit(cache=True)
def fuse(
    bank: Array,
    motion: Array,
    high_band: Array,
    in_contact: float,
    fixed: HighBandSettings,
    force: Array,
    left: float = 1.0,
) -> None:
    """Let the second model have its share of the first one's force.

    None of it where its numbers are not finite; what is `left` of the last one where motion or contact are not.

    Args:
        bank: (FUSE_SIZE,) changed; zeros before the first tick.
        motion: (6,) of the hand [m], [m/s].
        high_band: (3,) k, b, w.
        in_contact: 0 or 1.
        fixed: `settings`.
        force: (3,) of the first model [N], changed.
        left: share of a force that is held (`finite.share_held`).
    """
    values, changed = bank[2 * _FUSED : _CHANGED], bank[_CHANGED:]
    if not (all_finite(motion) and math.isfinite(in_contact)):
        for i in range(2):
            force[i] += left * changed[i]
        return
    for i in range(2):
        changed[i] = 0.0
        values[i], values[2 + i], values[4 + i] = motion[i], motion[3 + i], force[i]
    filter_bank(fixed.sos, values, bank[: 2 * _FUSED].reshape((1, 2, _FUSED)))
    if in_contact > 0.0 and all_finite(high_band):
        for i in range(2):
            second = -(high_band[0] * values[i] + high_band[1] * values[2 + i])
            changed[i] = high_band[2] * (second - values[4 + i])
            force[i] += changed[i]
