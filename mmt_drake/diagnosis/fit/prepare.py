"""From recordings and a model to a problem that can be fitted."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import find_peaks, lombscargle

from mmt_drake.analysis.nrmse import rms
from mmt_drake.diagnosis.checks.excitation import motion_of
from mmt_drake.diagnosis.checks.finding import Finding
from mmt_drake.diagnosis.checks.preflight import Preflight, preflight
from mmt_drake.diagnosis.checks.sensors import clipped
from mmt_drake.diagnosis.fit.box_tracks import NORMAL_COLUMN, BoxTrack, NormalTrack
from mmt_drake.diagnosis.fit.floors import with_floors
from mmt_drake.diagnosis.fit.problem import MOST_SKEW_S, Problem, split
from mmt_drake.diagnosis.fit.surface_track import SurfaceTrack
from mmt_drake.diagnosis.fit.tracks import DrivenTrack, SpringTrack, Track
from mmt_drake.diagnosis.fit.window_length import window_length
from mmt_drake.diagnosis.signals.clocks import near
from mmt_drake.diagnosis.signals.smoother import Smoothed, smooth
from mmt_drake.diagnosis.signals.touches import raw_flags
from mmt_drake.effects.effect import Scales
from mmt_drake.model.driven_model import DrivenBodyModel
from mmt_drake.model.kelvin_voigt import KelvinVoigt
from mmt_drake.model.structure import Initial, PositionOut, Structure
from mmt_drake.model.surface_contact import SurfaceContact
from mmt_drake.model_files import Model
from mmt_drake.numeric.arrays import Array, Flags
from mmt_drake.over import conditions
from mmt_drake.recording import Recording
from mmt_drake.replay import towards_goal
from mmt_drake.windows import blocks_of, held_blocks, in_blocks, sets_out

FINE_RATE_HZ, DRIVEN_RATE_HZ = 500.0, 1000.0
_PEAKS = 4
_CYCLES = np.arange(2.0, 60.0, 0.25)  # of a ripple within the way
_RIPPLE_SAMPLES = 4000
_LEAST_SAMPLES = 250  # for the normal axis: a second


@dataclass(frozen=True)
class Prepared:
    """Recordings made ready.

    Attributes:
        preflights: what the check of each recording saw.
        problem: what can be fitted; None where a recording was refused.
        fine: the same on a clock fast enough for forces that jump, for what is said in the end.
        skew: the largest skew of clocks that is left open [s].
        window_s: length of the windows over which every model is simulated [s]; None: the whole recordings.
        initial: how every driven body begins those.
        left_out: what the check saw of recordings that were too short, where others were not.
    """

    preflights: tuple[Preflight, ...]
    problem: Problem | None
    fine: Problem | None
    skew: float
    window_s: float | None = None
    initial: Initial = "rest"
    left_out: tuple[Preflight, ...] = ()

    @property
    def recordings(self) -> tuple[Recording, ...]:
        """As they were checked."""
        return tuple(check.recording for check in self.preflights)

    @property
    def reason(self) -> str | None:
        """Why nothing can be said, and of which recording where there are several; None if something can."""
        return " ".join(finding.text for finding in self.findings if finding.severity == "refuse") or None

    @property
    def refusal(self) -> str:
        """Why nothing could be fitted, where that is so."""
        return self.reason or "Nothing in these recordings moves."

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What the checks saw, recording by recording; where there are several each finding says of which it is."""
        several = len(self.preflights) + len(self.left_out) > 1
        found = tuple(
            replace(finding, text=f"{check.recording.source}: {finding.text}") if several else finding
            for check in self.preflights
            for finding in check.findings
        )
        return found + tuple(
            replace(finding, severity="warn", text=f"{check.recording.source} is left out: {finding.text}")
            for check in self.left_out
            for finding in check.findings
            if finding.severity == "refuse"
        )


def prepare(recordings: Sequence[Recording], model: Model) -> Prepared:
    """Check, smooth and split recordings; those that are too short are left out where others are not.

    Raises:
        BadInput: a recording that a model of this structure cannot be held against.
    """
    even = replace(model, over=())  # orders of magnitude do not depend on conditions
    checks = tuple(preflight(towards_goal(model, recording), even) for recording in recordings)
    long_enough = tuple(check for check in checks if not check.is_too_short)
    left_out = tuple(check for check in checks if check.is_too_short) if long_enough else ()
    checks = long_enough or checks
    tracks: list[Track] = []
    fine: list[Track] = []
    window_s, initial = model.window_s, model.initial
    # Without a mass there is no velocity to begin with.
    inert = isinstance(model, PositionOut) and model.value("m") > 0.0
    if inert and any(sets_out(check.recording.time, check.recording["output"]) for check in checks):
        initial = "fitted"
    if window_s is None and isinstance(even, DrivenBodyModel) and all(check.reason is None for check in checks):
        window_s = None if even.controller else window_length(checks, even)  # a closed loop holds its body
    for check in checks:
        recording, smoothed = check.recording, check.smoothed
        if check.reason is None:
            heldout = split(smoothed)
            # A driven body answers to its input without a damper between: linear pieces of that must be short.
            driven = isinstance(model, PositionOut)
            rates = (FINE_RATE_HZ, DRIVEN_RATE_HZ) if driven else (None, FINE_RATE_HZ)
            for found, rate in zip((tracks, fine), rates, strict=True):
                finer = smoothed if rate is None else smooth(recording, rate_hz=rate, columns=check.columns)
                finer = _as_far_as_known(recording, finer)
                same = np.interp(finer.time, smoothed.time, heldout.astype(np.float64)) > 0.5
                columns = [*check.outputs, *([NORMAL_COLUMN] if smoothed.kind == "contact" else [])]
                if isinstance(model, SurfaceContact):
                    columns = [0, 1, NORMAL_COLUMN]  # a slope pushes where nothing moves
                own = (_track(model, recording, finer, column, same, window_s, initial) for column in columns)
                found += [track for track in own if not isinstance(track, NormalTrack) or _presses(track)]
    if not tracks or any(check.reason is not None for check in checks):
        return Prepared(checks, None, None, 0.0, left_out=left_out)
    skew = min(MOST_SKEW_S, min(track.smoothed.clock.step for track in tracks))
    if isinstance(model, DrivenBodyModel) and model.controller is not None:
        skew = 0.0  # a goal is set, not read; and to be late is what a loop does
    problem, finer_problem = (Problem(with_floors(some, model)) for some in (tracks, fine))
    return Prepared(checks, problem, finer_problem, skew, window_s, initial, left_out)


def _as_far_as_known(recording: Recording, smoothed: Smoothed) -> Smoothed:
    """The recording with NaN for the normal force of a contact where its sensor is clipped, as far as filters reach."""
    if smoothed.kind != "contact":
        return smoothed
    touching = raw_flags(recording, smoothed.noise)
    at_limit = recording.time[touching][clipped(recording["force_z"][touching])]
    output = smoothed.output.copy()
    output[near(smoothed.time, at_limit, smoothed.low_pass.half_length_s), 2] = np.nan
    return replace(smoothed, output=output)


def _track(
    model: Structure,
    recording: Recording,
    smoothed: Smoothed,
    column: int,
    heldout: Flags,
    window_s: float | None,
    initial: Initial,
) -> Track:
    beside: dict[str, Array | float | str] = {
        name: np.interp(smoothed.time, recording.time, values) if isinstance(values, np.ndarray) else values
        for name, values in conditions(model, recording).items()
    }
    if isinstance(model, PositionOut):
        load = np.zeros(0)
        if "load" in recording:
            load = np.interp(smoothed.time, recording.time, recording["load"])
        if window_s is not None:
            heldout = in_blocks(smoothed.time, held_blocks(blocks_of(recording.time, window_s)))
        return DrivenTrack(smoothed, column, heldout, beside=beside, window_s=window_s, initial=initial, load=load)
    if isinstance(model, SurfaceContact):
        return SurfaceTrack(smoothed, column, heldout, beside=beside)
    if isinstance(model, KelvinVoigt):
        return SpringTrack(smoothed, column, heldout, beside=beside)
    kind = NormalTrack if smoothed.kind == "contact" and column == NORMAL_COLUMN else BoxTrack
    return kind(smoothed, column, heldout, beside=beside)


def _presses(track: NormalTrack) -> bool:
    """Whether a normal axis says anything: the probe moves up and down in contact, and its force was recorded."""
    s = track.smoothed
    used = (track.weight > 0.0) & s.in_contact & ~track.heldout
    if np.count_nonzero(used) < _LEAST_SAMPLES or np.ptp(track.measured[used]) == 0.0:
        return False
    noise, top = (float(s.input_noise[NORMAL_COLUMN]), float(s.input_rate_noise[NORMAL_COLUMN])), float(s.top_hz[2])
    return motion_of(s.input[used, NORMAL_COLUMN], s.input_rate[used, NORMAL_COLUMN], noise, top).moves


def scales_of(problem: Problem, model: Structure) -> Scales:
    """How large things are, of the track along the surface that moves most."""
    along = [track for track in problem.tracks if not isinstance(track, NormalTrack)]
    track = max(along, key=lambda t: float(np.std(t.measured[t.weight > 0.0])) / t.floor)
    s, used = track.smoothed, track.weight > 0.0
    _, states = track.replay(model)
    driven = isinstance(model, PositionOut)
    moving = track.measured if driven else s.input[:, track.column]
    rate = np.gradient(moving, track.time) if driven else s.input_rate[:, track.column]
    acceleration = np.gradient(rate, track.time)

    def spread(values: Array) -> float:
        return float(np.std(values[used]))

    mass, stiffness = model.value("m"), model.value("k2")
    force, left = rms(track.measured[used]), track.residual(model)
    u = s.input[:, 0]
    if isinstance(model, PositionOut):
        u, damping = model.commanded(track.time, u, moving, rate), model.value("b")
        left = model.resisting(u, moving, acceleration) - damping * rate
        force = max(rms(mass * acceleration[used]), rms(model.driving(u, moving)[used]), damping * rms(rate[used]))
        stiffness = max(stiffness, force / max(spread(moving), 1e-300))
    elif isinstance(model, KelvinVoigt):
        stiffness = max(stiffness, spread(track.measured) / max(spread(moving), 1e-300))
    return Scales(
        force=force,
        velocity=max(rms(states["sliding_velocity"][used]), 0.1 * rms(rate[used])),
        position=max(spread(states["position"]), 0.1 * spread(moving)),
        deflection=max(spread(states["deflection"]), 1e-3 * spread(moving)),
        load=float(np.mean(states["load"][used])) if "load" in states else 0.0,
        mass=mass if mass > 0.0 else force / max(rms(acceleration[used]), 1e-300),
        stiffness=stiffness,
        frequency=max(float(s.top_hz[track.column]), 1.0 / track.duration),
        duration=track.duration,
        step=s.clock.step,
        peaks=_peaks(track, model),
        input=rms(u[used]),
        normal=next((_along_normal(t, model) for t in problem.tracks if isinstance(t, NormalTrack)), None),
        ripples=_ripples((moving if driven else states["position"])[used], left[used]),
        peak_force=float(np.max(np.abs(track.measured[used]))),
    )


def _along_normal(track: NormalTrack, model: Structure) -> Scales:
    """How large things are along the surface normal, in contact."""
    s = track.smoothed
    used = (track.weight > 0.0) & s.in_contact
    force, depth, rate = track.measured[used], s.input[used, NORMAL_COLUMN], s.input_rate[used, NORMAL_COLUMN]
    force_rms, depth_rms, rate_rms = map(rms, (force, depth, rate))
    return Scales(
        force=force_rms,
        velocity=rate_rms,
        position=depth_rms,
        deflection=depth_rms,
        load=float(np.mean(force)),
        mass=0.0,
        stiffness=max(model.value("normal_k"), force_rms / depth_rms),
        frequency=max(float(s.top_hz[NORMAL_COLUMN]), 1.0 / track.duration),
        duration=track.duration,
        step=s.clock.step,
        peak_force=float(np.max(np.abs(force))),
    )


def _ripples(way: Array, left: Array) -> tuple[float, ...]:
    """Lengths of the way (n,) [m] over which what is left of the force (n,) comes back, strongest first."""
    every = -(-len(way) // _RIPPLE_SAMPLES)
    travel = float(np.ptp(way))
    if travel == 0.0:
        return ()
    slow = np.polynomial.Polynomial.fit(way, left, 3)(way)  # springs and weights are no ripple
    power = lombscargle(way[::every], (left - slow)[::every], 2.0 * np.pi * _CYCLES / travel)
    tops, _ = find_peaks(power)
    return tuple(float(travel / cycles) for cycles in _CYCLES[tops[np.argsort(power[tops])[::-1]]][:_PEAKS])


def _peaks(track: Track, model: Structure) -> tuple[float, ...]:
    """Frequencies [Hz] of a hum in free space, and at which what a model leaves is loudest."""
    rate, residual = track.smoothed.rate_hz, track.residual(model)
    padded = 4 * len(residual)
    power = np.abs(np.fft.rfft(residual * np.hanning(len(residual)), padded)) ** 2
    frequency = np.fft.rfftfreq(padded, 1.0 / rate)
    tops, _ = find_peaks(np.where(frequency > 2.0 * rate / len(residual), power, 0.0), distance=8)
    loudest = tops[np.argsort(power[tops])[::-1][:_PEAKS]]
    rest = track.smoothed.rest
    hums = [] if rest is None else [hum.frequency for hum in rest.hum if hum is not None]
    return (*hums, *(float(f) for f in frequency[loudest]))
