"""How far a model is from a recording on held-out data, and how far a right model would be.

Everything here is as recorded: nothing is filtered, no clock is moved, and the simulation runs freely from the first
sample on. So anyone can compute the same figures again from the files.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mmt_drake.analysis.nrmse import nrmse
from mmt_drake.diagnosis.smoother import Smoothed
from mmt_drake.errors import BadInput, MmtError
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.model.structure import Structure
from mmt_drake.recording import Recording
from mmt_drake.recording.derive import rate_of, touches
from mmt_drake.replay import replayed

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Interval = tuple[float, float]


@dataclass(frozen=True)
class HeldOut:
    """The samples of one recording that models are judged by.

    Attributes:
        recording: as read.
        intervals: held-out blocks (from, to) [s], ends included, in the recording's own time.
        axes: the tangential axes that count, `x` and `y`; anything else, or nothing, for a recording with one output.
    """

    recording: Recording
    intervals: tuple[Interval, ...]
    axes: tuple[str, ...] = ()

    @property
    def outputs(self) -> tuple[str, ...]:
        """The columns that count.

        Raises:
            BadInput: a recording of three axes and none of them named, or one without forces.
        """
        if self.recording.kind == "driven_body":
            return ("output",)
        if self.recording.kind == "single_axis":
            return ("force",)
        if not self.axes:
            raise BadInput(self.recording.source, at="axes", found="none", expected="x, y or both")
        return tuple(f"force_{axis}" for axis in self.axes)

    def samples(self, model: Structure) -> Flags:
        """(n,) samples that count: within the blocks, and of a flexible box those in contact."""
        chosen = within(self.recording.time, self.intervals)
        return chosen & in_contact(self.recording) if isinstance(model, FlexibleBoxModel) else chosen

    def errors(self, model: Structure) -> tuple[Array, Array]:
        """Measured and simulated output (m,) at the samples that count, all axes in a row.

        Raises:
            BadInput: model and recording do not fit, or no sample counts.
            MmtError: the simulation diverges.
        """
        simulated, chosen = free_running(model, self.recording), self.samples(model)
        if not chosen.any():
            expected = "held-out blocks with samples in contact"
            raise BadInput(
                self.recording.source, at="held-out blocks", found="no sample that counts", expected=expected
            )
        pairs = [(self.recording[name][chosen], simulated[name][chosen]) for name in self.outputs]
        return np.concatenate([measured for measured, _ in pairs]), np.concatenate([other for _, other in pairs])

    def noise_variance(self, model: Structure, smoothed: Smoothed, seed: int = 0) -> tuple[float, int]:
        """Mean square of what sensor noise alone leaves of measured less simulated output, and of how many samples."""
        chosen = self.samples(model)
        through = noise_through(model, self.recording, smoothed, seed)
        squares = [smoothed.noise[name].std ** 2 + float(np.mean(through[name][chosen] ** 2)) for name in self.outputs]
        return float(np.mean(squares)), len(squares) * int(np.count_nonzero(chosen))


def heldout_nrmse(
    recording: Recording, model: Structure, intervals: Sequence[Interval], axes: Sequence[str] = ()
) -> float:
    """Error of a model on held-out data: sqrt(mean((measured - simulated)^2)) / std(measured).

    Args:
        recording: as read.
        model: nominal or augmented.
        intervals: held-out blocks (from, to) [s].
        axes: tangential axes that count, all samples of all of them together; ignored where there is one output.

    Raises:
        BadInput: model and recording do not fit, no sample counts, or the measured output does not vary there.
        MmtError: the simulation diverges.
    """
    return pooled_nrmse([HeldOut(recording, tuple(intervals), tuple(axes))], model)


def pooled_nrmse(heldout: Sequence[HeldOut], model: Structure) -> float:
    """`heldout_nrmse` over the samples of several recordings together."""
    pairs = [one.errors(model) for one in heldout]
    measured, simulated = (np.concatenate(parts) for parts in zip(*pairs, strict=True))
    error = nrmse(measured, simulated)
    if error is None:
        raise BadInput(heldout[0].recording.source, found="a constant output", expected="one that varies when held out")
    return error


def noise_floor(
    recording: Recording,
    model: Structure,
    intervals: Sequence[Interval],
    axes: Sequence[str],
    smoothed: Smoothed,
    *,
    seed: int = 0,
) -> float:
    """What sensor noise alone leaves, in the unit of `heldout_nrmse`.

    The output's own noise, and that of the recorded position and velocity sent through the model (`noise_through`).

    Args:
        recording, model, intervals, axes: as in `heldout_nrmse`.
        smoothed: of the recording; it knows the noise of each column.
        seed: of the noise that is added.

    Raises:
        BadInput, MmtError: as `heldout_nrmse`.
    """
    return pooled_noise_floor([HeldOut(recording, tuple(intervals), tuple(axes))], model, [smoothed], seed=seed)


def pooled_noise_floor(
    heldout: Sequence[HeldOut], model: Structure, smoothed: Sequence[Smoothed], *, seed: int = 0
) -> float:
    """`noise_floor` over the samples of several recordings together."""
    measured = np.concatenate([one.errors(model)[0] for one in heldout])
    parts = [one.noise_variance(model, s, seed) for one, s in zip(heldout, smoothed, strict=True)]
    variance = math.fsum(square * count for square, count in parts) / math.fsum(count for _, count in parts)
    return math.sqrt(variance) / float(np.std(measured))


def free_running(model: Structure, recording: Recording) -> dict[str, Array]:
    """`replayed`, refused where it diverges.

    Raises:
        BadInput: model and recording do not fit.
        MmtError: the simulation diverges.
    """
    try:
        simulated = replayed(model, recording)
    except RuntimeError as error:  # of the kernels, about numbers that are absurd
        raise MmtError(f"{recording.source}: {str(error).splitlines()[0]}") from error
    if not all(np.isfinite(values).all() for values in simulated.values()):
        raise MmtError(f"{recording.source}: the simulation diverges")
    return simulated


def noise_through(model: Structure, recording: Recording, smoothed: Smoothed, seed: int = 0) -> dict[str, Array]:
    """What the noise of the recorded motion becomes in the model's output: column -> (n,).

    A second replay has as much noise again on the position and velocity columns; a velocity that was derived is derived
    again. The difference of the two replays is returned. The input of a driven body is known, so nothing comes
    through.

    Raises:
        BadInput, MmtError: as `free_running`.
    """
    simulated = free_running(model, recording)
    if recording.kind == "driven_body":
        return {name: np.zeros(len(recording)) for name in simulated}
    noisy = free_running(model, shaken(recording, smoothed, seed))
    return {name: noisy[name] - values for name, values in simulated.items()}


def shaken(recording: Recording, smoothed: Smoothed, seed: int = 0) -> Recording:
    """The recording with white noise, as strong as its own again, on its position and velocity columns."""
    generator = np.random.default_rng(seed)
    columns = dict(recording.columns)
    for position in ("position", "position_x", "position_y", "position_z"):
        if position not in smoothed.noise:
            continue
        columns[position] = _noisier(columns[position], smoothed.noise[position].std, generator)
        velocity = position.replace("position", "velocity")
        if velocity in smoothed.noise:
            columns[velocity] = _noisier(columns[velocity], smoothed.noise[velocity].std, generator)
        else:
            columns[velocity] = rate_of(recording.time, columns[position])
    return replace(recording, columns=columns)


def _noisier(values: Array, std: float, generator: np.random.Generator) -> Array:
    return values + std * generator.standard_normal(len(values))


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
    padded = np.concatenate([[False], flags, [False]])
    edges = np.flatnonzero(padded[1:] != padded[:-1])
    runs = zip(edges[::2], edges[1::2], strict=True)
    return tuple((round(float(time[first]), 6), round(float(time[stop - 1]), 6)) for first, stop in runs)
