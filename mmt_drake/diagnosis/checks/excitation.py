"""Check that a recording moves enough, and in enough ways, to say anything."""

from dataclasses import dataclass, replace

import numpy as np

from mmt_drake.analysis.nrmse import rms
from mmt_drake.diagnosis.checks.finding import Finding
from mmt_drake.diagnosis.signals.smoother import Smoothed
from mmt_drake.numeric.arrays import Array

_STANDS_OUT = 10.0  # deviation of a position over what is left of its noise
_ROUNDING = 1e-12  # of where it is: a position that does not change is smoothed to as much
_LIVELY = 0.02  # of the liveliest axis
_ONE_SIDED = 0.02
_FEW_REVERSALS = 4
_LEAST_S = {"contact": 1.0, "single_axis": 0.5, "driven_body": 0.0}
_LEAST_SAMPLES = {"contact": 200, "single_axis": 100, "driven_body": 20}
_LEAST_COMPARED = 0.25  # of these: what is left of contact beside touches, releases, gaps and ends
_SHORT_S = 5.0


@dataclass(frozen=True)
class AxisMotion:
    """How one axis moves while it counts: in contact, or the output of a driven body.

    Attributes:
        amplitude: half of what lies between the extremes [m].
        speed: RMS of the rate [m/s].
        top_hz: below which 99 % of the rate's power lies.
        reversals: changes of direction.
        forward: share of the moving time in which the rate is positive.
        dwell: share of the time in which it does not move.
        moves: whether the axis counts.
    """

    amplitude: float
    speed: float
    top_hz: float
    reversals: int
    forward: float
    dwell: float
    moves: bool

    @property
    def is_one_sided(self) -> bool:
        """Whether it goes one way (almost) all of the time that it moves."""
        return not _ONE_SIDED <= self.forward <= 1.0 - _ONE_SIDED

    def figures(self) -> dict[str, float]:
        """Its numbers by name."""
        return {name: float(value) for name, value in vars(self).items() if name != "moves"}


def motion_of(position: Array, rate: Array, noise: tuple[float, float], top_hz: float) -> AxisMotion:
    """The motion of one axis (n,), given the noise that is left of position and rate.

    Slower than five times the noise of the rate, or than 5 % of its RMS, counts as standing still.
    """
    speed = rms(rate)
    threshold = max(5.0 * noise[1], 0.05 * speed)
    moving = np.abs(rate) > threshold
    signs, rounding = np.sign(rate[moving]), _ROUNDING * float(np.abs(position).max())
    return AxisMotion(
        amplitude=0.5 * float(np.ptp(position)),
        speed=speed,
        top_hz=top_hz,
        reversals=int(np.count_nonzero(np.diff(signs))),
        forward=float(np.mean(signs > 0.0)) if len(signs) else 0.5,
        dwell=float(1.0 - moving.mean()),
        moves=bool(np.std(position) > max(_STANDS_OUT * noise[0], rounding) and moving.any()),
    )


def motions(smoothed: Smoothed) -> tuple[AxisMotion, ...]:
    """The motion of each tangential axis, of the one axis, or of a driven body's output, where it counts."""
    counts = smoothed.in_contact
    if not counts.any():
        return ()
    if smoothed.kind == "driven_body":
        rate = np.gradient(smoothed.output, 1.0 / smoothed.rate_hz, axis=0)
        noise = (float(smoothed.output_noise[0]), float(smoothed.output_noise[0]) * smoothed.rate_hz / np.sqrt(2.0))
        return (motion_of(smoothed.output[:, 0], rate[:, 0], noise, float(smoothed.top_hz[0])),)
    axes = range(2) if smoothed.kind == "contact" else range(1)
    found = [
        motion_of(
            smoothed.input[counts, i],
            smoothed.input_rate[counts, i],
            (float(smoothed.input_noise[i]), float(smoothed.input_rate_noise[i])),
            float(smoothed.top_hz[i]),
        )
        for i in axes
    ]
    liveliest = max(motion.amplitude for motion in found)
    return tuple(
        motion if motion.amplitude >= _LIVELY * liveliest else replace(motion, moves=False) for motion in found
    )


def excitation_findings(smoothed: Smoothed, moved: tuple[AxisMotion, ...], names: tuple[str, ...]) -> list[Finding]:
    """Contact, length, motion, its directions and the load.

    Args:
        smoothed: the recording.
        moved: of each axis (`motions`).
        names: of those axes, for the text.
    """
    kind, counts = smoothed.kind, smoothed.in_contact
    if not counts.any():
        lowest = float(smoothed.input[:, 2].min()) if kind == "contact" else 0.0
        text = (
            f"The probe never touches the object: its lowest point is z = {1e3 * lowest:.2f} mm, and contact is z < 0."
            if lowest > 0.0
            else "The probe never touches the object: in_contact is 0 throughout."
        )
        return [Finding("no_contact", "refuse", text, {"lowest_z": lowest})]
    findings = [_contact(smoothed)] if kind == "contact" else []
    seconds = float(counts.sum() / smoothed.rate_hz)
    samples = round(seconds * smoothed.clock.rate_hz)
    figures = {"seconds": seconds, "samples": float(samples)}
    if seconds < _LEAST_S[kind] or samples < _LEAST_SAMPLES[kind]:
        text = (
            f"Too short: {seconds:.2f} s and {samples} samples count, "
            f"{max(_LEAST_S[kind], 0.1):g} s and {_LEAST_SAMPLES[kind]} samples are the least."
        )
        return [*findings, Finding("too_short", "refuse", text, figures)]
    compared = float(np.count_nonzero(counts & (smoothed.weight > 0.0)) / smoothed.rate_hz)
    if compared < _LEAST_COMPARED * max(_LEAST_S[kind], _LEAST_SAMPLES[kind] / smoothed.clock.rate_hz):
        text = (
            f"Only {compared:.2f} s can be compared: contacts are so short, or the clock has so many gaps, that the "
            f"filter, whose band is {smoothed.low_pass.band_hz:.3g} Hz, sees a touch, a release or a gap all along."
        )
        return [*findings, Finding("too_short", "refuse", text, figures | {"compared": compared})]
    if seconds < _SHORT_S:
        text = f"Only {seconds:.1f} s count: held-out blocks are short and intervals wide."
        findings.append(Finding("short", "warn", text, figures))
    if not any(motion.moves for motion in moved):
        where = "while in contact" if kind == "contact" else "throughout"
        text = f"Nothing moves: {' and '.join(names)} stay within noise {where}."
        widest = max(motion.amplitude for motion in moved)
        return [*findings, Finding("motionless", "refuse", text, {"amplitude": widest})]
    counting = [(name, motion) for name, motion in zip(names, moved, strict=True) if motion.moves]
    both_ways = any(not motion.is_one_sided for _, motion in counting)
    for name, motion in counting:
        findings += _direction(name, motion, kind, both_ways)
    return findings


def _contact(smoothed: Smoothed) -> Finding:
    counts = smoothed.in_contact
    load = np.maximum(smoothed.output[counts, 2], 0.0)
    mean, deviation = float(load.mean()), float(load.std())
    figures = {
        "share": float(counts.mean()),
        "seconds": float(counts.sum() / smoothed.rate_hz),
        "touches": float(len(smoothed.contact.touches)),
        "load_mean": mean,
        "load_std": deviation,
    }
    text = (
        f"In contact {figures['seconds']:.1f} s ({100 * counts.mean():.0f} %), "
        f"{len(smoothed.contact.touches)} touches; load {mean:.2f} N on average, varying by {deviation:.2f} N."
    )
    return Finding("contact", "note", text, figures)


def _direction(name: str, motion: AxisMotion, kind: str, both_ways: bool) -> list[Finding]:
    """What is to say about one axis that moves; `both_ways`: whether another one, or this, moves to and fro."""
    if motion.is_one_sided and kind != "driven_body":
        text = (
            f"{name} moves toward {'+' if motion.forward > 0.5 else '-'} alone: an offset, friction and a force that "
            "depends on direction look the same there; stroke both ways."
        )
        return [
            Finding("one_sided", "warn" if both_ways or kind == "single_axis" else "refuse", text, motion.figures())
        ]
    unit = "" if kind == "driven_body" else " m"
    text = (
        f"{name} moves by +-{motion.amplitude:.3g}{unit}, at {motion.speed:.3g}{unit}/s RMS and up to "
        f"{motion.top_hz:.2g} Hz, with {motion.reversals} reversals, and stands still {100 * motion.dwell:.0f} % of "
        "the time."
    )
    findings = [Finding("excitation", "note", text, motion.figures())]
    if motion.reversals < _FEW_REVERSALS:
        text = (
            f"{name} changes direction only {motion.reversals} times: what depends on direction is hard to tell apart."
        )
        findings.append(Finding("few_reversals", "warn", text, {"reversals": float(motion.reversals)}))
    return findings
