"""The next recording: the motion that would settle what this one leaves open, found by simulation.

Each motion of a bank is played to each of the explanations in turn. What that one answers is taken for a recording,
with the sensors of the recording at hand, and every other explanation is fitted to it. What the wrong one then cannot
fit, held against the noise, is how well the motion would separate them.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from itertools import permutations
from pathlib import Path
from typing import Final

import numpy as np

from mmt_drake.diagnosis.fit.box_tracks import NormalTrack
from mmt_drake.diagnosis.fit.comparison import RULED_OUT
from mmt_drake.diagnosis.fit.errors import free_running
from mmt_drake.diagnosis.fit.floors import with_floors
from mmt_drake.diagnosis.fit.prepare import Prepared
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.diagnosis.fit.tracks import DrivenTrack, Track
from mmt_drake.diagnosis.signals.smoother import Smoothed, smooth
from mmt_drake.diagnosis.tell.motion_plans import MotionPlan, Planner, closed_loop
from mmt_drake.effects.wording import words
from mmt_drake.errors import BadInput, MmtError
from mmt_drake.model.structure import Structure
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording import Recording, save

MOTION_FILE: Final = "next_motion.npz"
INPUT_FILE: Final = "next_input.npz"
MOST_RIVALS: Final = 4

_STEPS = 6


@dataclass(frozen=True)
class Separation:
    """How far apart a motion holds the explanations that are hardest to tell apart.

    Attributes:
        noises: what the wrong one leaves beyond the noise, RMS over the noise.
        margin: by how much it is worse in -2 ln(likelihood), each free number counting ln(samples).
    """

    noises: float
    margin: float

    @property
    def settles(self) -> bool:
        """Whether that rules the wrong one out."""
        return self.margin > RULED_OUT


@dataclass(frozen=True)
class TriedMotion:
    """One motion, tried in simulation.

    Attributes:
        plan: the motion; of one axis or a driven body with what the first explanation answers.
        separation: what it would do.
    """

    plan: MotionPlan
    separation: Separation


@dataclass(frozen=True)
class Prescription:
    """What to record.

    Attributes:
        text: in words.
        best: the motion to make; None where no motion of the bank separates the explanations.
        now: how far apart the recordings at hand hold them.
        tried: all motions that were tried, best first.
    """

    text: str
    best: TriedMotion | None
    now: Separation
    tried: tuple[TriedMotion, ...]

    def write(self, folder: str | Path) -> Path | None:
        """Write the motion (`next_motion.npz`) or input (`next_input.npz`), whole or not at all; None if there is none.

        Raises:
            BadInput: the file cannot be written.
        """
        if self.best is None:
            return None
        recording = self.best.plan.recording
        target = Path(folder) / (INPUT_FILE if recording.kind == "driven_body" else MOTION_FILE)
        save(recording, target)
        return target


def prescribe(
    rivals: Sequence[Fitted], prepared: Prepared, executor: Executor, is_late: Callable[[], bool] = lambda: False
) -> Prescription:
    """Find the motion that would tell explanations apart.

    Args:
        rivals: two explanations or more, best first; the first `MOST_RIVALS` count.
        prepared: the recordings at hand.
        executor: tries the motions.
        is_late: whether the time is over; no more than one further motion is then tried.

    Raises:
        BadInput: fewer than two explanations, or recordings that were refused.
    """
    if len(rivals) < 2:
        raise BadInput("prescription", found=f"{len(rivals)} explanations", expected="two or more")
    if prepared.problem is None:
        source = prepared.recordings[0].source
        raise BadInput(source, found=prepared.refusal, expected="a recording to fit")
    first, tracks = tuple(rivals[:MOST_RIVALS]), prepared.problem.tracks
    along = [track for track in tracks if not isinstance(track, NormalTrack)]
    loudest = max(along, key=lambda t: float(np.std(t.measured[t.weight > 0.0])) / t.floor)
    pairs = zip(prepared.recordings, prepared.problem.by_recording(), strict=True)
    own = next(recording for recording, of_it in pairs if any(track is loudest for track in of_it))
    still = loudest.standing_still()
    pressed = next((track for track in tracks if isinstance(track, NormalTrack)), None)
    session = _MotionSearch(first, Planner([still.own(rival.model) for rival in first], own, still), pressed)
    now = session.separation(tracks)
    tried = []
    for motion in executor.map(session.tried, session.planner.plans()):
        if motion is not None:
            tried.append(motion)
        if is_late():  # what is not begun by now is cancelled
            break
    tried.sort(key=lambda t: -t.separation.margin)
    best = next((t for t in tried if t.separation.settles and t.separation.margin > now.margin), None)
    return Prescription(_in_words(first, best, now, tried), best, now, tuple(tried))


@dataclass(frozen=True)
class _MotionSearch:
    """One search for a motion.

    Attributes:
        rivals: the explanations.
        planner: of what can be tried; its track is the output by which motions are judged.
        pressed: the normal axis, by which they are judged as well; None where it is not compared.
    """

    rivals: tuple[Fitted, ...]
    planner: Planner
    pressed: NormalTrack | None = None

    @property
    def smoothed(self) -> Smoothed:
        """The recording at hand."""
        return self.planner.smoothed

    def tried(self, plan: MotionPlan) -> TriedMotion | None:
        """The motion and what it separates; None where it cannot be simulated."""
        try:
            answered = self._answered(plan.recording, self.planner.models[0])
            tracks = self._as_recorded(answered)
            separation = self.separation(with_floors(tracks, self.rivals[0].model))
        except MmtError:
            return None
        if self.smoothed.kind != "contact":
            told = {name: answered[name] for name in ("force", "output") if name in answered}
            plan = replace(plan, recording=_with(plan.recording, told))
        return TriedMotion(plan, separation)

    def _answered(self, motion: Recording, model: Structure) -> Recording:
        """The motion with the forces, or the output, that a model answers with."""
        if self.smoothed.kind == "contact":
            motion = _with(motion, {"in_contact": (motion["position_z"] < 0.0).astype(np.float64)})
        return _with(motion, {k: v for k, v in free_running(model, motion).items() if k != "output_rate"})

    def _as_recorded(self, clean: Recording) -> list[Track]:
        """The tracks of a recording without noise, as the sensors at hand would have recorded it."""
        generator = np.random.default_rng(0)
        columns = dict(clean.columns)
        for name, values in clean.columns.items():
            if name in self.smoothed.noise:
                std = self.smoothed.noise[name].white_std(self.planner.rate_hz)
                columns[name] = values + std * generator.standard_normal(len(values))
            elif name.startswith("velocity"):
                del columns[name]  # there was none to go by
        smoothed = smooth(replace(clean, columns=columns))
        seen = np.zeros(len(smoothed.time), dtype=bool)
        track = replace(self.planner.track, smoothed=smoothed, heldout=seen)
        if isinstance(track, DrivenTrack) and "load" in clean:
            track = replace(track, load=np.interp(smoothed.time, clean.time, clean["load"]))
        return [track] if self.pressed is None else [track, replace(self.pressed, smoothed=smoothed, heldout=seen)]

    def separation(self, tracks: Sequence[Track]) -> Separation:
        """How far apart tracks hold the two explanations that are hardest to tell apart.

        An explanation counts as a rival of one that has as many free numbers or more, as in a confidence set: a simpler
        truth is told from what contains it by being simpler.
        """
        pairs = [p for p in permutations(self.rivals, 2) if len(p[1].x) <= len(p[0].x)]
        return min((self._between(tracks, *pair) for pair in pairs), key=lambda s: s.margin)

    def _between(self, tracks: Sequence[Track], truth: Fitted, loser: Fitted) -> Separation:
        """What is left when one is fitted to what the other answers, without noise."""
        problem = Problem(tuple(_answering(track, truth) for track in tracks))
        at_start = problem.residual(loser.model, loser.skew)
        cost, samples = float(at_start @ at_start), problem.samples()
        penalty = (len(loser.x) - len(truth.x)) * math.log(samples)
        if cost + penalty > RULED_OUT:  # else a fit can only bring them closer still
            cost = problem.fit(loser.hypothesis, loser.x, steps=_STEPS).cost
        thinner = 1.0
        if self.smoothed.low_pass.is_identity:  # noise of the same density is less at a lower rate
            thinner = math.sqrt(tracks[0].smoothed.clock.rate_hz / self.smoothed.clock.rate_hz)
        return Separation(thinner * math.sqrt(cost / samples), cost + penalty)


def _with(recording: Recording, columns: Mapping[str, Array]) -> Recording:
    return replace(recording, columns={**recording.columns, **columns})


def _answering(track: Track, truth: Fitted) -> Track:
    """The track with the truth's answer in the place of what was measured."""
    output = track.smoothed.output.copy()
    output[:, track.column] = track.simulated(truth.model, truth.skew)
    return replace(track, smoothed=replace(track.smoothed, output=output))


def _in_words(rivals: Sequence[Fitted], best: TriedMotion | None, now: Separation, tried: Sequence[TriedMotion]) -> str:
    sets = dict.fromkeys(rival.hypothesis.names for rival in rivals)
    names = " and ".join(words(" with ".join(some) or "no effect") for some in sets)
    if best is None and now.settles:
        return (
            f"None of the {len(tried)} motions that were tried in simulation tells {names} apart better than this "
            f"recording, in which the wrong one leaves {now.noises:.2g} times the noise. Record it again, for longer."
        )
    if best is None:
        most = ""
        if tried and (left := tried[0].separation.noises) >= 0.001:  # below that the figure says nothing
            most = f" ({words(tried[0].plan.name)} comes closest, with {left:.2g} times the noise)"
        return (
            f"None of the {len(tried)} motions that were tried in simulation tells {names} apart: the wrong one "
            f"leaves too little beyond the noise{most}. Measure something else, or with less noise."
        )
    recording = best.plan.recording
    driven = recording.kind == "driven_body"
    file, length = (INPUT_FILE if driven else MOTION_FILE), recording.time[-1] - recording.time[0]
    what = "Apply the input" if driven else "Record the motion"
    what = "Give the controller the goals" if closed_loop(rivals[0].model) else what
    return (
        f"{what} in {file} ({best.plan.name}, {length:.0f} s: {best.plan.text}). In simulation, with the noise of this "
        f"recording, the wrong one of {names} then leaves {best.separation.noises:.2g} times the noise "
        f"({now.noises:.2g} now)."
    )
