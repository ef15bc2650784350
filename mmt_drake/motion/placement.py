"""Puts a recorded motion onto the table.

A hand or a probe was recorded somewhere: in the frame of a robot, on a phantom that bulges, over a
drawing. To drive the telerobot it has to slide over the top of the object (z = 0), press into it by
some millimetres, and break contact now and then.

Tangential axes: scaled, and the middle of the area they cover moved to a given place.
Normal axis: one signal of the recording says how hard the hand pressed. Its least value becomes the
shallowest press, its greatest the deepest, with a straight line between. That signal is either how
far down the tip was (a flat support, where the height of the tip is what the hand did), or the normal
force (a curved or tilted support, where the height is the support's shape and force alone tells the
press).
Lifts: the tip starts above the object, comes down, leaves it `lifts` times at even intervals while it
travels on, and ends above it; each rise and descent is a minimum-jerk step.
"""

import math
from dataclasses import dataclass, replace
from typing import Annotated, ClassVar, Literal

import numpy as np
from scipy.signal import butter, sosfiltfilt

from mmt_drake.errors import BadInput
from mmt_drake.motion.analytic import AnalyticMotion, Row, step
from mmt_drake.motion.sampled import SampledMotion
from mmt_drake.numeric.arrays import Array
from mmt_drake.quantities import Checked, Length, Quantity, Time
from mmt_drake.recording.recording import Recording

_TABLE_REACH = 0.05  # [m] from the surface that a motion recorded on the table comes to
_STILL = 1e-6  # [m] or [N] of variation below which there is nothing but noise to stretch
_SLOWEST, _FASTEST = 0.01, 1e4  # [Hz] of smoothing and of resampling
_WORKSPACE = 0.2  # [m] side of the square that an automatic placement fits a motion into


@dataclass(frozen=True)
class Placement(Checked):
    """How a recorded motion is put onto the table; the default leaves it as it is.

    Args:
        scale: factor on x and y, > 0.
        centre: where the middle of the covered area goes, x and y [m]; None leaves it in place.
        press: least and greatest depth [m], 0 <= least < greatest; None leaves z as recorded.
        press_from: what says how deep: "position" (lower is deeper) or "force" (force_z).
        lifts: how often the tip leaves the object on the way; None adds no lift at all, not even at
            the ends.
        lift_time: from leaving the object to being back on it [s].
        clearance: height of a lift [m].
        bandwidth: the recording is resampled at `rate` and smoothed, without phase, by a 4th-order
            Butterworth filter of this cut-off [Hz], 0.01 or more; None keeps its samples.
        rate: [Hz], more than twice the bandwidth, 10 000 at most.

    Raises:
        BadInput: a value out of its range.
    """

    scale: Annotated[float, Quantity("", positive=True)] = 1.0
    centre: tuple[float, float] | None = None
    press: tuple[float, float] | None = None
    press_from: Literal["position", "force"] = "position"
    lifts: Annotated[int | None, Quantity("", whole=True)] = None
    lift_time: Time = 1.2
    clearance: Length = 0.01
    bandwidth: float | None = None
    rate: Annotated[float, Quantity("Hz", 0.0, _FASTEST, positive=True)] = 250.0

    CALLED: ClassVar = "placement"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.centre is not None and not np.isfinite(self.centre).all():
            raise BadInput("placement", at="centre", found=self.centre, expected="two numbers [m]")
        if self.press is not None and not 0.0 <= self.press[0] < self.press[1] < math.inf:
            raise BadInput("placement", at="press", found=self.press, expected="0 <= least < greatest [m]")
        if self.bandwidth is not None and not _SLOWEST <= self.bandwidth < 0.5 * self.rate:
            expected = f"between {_SLOWEST} Hz and half the rate of {self.rate} Hz"
            raise BadInput("placement", at="bandwidth", found=self.bandwidth, expected=expected)


#: For a motion that was recorded on the table: nothing is changed.
AS_RECORDED = Placement()
#: For a hand led over a flat support, whose height says what the hand did.
HAND = Placement(centre=(0.0, 0.0), press=(0.001, 0.010), lifts=1, bandwidth=10.0)
#: For a probe that pressed all along on a support of unknown shape.
PALPATION = Placement(centre=(0.0, 0.0), press=(0.001, 0.010), press_from="force", lifts=1, bandwidth=5.0)


def automatic_placement(recording: Recording) -> Placement:
    """The placement that suits a recording, by its numbers.

    - Lowest point of the tip within 50 mm of z = 0: recorded on the table, `AS_RECORDED`. Not so if it is in
      contact all along and yet z reaches 0: then z does not count from the surface.
    - Else, force_z above zero in 95 of 100 samples: a probe that pressed all along, `PALPATION`.
    - Else a guided hand, `HAND`.

    The latter two are shrunk if they would not fit into 0.2 x 0.2 m, and lifted once every 12 s, once at
    least.

    Raises:
        BadInput: the recording has no position.
    """
    position = recording.vector("position")
    if _is_on_table(recording, position[:, 2]):
        return AS_RECORDED
    pressed = "force_z" in recording and np.quantile(recording["force_z"], 0.05) > 0.0
    extent = float(np.ptp(position[:, :2], axis=0).max())
    duration = recording.time[-1] - recording.time[0]
    kind = PALPATION if pressed else HAND
    scale = min(1.0, _WORKSPACE / extent) if extent > 0.0 else 1.0
    return replace(kind, scale=scale, lifts=max(1, int(duration / 12.0)))


def _is_on_table(recording: Recording, z: Array) -> bool:
    near = abs(float(z.min())) <= _TABLE_REACH
    always_touching = "in_contact" in recording and recording["in_contact"].min() > 0.0
    return near and not (always_touching and float(z.max()) >= 0.0)


def place(recording: Recording, placement: Placement | None = None) -> SampledMotion:
    """The motion of a recording's `position`, put onto the table, with time from 0.

    A placement that changes nothing keeps the recorded velocities, where there are any. Everything
    else takes velocities from the spline through the placed positions, so that the motion is twice
    continuously differentiable whatever the velocity channel is worth.

    Args:
        recording: with `position_*`, and `force_z` where force says how deep.
        placement: `automatic_placement(recording)` if None.

    Raises:
        BadInput: a column is missing, a signal that does not vary cannot be stretched, or the
            recording is too short for the lifts.
    """
    if len(recording) < 2:
        raise BadInput(recording.source, found=f"{len(recording)} samples", expected="two or more for a motion")
    if placement is None:
        placement = automatic_placement(recording)
    time = recording.time - recording.time[0]
    position = recording.vector("position")
    if placement == AS_RECORDED:
        if recording.has_vector("velocity"):
            return SampledMotion(time, position, recording.vector("velocity"), recording.source)
        return SampledMotion.from_positions(time, position, source=recording.source)

    signals = position
    if placement.press_from == "force" and placement.press is not None:
        signals = np.column_stack([position, recording["force_z"]])
    if placement.bandwidth is not None:
        time, signals = _smooth(time, signals, placement, recording.source)
    placed = placement.scale * signals[:, :2]
    if placement.centre is not None:
        placed += np.asarray(placement.centre) - 0.5 * (placed.min(axis=0) + placed.max(axis=0))
    z = signals[:, 2]
    if placement.press is not None:
        pressing = signals[:, 3] if placement.press_from == "force" else -z
        z = -_stretch(pressing, placement.press, recording.source)
    if placement.lifts is not None:
        lifted = _lifted(time, placement, recording.source)
        z = (1.0 - lifted) * z + lifted * placement.clearance
    return SampledMotion.from_positions(
        time, np.column_stack([placed, z]), source=recording.source, notes=(f"placed on the table by {placement}",)
    )


def _smooth(time: Array, signals: Array, placement: Placement, source: str) -> tuple[Array, Array]:
    """Resampled evenly and low-passed forwards and backwards."""
    rate, bandwidth = placement.rate, placement.bandwidth
    even = np.arange(math.floor(time[-1] * rate) + 1) / rate
    if len(even) < 16:  # the filter's own start and end take as much
        raise BadInput(source, found=f"{time[-1]:.3g} s", expected=f"{16.0 / rate:.3g} s or more to smooth")
    resampled = np.column_stack([np.interp(even, time, column) for column in signals.T])
    return even, sosfiltfilt(butter(4, bandwidth, fs=rate, output="sos"), resampled, axis=0)


def _stretch(pressing: Array, press: tuple[float, float], source: str) -> Array:
    """Depth [m], linear in the pressing signal, from its least to its greatest value."""
    low, high = pressing.min(), pressing.max()
    if high - low < _STILL:
        raise BadInput(source, found="a normal axis that does not vary", expected="a press to stretch, or press=None")
    return press[0] + (press[1] - press[0]) * (pressing - low) / (high - low)


def _lifted(time: Array, placement: Placement, source: str) -> Array:
    """1 where lifted, 0 where on the object, a minimum-jerk step between."""
    lifts, pause, end = placement.lifts or 0, placement.lift_time, float(time[-1])
    if end < 2.0 * pause * (lifts + 1):
        raise BadInput(
            source, found=f"{end:.3g} s", expected=f"{2.0 * pause * (lifts + 1):.3g} s or more for {lifts} lifts"
        )
    ramp = 0.4 * pause
    steps: list[Row] = [step(2, 0.1 * pause, 0.1 * pause + ramp, -1.0), step(2, end - ramp, end, 1.0)]
    for i in range(1, lifts + 1):
        start = end * i / (lifts + 1) - 0.5 * pause
        steps += [step(2, start, start + ramp, 1.0), step(2, start + pause - ramp, start + pause, -1.0)]
    lifted, _ = AnalyticMotion((0.0, 0.0, 1.0), steps=steps, cycle=2.0 * end).sample(time)
    return lifted[:, 2]
