"""One smoother for what drives the model and for what it answers, so that both are compared in one band.

The noise of a recorded position, differentiated, is multiplied by b2 in the model's force and biases every fit. So the
probe's position and velocity are smoothed together and once; the measured force passes the same kind of
filter, and every simulated force passes it again through `Smoothed.filter`.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicHermiteSpline
from scipy.signal import savgol_filter

from mmt_drake.diagnosis.signals.clocks import Clock, clock_of, held_on_clock, near, on_clock
from mmt_drake.diagnosis.signals.columns import Bands, Columns
from mmt_drake.diagnosis.signals.fusion import smoothed_motion
from mmt_drake.diagnosis.signals.noise import Noise
from mmt_drake.diagnosis.signals.rest import Rest, at_rest
from mmt_drake.diagnosis.signals.stillness import stilled
from mmt_drake.diagnosis.signals.touches import ContactTimes, contact_of, raw_flags
from mmt_drake.errors import BadInput
from mmt_drake.motion.hand import HandOrientation, orientation_of
from mmt_drake.numeric.arrays import Array, Flags
from mmt_drake.numeric.zero_phase import LowPass, convolved, mirrored
from mmt_drake.recording import Recording
from mmt_drake.recording.signals import ORIENTATION

RATE_HZ = 250.0
"""Rate that the fit replays at, unless the band asks for more or the recording has less."""

OVERSAMPLING = 12.0
"""The least rate over the band."""

_SILENT = 1e-5  # of an input's spread: noise that rounding, or the leakage of its spectrum, makes
_TOUCH = 0.25  # of the filter's half length, about two of its lobes
_BEFORE_TOUCH_S = 0.05  # free space ends so long before a touch
_AFTER_RELEASE_S = 0.3  # and begins so long after a release: the force of a slow sensor still fades

_ONE_COUNT = 0.5  # of the samples in free space that read what the one before them did


@dataclass(frozen=True)
class Smoothed:
    """A recording on the clock that the fit replays on.

    Attributes:
        source: of the recording.
        kind: of the recording.
        time: (n,) even clock [s].
        input: (n, k) smoothed position [m], three axes or one; or the input of a driven body, averaged onto the clock.
        input_rate: (n, k) its rate [1/s]; the two belong to each other.
        output: (n, k) force [N], or the output of a driven body, filtered.
        nearby: (n, k) the output, each value from the samples right beside it: what happens later does not show in it.
        contact: when the probe touches.
        in_contact: (n,) contact at each sample.
        free: (n,) nothing touches the probe, and what a release left on the force has gone; of a driven body nowhere.
        weight: (n,) 1 where the filtered output can be compared, 0 at the ends, in gaps, and about a touch or a release
            as far as a jump is smeared.
        low_pass: the filter that the output passed.
        top_hz: (k,) [Hz] below which 99 % of the power of the rate of each position, or of a driven body's output,
            lies; 0 for one that does not move.
        noise: of every recorded column that was read, by name.
        input_noise, input_rate_noise, output_noise: (k,) deviations of what is left of it here.
        input_band_hz: (k,) that the smoothed motion of each axis has.
        input_crossover: (k,) [rad/s] below which a position was the better source of its motion, see `Fusion`.
        input_filter: that the input of a driven body went through.
        rest: the force sensor in free space, where there was any.
        hand: how the hand turns, where that was recorded.
        resampling_error: (k,) bound on what an uneven clock adds to the input [m].
        clock: of the recording.
        every: samples of the recording's even clock per sample here.
        uses_velocity: whether the velocity column was used; it is not where it contradicts the position.
    """

    source: str
    kind: str
    time: Array
    input: Array
    input_rate: Array
    output: Array
    nearby: Array
    contact: ContactTimes
    in_contact: Flags
    free: Flags
    weight: Array
    low_pass: LowPass
    top_hz: Array
    noise: Mapping[str, Noise]
    input_noise: Array
    input_rate_noise: Array
    output_noise: Array
    input_band_hz: Array
    input_crossover: Array
    input_filter: LowPass
    resampling_error: Array
    clock: Clock
    every: int
    rest: Rest | None = None
    hand: HandOrientation | None = None
    uses_velocity: bool = False

    @property
    def rate_hz(self) -> float:
        """Samples per second."""
        return self.clock.rate_hz / self.every

    @property
    def nearby_reach_s(self) -> float:
        """How far from its sample `nearby` looks [s]."""
        return self.clock.step * self.every if self.every > 1 else 0.0

    @property
    def raw_input_noise(self) -> float:
        """Deviation of the noise of a driven body's input, as sampled."""
        return float(self.input_noise[0]) / _input_gain(self.input_filter, self.clock.rate_hz, self.every)

    def motion_at(self, time: Array) -> tuple[Array, Array]:
        """(n, k) smoothed position and its rate at times (n,) [s]; at the ends where a time is beyond."""
        position = CubicHermiteSpline(self.time, self.input, self.input_rate)
        times = np.clip(time, self.time[0], self.time[-1])
        return position(times), position(times, 1)

    def filter(self, simulated: Array) -> Array:
        """A simulated output on this clock, (n,) or (n, k), through the filter that the measured one passed."""
        return self.low_pass.apply(simulated, self.rate_hz)


def on_even_clock(recording: Recording, *, encoded: bool = False) -> Columns:
    """The columns of a recording that a diagnosis reads, on an even clock.

    Args:
        recording: contact, single-axis or driven body.
        encoded: its input is a position (`Columns.with_encoded_input`).

    Raises:
        BadInput: a recording without forces, of fewer than 8 samples, or whose clock jumps (`clock_of`).
    """
    if len(recording) < 8:
        raise BadInput(recording.source, found=f"{len(recording)} samples", expected="at least 8")
    columns = Columns.of(recording, clock_of(recording.time, recording.source))
    return columns.with_encoded_input() if encoded else columns


def smooth(
    recording: Recording, *, band_hz: float | None = None, rate_hz: float = RATE_HZ, columns: Columns | None = None
) -> Smoothed:
    """Smooth a recording.

    Args:
        recording: contact, single-axis or driven body.
        band_hz: in which to compare; by default four times the top excitation or more (`comparison_band`).
            Infinity filters nothing, and so does a band beyond a quarter of the recording's rate or a recording too
            short for the filter.
        rate_hz: wanted rate of the clock; the recording's own over an integer, and 12 times the band at least.
        columns: the recording's `on_even_clock`, where they are known already.

    Raises:
        BadInput: as `on_even_clock`.
    """
    columns = columns or on_even_clock(recording)
    bands = columns.bands(band_hz)
    low_pass, band = LowPass(bands.comparison_hz), bands.comparison_hz
    every = 1 if low_pass.is_identity else max(1, int(columns.clock.rate_hz / max(rate_hz, OVERSAMPLING * band) + 1e-9))
    return _smoothed(recording, columns, low_pass, bands, every)


def noise_floor(recording: Recording) -> dict[str, Noise]:
    """The noise of every column that a diagnosis reads, by name.

    Force noise comes from free space where there is any, else, as that of position and velocity, from high frequencies.

    Raises:
        BadInput: as `smooth`.
    """
    return dict(smooth(recording).noise)


def _smoothed(recording: Recording, columns: Columns, low_pass: LowPass, bands: Bands, every: int) -> Smoothed:
    """Everything on the clock of every so manieth sample."""
    clock, outputs = columns.clock, columns.channels.outputs
    driven, three_axes = recording.kind == "driven_body", recording.kind == "contact"
    noise = {name: spectrum.above(low_pass.band_hz) for name, spectrum in columns.spectra.items()}
    rates = columns.moving_rates
    motion, uses_velocity = smoothed_motion(
        columns.table(columns.moving),
        columns.table(rates) if rates else None,
        clock.rate_hz,
        bands.moving_hz,
        *(np.array([noise[name].white_std(clock.rate_hz) for name in names]) for names in (columns.moving, rates)),
    )
    flags = held_on_clock(recording.time, raw_flags(recording, noise), clock)
    contact = contact_of(clock.times(), flags, motion[2].position if three_axes else None)
    quiet = [
        stilled(axis.position, axis.velocity, axis.position_noise, axis.velocity_noise, clock.rate_hz)
        for axis in motion
    ]
    velocity = np.column_stack([rate for _, rate in quiet])
    output = columns.table(outputs)
    rest, free = None, np.zeros(len(flags), dtype=bool)
    if not driven and not flags.all():
        settling = np.column_stack([contact.releases - _BEFORE_TOUCH_S, contact.releases + _AFTER_RELEASE_S])
        free = ~(near(clock.times(), contact.touches, _BEFORE_TOUCH_S) | near(clock.times(), settling, 0.0) | flags)
        rest = at_rest(output, np.gradient(velocity, clock.step, axis=0), clock.rate_hz, free, low_pass.band_hz)
    if rest is not None:  # a sensor that stands on one count there says nothing of its noise
        told = zip(outputs, rest.noise, output[free].T, strict=True)
        noise |= {name: own for name, own, still in told if np.mean(np.diff(still) == 0.0) < _ONE_COUNT}
    gain = low_pass.white_noise_gain(clock.rate_hz)
    known = columns.table(columns.channels.inputs)
    if not driven:
        known = np.column_stack([position for position, _ in quiet])
    known = _averaged(known, every) if driven and columns.input_filter.is_identity else known[::every]
    time = clock.times(every)
    return Smoothed(
        source=recording.source,
        kind=recording.kind,
        time=time,
        input=known,
        input_rate=np.gradient(known, clock.step * every, axis=0) if driven else velocity[::every],
        output=low_pass.apply(output, clock.rate_hz, every),
        nearby=_parabolic(output, every),
        contact=contact,
        in_contact=contact.at(time),
        free=free[::every],
        weight=_weight(time, clock, contact, low_pass),
        low_pass=low_pass,
        top_hz=bands.top_hz,
        noise=noise,
        input_noise=_left_of_input(columns, every) if driven else np.array([axis.position_noise for axis in motion]),
        input_rate_noise=np.zeros(1) if driven else np.array([axis.velocity_noise for axis in motion]),
        output_noise=np.array([gain * noise[name].white_std(clock.rate_hz) for name in outputs]),
        input_band_hz=np.array(bands.moving_hz),
        input_crossover=np.array([axis.crossover for axis in motion]),
        input_filter=columns.input_filter,
        resampling_error=bands.resampling_error,
        clock=clock,
        every=every,
        rest=rest,
        hand=_hand(recording, columns, bands, every),
        uses_velocity=uses_velocity,
    )


def _hand(recording: Recording, columns: Columns, bands: Bands, every: int) -> HandOrientation | None:
    """The hand at every so manieth sample of the even clock, its orientation filtered as positions are."""
    if ORIENTATION[0] not in recording:
        return None
    even = on_clock(recording.time, orientation_of(recording), columns.clock)
    even = LowPass(max(bands.moving_hz)).apply(even, columns.clock.rate_hz, every)
    return HandOrientation.of(columns.clock.times(every), even)


def _left_of_input(columns: Columns, every: int) -> Array:
    """(1,) deviation of the noise of a driven body's input once it is averaged (`_averaged`), or went through a filter.

    White, as high as the quietest part of its spectrum: more may have been applied, and not only recorded.
    """
    (name,) = columns.channels.inputs
    white = math.sqrt(columns.spectra[name].high * columns.clock.rate_hz / 2.0)
    if not white > _SILENT * float(np.std(columns.columns[name])):
        return np.zeros(1)
    return np.array([white * _input_gain(columns.input_filter, columns.clock.rate_hz, every)])


def _input_gain(input_filter: LowPass, rate_hz: float, every: int) -> float:
    """What is left of the deviation of white noise on the input of a driven body: by its filter, or by `_averaged`."""
    if not input_filter.is_identity:
        return input_filter.white_noise_gain(rate_hz)
    return math.sqrt((2.0 * every**2 + 1.0) / (3.0 * every**3))


def _averaged(values: Array, every: int) -> Array:
    """(n, k) at every so manieth sample by a triangle: between samples it is linear again, and its impulse is kept."""
    if every == 1:
        return values
    ramp = np.arange(1, every + 1, dtype=np.float64)
    taps = np.concatenate([ramp, ramp[-2::-1]]) / every**2
    return convolved(mirrored(values, every - 1), taps)[::every]


def _parabolic(values: Array, every: int) -> Array:
    """(n, k) at every so manieth sample, by a parabola through those as far as the next one on both sides."""
    if every == 1:
        return values
    smoothed: Array = savgol_filter(values, 2 * every + 1, 2, axis=0)
    return smoothed[::every]


def _weight(time: Array, clock: Clock, contact: ContactTimes, low_pass: LowPass) -> Array:
    reach = low_pass.half_length_s
    # At a touch the force may jump, at an instant that is known to a sample only. Nearly all of what that makes lies
    # so near; farther away the touch is what tells the clocks' skew.
    blind = near(time, clock.gaps, reach) | near(time, contact.changes, _TOUCH * reach)
    blind |= (time < time[0] + reach) | (time > clock.times()[-1] - reach)
    return np.where(blind, 0.0, 1.0)
