"""The columns of a recording that a diagnosis reads, on an even clock, and the bands that they ask for."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from mmt_drake.diagnosis.signals.band import NARROWEST, comparison_band, top_excitation
from mmt_drake.diagnosis.signals.clocks import Clock, on_clock
from mmt_drake.diagnosis.signals.noise import NoiseSpectrum, noise_of
from mmt_drake.errors import BadInput
from mmt_drake.numeric.arrays import Array
from mmt_drake.numeric.zero_phase import LowPass
from mmt_drake.recording import AXES, Recording

_LONGEST_FILTER = 0.125  # of the recording
_ENCODED = 2.0  # pass band of an input that is a position, over that of the comparison: laws reach across
_NO_FILTER = LowPass(math.inf)


@dataclass(frozen=True)
class Channels:
    """Which columns of a recording drive the model, and which it answers with.

    Attributes:
        inputs: position columns, or the input of a driven body.
        input_rates: recorded velocity columns, as many; empty where there are none.
        outputs: force columns, or the output.
        noisy_input: whether the input is measured (a position) or known (a driven body's input).
    """

    inputs: tuple[str, ...]
    input_rates: tuple[str, ...]
    outputs: tuple[str, ...]
    noisy_input: bool


def channels_of(recording: Recording) -> Channels:
    """The channels of a recording.

    Raises:
        BadInput: a recording without forces.
    """
    if recording.kind == "motion":
        raise BadInput(recording.source, found="positions without forces", expected="a recording with force columns")
    if recording.kind == "driven_body":
        return Channels(("input",), (), ("output",), noisy_input=False)
    ends = [f"_{axis}" for axis in AXES] if recording.kind == "contact" else [""]
    rates = tuple(f"velocity{end}" for end in ends)
    own = all(name in recording and name not in recording.derived for name in rates)
    return Channels(
        tuple(f"position{end}" for end in ends), rates if own else (), tuple(f"force{end}" for end in ends), True
    )


@dataclass(frozen=True)
class Bands:
    """The bands of one recording [Hz], infinity for no filter.

    Attributes:
        comparison_hz: of the output.
        moving_hz: pass band of each moving column.
        top_hz: (k,) top excitation of each.
        resampling_error: (k,) of each, the bound for a sine of the top excitation, three times as strong as the
            motion is on average.
    """

    comparison_hz: float
    moving_hz: tuple[float, ...]
    top_hz: Array
    resampling_error: Array


@dataclass(frozen=True)
class Columns:
    """The columns of a recording on its own even clock.

    Attributes:
        channels: which of them drive the model, and which it answers with.
        clock: even.
        columns: name -> (n,) on that clock.
        spectra: name -> its spectrum, to read noise off; of an input as it was recorded.
        input_filter: what an input that is a position went through (`with_encoded_input`); else none.
    """

    channels: Channels
    clock: Clock
    columns: Mapping[str, Array]
    spectra: Mapping[str, NoiseSpectrum]
    input_filter: LowPass = _NO_FILTER

    @classmethod
    def of(cls, recording: Recording, clock: Clock) -> Columns:
        """The columns of a recording on an even clock.

        Raises:
            BadInput: a recording without forces, or a column that is not one number a sample.
        """
        channels = channels_of(recording)
        names = (*channels.inputs, *channels.input_rates, *channels.outputs)
        if recording.kind == "driven_body" and "output_rate" in recording and "output_rate" not in recording.derived:
            names = (*names, "output_rate")
        for name in names:
            if recording[name].shape != recording.time.shape:
                found = f"an array of the shape {recording[name].shape}"
                raise BadInput(recording.source, at=name, found=found, expected=f"{len(recording)} numbers")
        table = on_clock(recording.time, np.column_stack([recording[name] for name in names]), clock)
        columns = dict(zip(names, np.ascontiguousarray(table.T), strict=True))
        spectra = {name: noise_of(values, clock.rate_hz) for name, values in columns.items()}
        return cls(channels, clock, columns, spectra)

    def with_encoded_input(self) -> Columns:
        """The same where the input is a position, with the noise of its encoder above the band taken off.

        A damper makes forces of that noise, which keep a body moving that friction would hold.
        """
        (name,) = self.channels.inputs
        band_hz = _ENCODED * self.bands(None).comparison_hz
        if not self._takes(band_hz):
            return self
        input_filter = LowPass(band_hz)
        filtered = input_filter.apply(self.table((name,)), self.clock.rate_hz)
        return replace(self, columns={**self.columns, name: filtered[:, 0]}, input_filter=input_filter)

    def _takes(self, band_hz: float) -> bool:
        """Whether a filter of a band fits: below a quarter of the rate, and not as long as the recording nearly."""
        fits = 0.0 < band_hz <= self.clock.rate_hz / 4.0
        return fits and LowPass(band_hz).half_length_s <= _LONGEST_FILTER * self.clock.step * self.clock.count

    def table(self, names: tuple[str, ...]) -> Array:
        """Some of them side by side, (n, k)."""
        return np.column_stack([self.columns[name] for name in names])

    @property
    def moving(self) -> tuple[str, ...]:
        """The columns whose motion sets the band: positions, or a driven body's output."""
        return self.channels.inputs if self.channels.noisy_input else self.channels.outputs

    @property
    def moving_rates(self) -> tuple[str, ...]:
        """The recorded rates of `moving`, as many; empty where there are none."""
        if self.channels.noisy_input:
            return self.channels.input_rates
        return ("output_rate",) if "output_rate" in self.columns else ()

    def bands(self, wanted: float | None) -> Bands:
        """The bands to use.

        Args:
            wanted: comparison band [Hz]; None for that of `comparison_band`. Where a filter does not fit, that is, with
                a band beyond a quarter of the rate or a recording of fewer than eight of its half-lengths, there is
                none; but a measured input is never left without one for the sake of the band alone.
        """
        rate, high = self.clock.rate_hz, {name: noise.high for name, noise in self.spectra.items()}
        tops = [top_excitation(self.columns[name], rate, high[name]) for name in self.moving]
        tangential = range(2) if len(self.moving) == 3 else range(len(self.moving))
        # The axis that moves most sets the band; one that rests has only its noise to show.
        main = max(tangential, key=lambda i: tops[i][1])
        if tops[main][1] == 0.0:
            main = max(range(len(tops)), key=lambda i: tops[i][1])
        if wanted is None:
            rates = self.moving_rates
            wanted = comparison_band(*tops[main], high[self.moving[main]], high[rates[main]] if rates else math.inf)
        error = np.array([self.clock.spline_error(3.0 * speed * (2.0 * math.pi * top) ** 3) for top, speed in tops])
        top_hz = np.array([top for top, _ in tops])
        widest = rate / 4.0
        if wanted > widest and self.channels.noisy_input and not math.isinf(wanted):
            wanted = widest
        if not self._takes(wanted):
            return Bands(math.inf, (math.inf,) * len(tops), top_hz, error)
        moving = tuple(min(max(wanted, NARROWEST * top), widest) for top in top_hz.tolist())
        return Bands(wanted, moving, top_hz, error)
