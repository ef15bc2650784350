"""Check of the clock and the sensors of a recording, channel by channel."""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from mmt_drake.diagnosis.checks.finding import Finding, Severity
from mmt_drake.diagnosis.signals.smoother import Smoothed
from mmt_drake.numeric.arrays import Array, Flags
from mmt_drake.recording import Recording

_Check = Callable[[str, Array, float], Finding | None]

_JITTER = 0.02  # of a step
_CLIPPED = 0.005  # share of samples at one extreme value, from which they are no chance
_PILE_UP = 4.0  # times as many as at the next two values; at the crest of a coarse sine there are 2.4 times as many
_MOSTLY = 0.5
_FROZEN_S = 0.25
_COARSE = 0.05  # quantisation step over the deviation of the signal
_REPEATED = 0.15
_FINE = 0.99  # share of distinct values between the extremes of a channel whose steps do not show
_SIGMAS = 5.0
_COLOURED_DB = 6.0
_TO_DEVIATION = 1.4826  # standard deviation over median magnitude, of Gaussian noise
_SPIKE, _ALONE, _FEWEST_SPIKES = 10.0, 3.0, 5  # times the usual; times as far as the samples beside it are apart
_SPEAKS = 3.0  # deviation of an output over that of the noise in it


def clock_findings(smoothed: Smoothed) -> list[Finding]:
    """Rate, jitter and gaps."""
    clock = smoothed.clock
    seconds = clock.step * clock.count
    figures = {"rate_hz": clock.rate_hz, "jitter": clock.jitter, "gaps": float(len(clock.gaps)), "seconds": seconds}
    findings = []
    if len(clock.gaps):
        lost = float(np.diff(clock.gaps, axis=1).sum())
        begin, end = clock.gaps[np.argmax(np.diff(clock.gaps, axis=1))]
        longest = f"the longest gap from {begin:.3f} to {end:.3f} s"
        text = f"No samples for {lost:.3g} s in all, {longest}; nothing is compared there."
        of_gaps = {"gaps": float(len(clock.gaps)), "lost_s": lost, "longest_s": float(end - begin)}
        findings.append(Finding("gaps", "refuse" if lost > _MOSTLY * seconds else "warn", text, of_gaps))
    if clock.is_even or clock.jitter < _JITTER:
        text = f"{clock.rate_hz:.5g} samples/s on an even clock."
    else:
        figures["resampling_error"] = float(smoothed.resampling_error.max())
        text = (
            f"{clock.rate_hz:.5g} samples/s, steps varying by {100 * clock.jitter:.1f} %: resampled to an even clock "
            f"by a spline, off by {figures['resampling_error']:.2g} at most for motion up to the top frequency."
        )
    findings.append(Finding("clock", "note", text, figures))
    return findings


def channel_findings(recording: Recording, columns: Mapping[str, bool], used: Flags) -> list[Finding]:
    """Clipped, frozen, coarse or repeated samples of the measured outputs.

    Args:
        recording: as read.
        columns: outputs to look at, and whether a diagnosis stands on them: on those of the axes that count it does,
            without the normal force it can do.
        used: (n,) samples of the recording that count.
    """
    step = float(np.median(np.diff(recording.time)))
    findings = []
    for name, needed in columns.items():
        values = recording[name][used]
        if len(values) < 3 or np.ptp(values) == 0.0:
            if len(values) >= 3:
                text = f"{name} reads {values[0]:g} throughout: is the sensor connected?"
                findings.append(Finding("stuck", "refuse" if needed else "warn", text, {"value": float(values[0])}))
            continue
        # A body may well stand still, most of all at the ends of its way; a force that does is suspicious, and so is
        # a position without noise there if it has some elsewhere.
        checks: tuple[_Check, ...] = (coarseness, spikes)
        if name.startswith("force"):
            checks = (clipping, freezing, *checks)
        elif _is_fine(values):
            checks = (clipping, *checks)
        for check in checks:
            finding = check(name, values, step)
            if finding is not None:
                bearable = finding.severity == "refuse" and not needed
                findings.append(replace(finding, severity="warn") if bearable else finding)
    return findings


def _is_fine(values: Array) -> bool:
    """Whether values between the extremes are (nearly) all different, as those of a noisy sensor are."""
    inner = values[(values > values.min()) & (values < values.max())]
    return len(np.unique(inner)) > _FINE * len(inner)


def clipped(values: Array) -> Flags:
    """Samples (n,) that pile up at an extreme value, more of them than at the values next to it.

    A sensor that is coarse has piles everywhere, and the largest where a wave turns.
    """
    flags = np.zeros(len(values), dtype=np.bool_)
    for extreme in (values.max(), values.min()):
        distance = np.abs(values - extreme)
        at = distance == 0.0
        if at.all():
            return at
        if at.mean() <= _CLIPPED:
            continue
        beside = distance[~at & (distance <= 2.5 * float(distance[~at].min()))]
        if at.sum() > _PILE_UP * len(beside) / len(np.unique(beside)):
            flags |= at
    return flags


def clipping(name: str, values: Array, step: float) -> Finding | None:
    """Samples that are `clipped`."""
    flags = clipped(values)
    if not flags.any():
        return None
    share, limits = float(flags.mean()), np.unique(values[flags])[::-1]
    where = " and ".join(f"{limit:.4g}" for limit in limits)
    text = f"{name} stands at exactly {where} in {100 * share:.1f} % of the samples: the sensor, or a limit, clips it."
    figures = {"share": share, "limit": float(np.abs(limits).max())}
    return Finding("saturation", "refuse" if share > _MOSTLY else "warn", text, figures)


def freezing(name: str, values: Array, step: float) -> Finding | None:
    """A long run of exactly equal samples that are no extreme, in a channel that is not so elsewhere."""
    edges = np.concatenate([[0], np.flatnonzero(np.diff(values) != 0.0) + 1, [len(values)]])
    runs = np.diff(edges)
    inner = (values[edges[:-1]] != values.max()) & (values[edges[:-1]] != values.min())
    usual = float(np.median(runs[runs > 0]))
    long = inner & (runs * step >= _FROZEN_S) & (runs > 20.0 * usual)
    if not long.any():
        return None
    frozen, share = float(runs[long].sum() * step), float(runs[long].sum() / len(values))
    longest = f"{runs[long].max() * step:.2f} s at the longest"
    text = f"{name} does not change for {frozen:.2f} s in all, {longest}: did the sensor drop out?"
    return Finding("frozen", "refuse" if share > _MOSTLY else "warn", text, {"seconds": frozen, "share": share})


def coarseness(name: str, values: Array, step: float) -> Finding | None:
    """Values on a grid that is coarse for the signal, or samples that repeat the one before."""
    levels = np.unique(values)
    spread = float(np.std(values))
    if len(levels) < len(values) / 4:
        grid = float(np.diff(levels).min())
        multiples = np.diff(levels) / grid
        if np.abs(multiples - np.round(multiples)).max() < 0.02 and grid > 0.2 * _COARSE * spread:
            text = f"{name} comes in steps of {grid:.3g}, {100 * grid / spread:.1f} % of its deviation."
            severity: Severity = "warn" if grid > _COARSE * spread else "note"
            return Finding("quantised", severity, text, {"step": grid, "share": grid / spread})
    repeated = float(np.mean(np.diff(values) == 0.0))
    if repeated > _REPEATED and len(levels) > len(values) / 4:
        text = f"{100 * repeated:.0f} % of the samples of {name} repeat the last one: its sensor is slow."
        return Finding("repeated", "note", text, {"share": repeated})
    return None


def spikes(name: str, values: Array, step: float) -> Finding | None:
    """Single samples far off both beside them, which are alike: no motion and no noise of a sensor does that."""
    off = np.abs(values[1:-1] - 0.5 * (values[:-2] + values[2:]))
    usual = _TO_DEVIATION * float(np.median(off))
    alone = (off > _SPIKE * usual) & (off > _ALONE * np.abs(values[2:] - values[:-2]))
    if usual == 0.0 or np.count_nonzero(alone) < _FEWEST_SPIKES:
        return None
    count, share = int(np.count_nonzero(alone)), float(np.mean(alone))
    most = f"by up to {off[alone].max():.3g}, where {usual:.2g} is usual"
    text = (
        f"{count} samples of {name} stand alone {most}: impacts, or spikes of the sensor. They count as noise; leave "
        "the rows of spikes out."
    )
    return Finding("spikes", "warn", text, {"count": float(count), "share": share, "largest": float(off[alone].max())})


def bias_findings(smoothed: Smoothed, names: tuple[str, ...]) -> list[Finding]:
    """The force sensor's offset, and what hums, in free space, where there is any."""
    rest = smoothed.rest
    if rest is None:
        return []
    figures = {"seconds": rest.seconds}
    for i, name in enumerate(names):
        figures |= {name: float(rest.mean[i]), f"{name}_se": float(rest.standard_error[i])}
    off = [i for i in range(len(names)) if abs(rest.mean[i]) > max(_SIGMAS * rest.standard_error[i], rest.noise[i].std)]
    shown = ", ".join(f"{names[i]} {rest.mean[i]:.3g} +- {rest.standard_error[i]:.1g} N" for i in off)
    text = f"In free space ({rest.seconds:.1f} s) " + (
        f"the sensor is off zero: {shown}. Tare it, or take that off."
        if off
        else "the sensor reads zero to within its noise."
    )
    findings = [Finding("bias", "warn" if off else "note", text, figures)]
    for name, hum in zip(names, rest.hum, strict=True):
        if hum is not None:
            text = (
                f"{name} hums at {hum.frequency:.2f} Hz with {hum.amplitude:.3g} N in free space; the noise is told "
                "without it."
            )
            findings.append(Finding("hum", "warn", text, {"frequency": hum.frequency, "amplitude": hum.amplitude}))
    return findings


def drowned(smoothed: Smoothed, names: tuple[str, ...], columns: tuple[str, ...]) -> dict[str, tuple[float, float]]:
    """Outputs that do not stand out of their noise in contact: their deviation there, and that of the noise in them.

    Args:
        smoothed: the recording.
        names: every output column, as in `smoothed.output`.
        columns: those that count.
    """
    found = {}
    for name in columns:
        i = names.index(name)
        left = float(smoothed.output_noise[i])
        signal = float(np.std(smoothed.output[smoothed.in_contact, i])) if smoothed.in_contact.any() else 0.0
        if signal < _SPEAKS * left:
            found[name] = signal, left
    return found


def noise_findings(
    smoothed: Smoothed, names: tuple[str, ...], columns: tuple[str, ...], without: Mapping[str, tuple[float, float]]
) -> list[Finding]:
    """Noise floors, their colour, and outputs that do not stand out of them.

    Nothing can be said where no output stands out; else those that do not are left out.

    Args:
        smoothed, names, columns: as of `drowned`.
        without: what that found.
    """
    figures = {name: noise.std for name, noise in smoothed.noise.items()}
    outputs = [smoothed.noise[name] for name in names]
    said = ", ".join(f"{name} {smoothed.noise[name].std:.3g}" for name in columns)
    findings = [Finding("noise", "note", f"Noise ({outputs[0].source}): {said}.", figures)]
    for name, (signal, left) in without.items():
        severity: Severity = "refuse" if len(without) == len(columns) else "warn"
        then = "nothing can be told from it" if severity == "refuse" else "it is left out"
        text = f"{name} varies by {signal:.3g} while its noise is {left:.3g} in the same band: {then}."
        findings.append(Finding("noisy", severity, text, {"signal": signal, "noise": left}))
    for name in columns:
        noise, colour = smoothed.noise[name], smoothed.noise[name].colour_db
        if noise.source == "free space" and colour is not None and abs(colour) > _COLOURED_DB:
            text = (
                f"The noise of {name} has {abs(colour):.0f} dB {'more' if colour > 0.0 else 'less'} density in the "
                "band of the motion than above it: it is filtered, or something hums."
            )
            findings.append(Finding("coloured_noise", "warn", text, {"colour_db": colour}))
    return findings
