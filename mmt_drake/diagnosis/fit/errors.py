"""Errors of a model on held-out data, and those that a right model would have.

Everything here is as recorded: nothing is filtered, no clock is moved, and the simulation runs freely from the first
sample on, or over the windows of the model's `window_s`. So anyone can compute the same figures again from the files.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from mmt_drake.analysis.nrmse import rms
from mmt_drake.analysis.signals import stretches
from mmt_drake.diagnosis.signals.smoother import Smoothed
from mmt_drake.errors import BadInput, MmtError
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.model.structure import PositionOut, Structure
from mmt_drake.numeric.arrays import Array, Flags
from mmt_drake.recording import Recording
from mmt_drake.recording.derive import rate_of, touches
from mmt_drake.replay import in_windows, replayed
from mmt_drake.windows import Windows

Interval = tuple[float, float]


class ErrorOverSpread(NamedTuple):
    """RMS error, and the standard deviation of what was measured, both in its unit."""

    rms: float
    spread: float

    @property
    def ratio(self) -> float:
        """As `HeldOutPart.nrmse` has it."""
        return self.rms / self.spread


@dataclass(frozen=True)
class HeldOutPart:
    """What of a recording nothing was fitted to.

    What counts are the samples within the blocks, of a flexible box those in contact.

    Attributes:
        recording: as read.
        blocks: (from, to) [s], ends included, in the recording's own time.
        smoothed: the recording; it knows the noise of each column.
        axes: those that count, of `x`, `y` and `z`, all samples of all of them together; ignored where there is one
            output.
    """

    recording: Recording
    blocks: tuple[Interval, ...]
    smoothed: Smoothed
    axes: tuple[str, ...] = ()

    def nrmse(self, model: Structure) -> float:
        """Error of a model: sqrt(mean((measured - simulated)^2)) / std(measured).

        Raises:
            BadInput: model and recording do not fit, no sample counts, the measured output does not vary there, or a
                recording of three axes and none of them named.
            MmtError: the simulation diverges.
        """
        return self.error(model).ratio

    def floor(self, model: Structure) -> float:
        """What sensor noise alone leaves, in the unit of `nrmse`; raises as that."""
        return self.noise(model).ratio

    def spread(self, model: Structure) -> float:
        """Standard deviation of what was measured, in its unit: times `nrmse` it is the RMS error; raises as that."""
        return self.error(model).spread

    def error(self, model: Structure) -> ErrorOverSpread:
        """What `nrmse` is made of; raises as that."""
        chosen, simulated = self._counting(model), predicted(model, self.recording)
        chosen &= self._known(simulated)
        measured = self._joined(self.recording.columns, chosen)
        return self._over_spread(rms(measured - self._joined(simulated, chosen)), measured)

    def noise(self, model: Structure) -> ErrorOverSpread:
        """What `floor` is made of; raises as that.

        The output's own noise, and that of the recorded position and velocity sent through the model (`noise_through`).
        """
        chosen, through = self._counting(model), noise_through(model, self.recording, self.smoothed)
        chosen &= self._known(through)
        own = {name: self.smoothed.noise[name].std for name in self._outputs}
        squares = [std**2 + float(np.mean(through[name][chosen] ** 2)) for name, std in own.items()]
        left = math.sqrt(math.fsum(squares) / len(squares))
        return self._over_spread(left, self._joined(self.recording.columns, chosen))

    @property
    def _outputs(self) -> tuple[str, ...]:
        """The columns that count."""
        if self.recording.kind == "driven_body":
            return ("output",)
        if self.recording.kind == "single_axis":
            return ("force",)
        if not self.axes:
            raise BadInput(self.recording.source, at="axes", found="none", expected="x, y, z or several")
        return tuple(f"force_{axis}" for axis in self.axes)

    def _counting(self, model: Structure) -> Flags:
        """(n,) samples that count: within the blocks, and of a flexible box those in contact."""
        chosen = within(self.recording.time, self.blocks)
        if isinstance(model, FlexibleBoxModel):
            chosen &= in_contact(self.recording)
        if not chosen.any():
            found, expected = "no sample that counts", "held-out blocks with samples in contact"
            raise BadInput(self.recording.source, at="held-out blocks", found=found, expected=expected)
        return chosen

    def _known(self, simulated: Mapping[str, Array]) -> Flags:
        """(n,) samples that were simulated."""
        return np.isfinite(simulated[self._outputs[0]])

    def _joined(self, columns: Mapping[str, Array], chosen: Flags) -> Array:
        return np.concatenate([columns[name][chosen] for name in self._outputs])

    def _over_spread(self, left: float, measured: Array) -> ErrorOverSpread:
        spread = float(np.std(measured)) if len(measured) else 0.0
        if spread == 0.0:
            raise BadInput(self.recording.source, found="a constant output", expected="one that varies when held out")
        return ErrorOverSpread(left, spread)


def predicted(model: Structure, recording: Recording) -> dict[str, Array]:
    """The simulation that the model is held by: over the windows of its `window_s`, NaN outside, else `free_running`.

    Raises:
        BadInput, MmtError: as `free_running`.
    """
    if model.window_s is None or not isinstance(model, PositionOut) or recording.kind != "driven_body":
        return free_running(model, recording)
    windows = Windows.of(recording.time, recording["output"], model.window_s)
    simulated = _finite(recording, lambda: in_windows(model, recording, windows)[0], windows.scored)
    return {name: np.where(windows.scored, values, np.nan) for name, values in simulated.items()}


def free_running(model: Structure, recording: Recording) -> dict[str, Array]:
    """`replayed`, refused where it diverges.

    Raises:
        BadInput: model and recording do not fit.
        MmtError: the simulation diverges.
    """
    return _finite(recording, lambda: replayed(model, recording))


def _finite(
    recording: Recording, simulate: Callable[[], dict[str, Array]], scored: Flags | slice = slice(None)
) -> dict[str, Array]:
    try:
        simulated = simulate()
    except RuntimeError as error:  # of the kernels, about numbers that are absurd
        raise MmtError(f"{recording.source}: {str(error).splitlines()[0]}") from error
    if not all(np.isfinite(values[scored]).all() for values in simulated.values()):
        raise MmtError(f"{recording.source}: the simulation diverges")
    return simulated


def noise_through(model: Structure, recording: Recording, smoothed: Smoothed) -> dict[str, Array]:
    """What the noise of the recorded motion becomes in the model's output: column -> (n,).

    Motion as it was smoothed is replayed, and that with white noise as strong as the recorded one's; the difference is
    returned. So it has what noise bends as well: where a law counts noise as a way, its loop is smaller than that of
    the motion. Motion whose velocity was derived, and a driven body's input and output as far as states are fitted to
    it, are replayed as recorded and with as much noise again: the polynomials that derive a rate go by the noise. A hum
    of the position counts as noise; where no filter applies, smoothed motion is the recorded one.

    Raises:
        BadInput, MmtError: as `free_running`.
    """
    quiet, noisy = _quiet_and_noisy(recording, smoothed)
    simulated = predicted(model, quiet)
    return {name: values - simulated[name] for name, values in predicted(model, noisy).items()}


def _quiet_and_noisy(recording: Recording, smoothed: Smoothed) -> tuple[Recording, Recording]:
    """What `noise_through` replays.

    Of a driven body the first sample is as it was: there it may have been at rest.
    """
    generator = np.random.default_rng(0)
    quiet, noisy = dict(recording.columns), dict(recording.columns)

    def noise_of(name: str, std: float) -> Array:
        """(n,) none where an encoder stands on one count."""
        moves = rate_of(recording.time, recording[name]) != 0.0
        return std * generator.standard_normal(len(moves)) * moves

    if recording.kind == "driven_body":
        for name, std in (("input", smoothed.raw_input_noise), ("output", smoothed.noise["output"].std)):
            noisy[name] = recording[name] + noise_of(name, std)
        noisy["output"][0] = recording["output"][0]
        return recording, replace(recording, columns=noisy)
    axes = [name for name in ("position", "position_x", "position_y", "position_z") if name in smoothed.noise]
    positions, rates = smoothed.motion_at(recording.time)
    for name, position, rate in zip(axes, positions.T, rates.T, strict=True):
        velocity = name.replace("position", "velocity")
        was_read = velocity in smoothed.noise
        if was_read:
            quiet[name], quiet[velocity] = position, rate
        noisy[name] = quiet[name] + noise_of(name, smoothed.noise[name].std)
        if was_read:
            noisy[velocity] = rate + noise_of(velocity, smoothed.noise[velocity].std)
        else:
            noisy[velocity] = rate_of(recording.time, noisy[name])
    return replace(recording, columns=quiet), replace(recording, columns=noisy)


def in_contact(recording: Recording) -> Flags:
    """(n,) samples in contact: as the recording says, else z < 0; all of a single axis that does not say."""
    if "in_contact" in recording:
        return recording["in_contact"] != 0.0
    if "position_z" in recording:
        return touches(recording["position_z"]) != 0.0
    return np.ones(len(recording), dtype=bool)


def within(time: Array, intervals: Sequence[Interval]) -> Flags:
    """Which of the times (n,) [s] lie within the intervals (from, to), both ends included."""
    flags = np.zeros(len(time), dtype=bool)
    for start, end in intervals:
        flags |= (time >= start) & (time <= end)
    return flags


def intervals_of(time: Array, flags: Flags) -> tuple[Interval, ...]:
    """The runs of flagged samples (n,) as (first, last) times [s], to the microsecond: what a file can tell."""
    return tuple((round(float(time[first]), 6), round(float(time[last]), 6)) for first, last in stretches(flags))
