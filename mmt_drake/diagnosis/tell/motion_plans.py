"""Motions, inputs and goals that a recording's own hand, or drive, could make: the bank's, as far and fast as those."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from mmt_drake.diagnosis.fit.errors import free_running
from mmt_drake.diagnosis.fit.tracks import Track
from mmt_drake.diagnosis.signals.smoother import Smoothed
from mmt_drake.diagnosis.tell.motion_bank import INPUTS, BankInput, BankMotion, Reach, motions
from mmt_drake.errors import MmtError
from mmt_drake.model.driven_model import DrivenBodyModel
from mmt_drake.model.structure import Structure
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording import AXES, Recording

_UNFILTERED_HZ = 250.0
"""What is compared without a filter is simulated at this rate or 25 times the top frequency, noise and all."""
_SHORTEST_S, _LONGEST_S = 20.0, 40.0
_LEAST_AMPLITUDE, _MOST_AMPLITUDE = 0.01, 0.1  # m
_LEAST_DEPTH, _MOST_DEPTH = 0.002, 0.01  # m
_LEAST_SPEED, _MOST_SPEED = 0.1, 0.8  # m/s
_LEAST_TOP_HZ, _MOST_TOP_HZ = 1.0, 3.6  # of strokes
_FARTHER = 1.5  # a driven body may leave its recorded range by this much
_SLOWEST = 0.25  # times the top frequency of the recorded output: the slowest input that is tried
_TEMPI_AND_GAINS = tuple((2.0**k, gain) for gain in (1.0, 0.6, 0.3) for k in range(7))
"""Of the slowest input and of the largest recorded one; the first pair that keeps the body in its range is taken."""


@dataclass(frozen=True)
class MotionPlan:
    """A motion or input to try: how it is made, in words, and what it is, a recording of its name."""

    text: str
    recording: Recording

    @property
    def name(self) -> str:
        """A few words."""
        return self.recording.source


def closed_loop(model: Structure) -> bool:
    """Whether the input is the goal of a controller."""
    return isinstance(model, DrivenBodyModel) and model.controller is not None


@dataclass(frozen=True)
class Planner:
    """What can be tried.

    Attributes:
        models: the explanations; a driven body has to stay in its range whichever is right.
        recording: at hand, as read.
        track: of it, the output by which motions are judged.
    """

    models: Sequence[Structure]
    recording: Recording
    track: Track

    @property
    def smoothed(self) -> Smoothed:
        """The recording at hand."""
        return self.track.smoothed

    @property
    def duration(self) -> float:
        """Of the motions [s]."""
        length = float(self.recording.time[-1] - self.recording.time[0])
        return min(max(length, _SHORTEST_S), _LONGEST_S)

    @property
    def rate_hz(self) -> float:
        """Of what is simulated: that of the recording, or less where no filter needs it."""
        own = self.smoothed.clock.rate_hz
        if not self.smoothed.low_pass.is_identity:
            return own
        return min(own, max(_UNFILTERED_HZ, 25.0 * float(self.smoothed.top_hz.max())))

    def plans(self) -> Iterator[MotionPlan]:
        """Everything in the bank."""
        if self.smoothed.kind == "driven_body":
            yield from self._inputs()
            return
        for motion in motions(self._reach()):
            if self.smoothed.kind == "contact" or not motion.of_surface:
                yield self._motion(motion)

    def _reach(self) -> Reach:
        """As far, as fast and as deep as the recorded hand went, within what a hand does."""
        s, touching = self.smoothed, self.smoothed.in_contact
        along = s.input[touching, self.track.column]
        speed = float(np.abs(s.input_rate[touching, self.track.column]).max())
        top = float(np.clip(s.top_hz[self.track.column], _LEAST_TOP_HZ, _MOST_TOP_HZ))
        if s.kind == "single_axis":
            return Reach("y", 0.5 * float(np.ptp(along)), speed, _LEAST_DEPTH, self.duration, top)
        amplitude = float(np.clip(0.5 * np.ptp(along), _LEAST_AMPLITUDE, _MOST_AMPLITUDE))
        depth = float(np.clip(-np.mean(s.input[touching, 2]), _LEAST_DEPTH, _MOST_DEPTH))
        speed = float(np.clip(speed, _LEAST_SPEED, _MOST_SPEED))
        return Reach(AXES[self.track.column], amplitude, speed, depth, self.duration, top)

    def _motion(self, motion: BankMotion) -> MotionPlan:
        time, position, velocity = motion.sample(self.rate_hz)
        if self.smoothed.kind == "single_axis":
            x = self.smoothed.input[:, 0]
            middle = 0.5 * float(x.min() + x.max())
            columns = {"position": middle + position[:, 1], "velocity": velocity[:, 1]}
            return MotionPlan(motion.text, Recording(time, columns, motion.name))
        columns = {f"position_{axis}": position[:, i] for i, axis in enumerate(AXES)}
        columns |= {f"velocity_{axis}": velocity[:, i] for i, axis in enumerate(AXES)}
        return MotionPlan(motion.text, Recording(time, columns, motion.name))

    def _inputs(self) -> Iterator[MotionPlan]:
        """Inputs as strong as the recorded one, each as slow as keeps the body in its range; none without any input.

        Of a closed loop they are goals.
        """
        u = self.recording["input"]
        # The input has to hold the body up, or its place is the output's, or it is a goal.
        model = self.models[0]
        about = closed_loop(model) or any(model.value(symbol) != 0.0 for symbol in ("g", "ratio"))
        rest = float(np.mean(u)) if about else 0.0
        strongest = float(np.abs(u - rest).max())
        if strongest == 0.0:
            return
        slowest = max(float(self.smoothed.top_hz[0]), 2.0 / self.duration) * _SLOWEST
        time = np.arange(round(self.duration * self.rate_hz), dtype=np.float64) / self.rate_hz
        for one in INPUTS:
            for tempo, gain in _TEMPI_AND_GAINS:
                top = tempo * slowest
                plan = self._input(one, time, top, rest, gain * strongest)
                if self._stays(plan):
                    yield plan
                    break

    def _input(self, one: BankInput, time: Array, top_hz: float, rest: float, size: float) -> MotionPlan:
        start = np.full(len(time), float(self.recording["output"][0]))  # only the first one counts
        columns = {"input": rest + size * one.shape(time, top_hz), "output": start}
        if "load" in self.recording:
            columns["load"] = np.full(len(time), float(np.mean(self.recording["load"])))
        text = f"{one.text.format(top=top_hz)}, {size:.3g} at most"
        return MotionPlan(text, Recording(time, columns, one.name))

    def _stays(self, plan: MotionPlan) -> bool:
        """Whether the body stays about where it was recorded, whatever explanation is right."""
        x = self.recording["output"]
        middle, half = 0.5 * float(x.max() + x.min()), 0.5 * float(np.ptp(x))
        try:
            outputs = [free_running(model, plan.recording)["output"] for model in self.models]
        except MmtError:
            return False
        return all(float(np.abs(output - middle).max()) <= _FARTHER * half for output in outputs)
