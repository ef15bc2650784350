"""Tracks: each is one measured output of one recording, and how a model is replayed against it."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Self

import numpy as np

from mmt_drake.diagnosis.fit.workers import check_stop
from mmt_drake.diagnosis.signals.smoother import Smoothed
from mmt_drake.errors import BadInput, MmtError
from mmt_drake.model import kelvin_voigt
from mmt_drake.model.kelvin_voigt import KelvinVoigt
from mmt_drake.model.parameters import COARSENING, MAX_STEP
from mmt_drake.model.structure import Initial, PositionOut, Structure
from mmt_drake.motion.delay import delayed_input, input_behind
from mmt_drake.numeric.arrays import Array, Flags
from mmt_drake.over import Conditions, Model, standing_still, under
from mmt_drake.recording import AXES
from mmt_drake.windows import WHOLE, Windows

COARSE = 3.0
"""Steps in a search are so much longer than accuracy asks for; the error is about 0.1 of the noise at most."""

_SHORTEST_STEP = 1e-4
"""[s] of a search; a model that needs less is no candidate: nothing that fast shows in a force."""

_STABLE = 8.0
"""Steps over the accurate ones at which what is faster than a sample still dies out as it should, if not in shape."""
_SEARCHING, _IN_NOISE, NOISY = 8.0, 4.0, 2e-3
"""How much longer steps may be that are implicit in friction: in a search; and in a fit on the accurate clock where the
noise is more than this part of the force: the error is then a tenth of the noise at most."""
_PER_SAMPLE = 8.0
"""Steps in a sample interval beyond which a search asks for stability alone: nothing faster shows between samples."""

LONG, _FEWEST = 12_000, 3
"""Samples of a driven body's output beyond which what is easier to fit is a part of them, and the windows of that."""

_NODES = 6  # of the interpolation in time

States = Mapping[str, Array]
"""The signals that a missing force may depend on, by name."""
STATES = {
    "sliding_velocity": ("v", "sliding velocity", "m/s"),
    "deflection": ("d", "deflection", "m"),
    "deflection_rate": ("d'", "deflection rate", "m/s"),
    "position": ("x", "body position", "m"),
    "load": ("N", "normal load", "N"),
    "depth": ("depth", "depth", "m"),
    "depth_rate": ("depth'", "depth rate", "m/s"),
    "input": ("u", "input", ""),
}
"""Name -> how it is written in a formula and on a figure, and its unit."""
Replayed = tuple[Array, Callable[[], States]]
"""An output (n,), and the signals that belong to it where they are asked for: a search asks for none."""


@dataclass(frozen=True)
class Track(ABC):
    """One measured output on the clock of the fit.

    Attributes:
        smoothed: the recording.
        column: which of its outputs.
        heldout: (n,) samples that no fit looks at.
        floor: deviation of what sensor noise leaves of measured less simulated output, in the band compared.
        counts: how much its residuals count in a fit, see `mmt_drake.diagnosis.fit.floors.weighed`.
        beside: what curves of a model are over (`mmt_drake.over`), on this clock.
    """

    smoothed: Smoothed
    column: int
    heldout: Flags
    floor: float = field(default=float("nan"))
    counts: float = 1.0
    beside: Conditions = field(default_factory=dict)

    @property
    def time(self) -> Array:
        """(n,) [s]."""
        return self.smoothed.time

    @property
    def duration(self) -> float:
        """From the first sample to the last [s]."""
        return float(self.time[-1] - self.time[0])

    @cached_property
    def measured(self) -> Array:
        """(n,) filtered output; 0 where the sensor was at a limit."""
        return np.nan_to_num(self.smoothed.output[:, self.column])

    @cached_property
    def weight(self) -> Array:
        """(n,) 1 where measured and simulated output can be compared; in free space too, where the sensor is alone.

        0 where the sensor was at a limit.
        """
        return self.smoothed.weight * np.isfinite(self.smoothed.output[:, self.column])

    def compared(self, heldout: bool) -> Flags:
        """(n,) samples that are compared: those held out, or the others."""
        return (self.heldout == heldout) & (self.weight > 0.0)

    @property
    def is_whole(self) -> bool:
        """Whether all of the output was recorded as it was: its sensor was at no limit."""
        return bool(np.isfinite(self.smoothed.output[:, self.column]).all())

    @property
    def tells_scale(self) -> bool:
        """Whether a force was recorded, or an input that is not 0: without, all of the model's numbers scale alike."""
        return True

    def own(self, model: Model) -> Model:
        """The model as it is in this recording, without curves."""
        return under(model, self.beside, self.time - self.time[0], self.smoothed.source)

    def standing_still(self) -> Self:
        """The track with conditions that stay what they are on average."""
        return replace(self, beside=standing_still(self.beside))

    @property
    def axis(self) -> str:
        """x, y, z, or nothing for a single axis and a driven body."""
        return AXES[self.column] if self.smoothed.kind == "contact" else ""

    def simulated(self, model: Structure, skew: float = 0.0, coarse: float = COARSE) -> Array:
        """The model's output (n,), free-running, filtered as the measured one, later by the model's delay and the skew.

        Args:
            model: to replay.
            skew: how much later the output's clock reads than the input's [s].
            coarse: step of the integration over the accurate one.

        Raises:
            MmtError: the simulation diverges.
        """
        delay = model.additions.delay + skew
        output = self.smoothed.filter(self._finite(model, coarse, 0.0))
        return output if delay == 0.0 else later(output, delay * self.smoothed.rate_hz)

    def residual(self, model: Structure, skew: float = 0.0, coarse: float = COARSE) -> Array:
        """Measured less simulated (n,), 0 where the two cannot be compared."""
        return (self.measured - self.simulated(model, skew, coarse)) * self.weight

    def eased(self) -> Track:
        """The track, or what of it is easier to fit at first; its floor is then a guess."""
        return self

    def cut(self, count: int) -> Track:
        """The track cut into so many windows, if it is one of a body that moves by itself and is not cut yet."""
        return self

    def part(self, heldout: bool) -> Track:
        """The track, or what of it must be simulated for the samples that are held out, or for those that are not."""
        return self

    def replay(self, model: Structure, coarse: float = COARSE, late: float = 0.0) -> tuple[Array, States]:
        """Unfiltered output (n,) without delay, and the signals that a missing force may depend on, by name.

        The input of a driven body is `late` [s].

        Raises:
            MmtError: with these numbers, on this step, the model cannot be integrated.
        """
        output, states = self._integrated(model, coarse, late)
        return output, states()

    def _integrated(self, model: Structure, coarse: float, late: float) -> Replayed:
        """`_replayed`, its errors as those of `replay`."""
        try:
            return self._replayed(self.own(model), coarse, late)
        except RuntimeError as error:  # of the kernels, about numbers that are absurd
            raise MmtError(f"{self.smoothed.source}: {error}") from None

    @abstractmethod
    def _replayed(self, model: Structure, coarse: float, late: float) -> Replayed:
        """See `replay`."""

    def _finite(self, model: Structure, coarse: float, late: float) -> Array:
        """The output of `replay`, refused where it diverges."""
        check_stop()
        output, _ = self._integrated(model, coarse, late)
        with np.errstate(over="ignore"):
            diverges = not math.isfinite(output @ output)
        if diverges:
            raise MmtError(f"{self.smoothed.source}: the simulation diverges")
        return output


def later(values: Array, samples: float) -> Array:
    """Even samples (n,) as they were so many (of any sign, not whole) samples ago; the ends stay what they are.

    By the polynomial through the 6 samples around: a spline's accuracy on band-limited signals at a fraction of its
    cost, which every simulation of a search would pay.
    """
    whole = math.floor(samples)
    reach = abs(whole) + _NODES
    weights = np.ones(_NODES)
    # The wanted sample, counted from the earliest of the samples i - whole - 3 to i - whole + 2.
    wanted = _NODES // 2 - (samples - whole)
    for j in range(_NODES):
        for k in range(_NODES):
            if k != j:
                weights[j] *= (wanted - k) / (j - k)
    padded = np.pad(values, reach, mode="edge")
    found = np.convolve(padded, weights[::-1], mode="valid")
    first = reach - whole - _NODES // 2
    return found[first : first + len(values)]


def coarsened(p: Array, coarse: float, rate: float, noisy: bool = False) -> Array:
    """A kernel vector with the steps that are long enough where samples come at a rate [Hz], noisy or not."""
    accurate = p[MAX_STEP]
    p[MAX_STEP] *= coarse
    if accurate * COARSE < _SHORTEST_STEP:  # of a finer clock too: what a search found is not lost there
        raise MmtError("the model is too stiff for a search")
    if coarse > 1.0:
        p[MAX_STEP] = max(p[MAX_STEP], min(_STABLE * accurate, 1.0 / (_PER_SAMPLE * rate)))
        p[COARSENING] = _SEARCHING
    elif noisy:
        p[COARSENING] = _IN_NOISE
    return p


@dataclass(frozen=True)
class SpringTrack(Track):
    """The one axis of a Kelvin-Voigt contact."""

    def _replayed(self, model: Structure, coarse: float, late: float) -> Replayed:
        if not isinstance(model, KelvinVoigt):
            raise BadInput(self.smoothed.source, found=f"a {model.NAME} model", expected="kelvin_voigt")
        s = self.smoothed
        position, rate = s.input[:, 0].copy(), s.input_rate[:, 0].copy()
        force, load = np.empty(len(position)), np.zeros(len(position))
        kelvin_voigt.replay(s.time, position, rate, load, coarsened(model.kernel_vector(), coarse, s.rate_hz), force)
        return force, lambda: {
            "sliding_velocity": rate,
            "deflection": position - model.x0,
            "deflection_rate": rate,
            "position": position,
        }


@dataclass(frozen=True)
class DrivenTrack(Track):
    """The output of a driven body or a transmission.

    Attributes:
        window_s: length of the windows over which it is simulated [s]; None: the whole recording.
        initial: how it begins the whole recording.
        load: (n,) normal load of its bearing [N]; empty where none is recorded (`PositionOut.carried`).
        by_rate: whether the rate of the output is compared instead of the output. An output that integrates remembers
            every error there ever was, and its valleys are narrow; its rate forgets, and so do windows.
        wanted: (n,) samples; windows that score none of these are not simulated. Empty: all are.
    """

    window_s: float | None = None
    initial: Initial = "rest"
    load: Array = field(default_factory=lambda: np.zeros(0))
    by_rate: bool = False
    wanted: Flags = field(default_factory=lambda: np.zeros(0, dtype=bool))

    @cached_property
    def windows(self) -> Windows:
        """Over which it is simulated."""
        fitted = self.initial == "fitted"
        windows = Windows.of(self.time, self._leading, self.window_s, self.smoothed.nearby_reach_s, fitted)
        return windows.scoring(self.wanted) if len(self.wanted) else windows

    @cached_property
    def _parts(self) -> tuple[Track, Track]:
        """See `part`: what is fitted, and what is held out."""
        scored = self.windows.scored
        return replace(self, wanted=scored & ~self.heldout), replace(self, wanted=scored & self.heldout)

    def part(self, heldout: bool) -> Track:
        """See `Track.part`; windows know nothing of each other."""
        return self if self.window_s is None else self._parts[heldout]

    @property
    def tells_scale(self) -> bool:
        """See `Track.tells_scale`."""
        return bool(self.smoothed.input.any())

    @property
    def _leading(self) -> Array:
        """(n,) what states are fitted to: over windows what no held-out sample is filtered into."""
        return self.measured if self.window_s is None else self.smoothed.nearby[:, self.column]

    @cached_property
    def weight(self) -> Array:
        """See `Track.weight`; 0 where a lead-in is not scored."""
        return self.smoothed.weight * self.windows.scored

    def eased(self) -> Track:
        """See `Track.eased`: of what is long, windows spread over it.

        Else of a whole recording the rate, with the noise that white noise within the band would have.
        """
        if len(self.time) > LONG:
            split = self.cut(2 * WHOLE)
            fitted = split.windows.scoring(~self.heldout)
            often = min(len(self.time) // LONG + 1, fitted.count // _FEWEST)
            return replace(split, wanted=fitted.every(max(often, 1)).scored)
        if self.window_s is not None:
            return self
        top = 2.0 * math.pi * min(self.smoothed.low_pass.band_hz, 0.5 * self.smoothed.rate_hz)
        return replace(self, by_rate=True, floor=self.floor * top / math.sqrt(3.0))

    def cut(self, count: int) -> DrivenTrack:
        """See `Track.cut`."""
        return self if self.window_s is not None else replace(self, window_s=self.windows.length / count)

    def simulated(self, model: Structure, skew: float = 0.0, coarse: float = COARSE) -> Array:
        """See `Track.simulated`; the input is late, not the output, which only fits where one window follows another.

        Nor is what windows give filtered: a body's position has next to nothing above the band.
        """
        output = self._finite(model, coarse, model.additions.delay + skew)
        return self.smoothed.filter(output) if self.window_s is None else output

    def residual(self, model: Structure, skew: float = 0.0, coarse: float = COARSE) -> Array:
        """See `Track.residual`."""
        if not self.by_rate:
            return super().residual(model, skew, coarse)
        difference: Array = np.gradient(self.measured - self.simulated(model, skew, coarse), self.time)
        return difference * self.weight

    def _replayed(self, model: Structure, coarse: float, late: float) -> Replayed:
        if not isinstance(model, PositionOut):
            found, expected = f"a {model.NAME} model", "driven_body or transmission"
            raise BadInput(self.smoothed.source, found=found, expected=expected)
        s = self.smoothed
        p = coarsened(model.kernel_vector(), coarse, s.rate_hz)
        u = input_behind(s.time, s.input[:, 0].copy(), late, model.additions.lag)
        load = delayed_input(s.time, self.load, late) if len(self.load) else model.carried(u)
        measured = np.ascontiguousarray(self._leading)
        output, rate, states = self.measured.copy(), np.zeros(len(u)), np.empty((len(self.windows.rows), 2))
        self.windows.replay(measured, s.time, u, load, p, output, rate, states)

        def signals() -> States:
            drive = model.commanded(s.time, u, output, rate)
            carried = np.where(np.isnan(load), model.carried_by(drive), load)
            body = {"sliding_velocity": rate, "deflection": model.deflection(u, output), "position": output}
            return {**body, "input": drive, "load": carried}

        return output, signals
