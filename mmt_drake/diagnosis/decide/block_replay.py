"""Comparison of a block's recorded output with its replay: error, delay, and both in words."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from mmt_drake.analysis.nrmse import rms
from mmt_drake.analysis.signals import BAND_NAMES, BANDS, in_band
from mmt_drake.analysis.wording import milliseconds, significant
from mmt_drake.diagnosis.signals.lateness import lateness
from mmt_drake.numeric.arrays import Array, Flags

EXACT = 1e-6
"""Errors up to this are rounding: a signal that went through a file, a sum in another order."""
TIMES_NOISE = 1.5
"""An error up to so many times what noise leaves is noise."""

_IS_LATE, _HELPS = 0.1, 0.6  # of the error is left without the delay, at most: it is late; a delay helps
_RESOLUTION_S = 1e-4  # delays below are none
_FILTER_STARTS = 32  # samples at each end that a band filter begins with: one of noise there would count for seconds


@dataclass(frozen=True)
class BlockReplay:
    """How far one recorded output of one block is from what the block makes of its recorded inputs.

    Attributes:
        block: name of the block.
        output: the signal.
        nrmse: RMS of the difference over the standard deviation of the recorded signal, all its columns together
            (flags and theta: each column over its own, then the RMS of these); None where there is nothing to compare.
        delay_s: by which the recorded output is later than the replayed one [s]; None where none can be told.
        by_band: name of a band (`analysis.signals.BANDS`) -> RMS of the difference over that of the recorded signal in
            the band; empty for flags and theta.
        floor: nrmse that the noise of the sensors accounts for.
        differs: whether rounding and noise cannot account for the difference, over all or in one of the bands.
        note: what that means, in a sentence.
    """

    block: str
    output: str
    nrmse: float | None
    delay_s: float | None = None
    by_band: Mapping[str, float] = field(default_factory=dict)
    floor: float = 0.0
    differs: bool = False
    note: str = ""


def compared(
    block: str,
    output: str,
    recorded: Array,
    replayed: Array,
    noise: Array,
    counts: Flags,
    rate_hz: float,
    *,
    held: bool,
) -> BlockReplay:
    """Hold a replay against the recording.

    Args:
        block, output: names.
        recorded, replayed: (n, k); NaN where not known yet.
        noise: (n, k) what sensors may add to the difference: one such noise, as good as any other.
        counts: (n,) samples that enter the errors.
        rate_hz: samples per second.
        held: whether these are flags or parameters, which stand between messages and have no bands.
    """
    unknown = np.isnan(recorded).any(axis=1), np.isnan(replayed).any(axis=1)
    one_sided = counts & (unknown[0] != unknown[1])
    known = counts & ~unknown[0] & ~unknown[1]
    if one_sided.any():
        note = f"Known in one and not in the other in {_samples(one_sided)}."
        return BlockReplay(block, output, math.inf, differs=True, note=note)
    if not known.any():
        return BlockReplay(block, output, None, note="Not known at all.")
    scale = _scale(recorded[known], together=not held)
    nrmse, floor = (rms(v[known] / scale) for v in (recorded - replayed, noise))
    found = BlockReplay(block, output, nrmse, floor=floor, differs=nrmse > max(EXACT, TIMES_NOISE * floor))
    if held:
        wrong = np.count_nonzero((recorded != replayed)[known].any(axis=1))
        note = f"Off by {_three(nrmse)} of its spread, in {wrong} of {_samples(known)}."
        return replace(found, note=note if found.differs else _agreement(found))
    bands: dict[str, float] = {}
    beyond = found.differs
    # Only what counts is filtered, so that no error of another time is smeared into it.
    inside = known.copy()
    inside[:_FILTER_STARTS] = inside[-_FILTER_STARTS:] = False
    error, possible = (np.where(inside[:, np.newaxis], v, 0.0) for v in (recorded - replayed, noise))
    for name, edges in BANDS.items():
        there, off, chance = (_size(v, edges, rate_hz, known) for v in (recorded, error, possible))
        if there > 0.0:
            bands[name] = off / there
            beyond = beyond or off > max(EXACT * there, _times_noise(edges, rate_hz, known) * chance)
    found = replace(found, by_band=bands, differs=beyond)
    if not found.differs:
        return replace(found, delay_s=0.0, note=_agreement(found))
    delay = lateness(recorded, replayed, rate_hz)
    left = nrmse if delay is None else _left(recorded, replayed, delay * rate_hz, known, scale)
    return replace(found, delay_s=delay, note=_difference(found, delay, left))


def _times_noise(band: tuple[float, float] | None, rate_hz: float, known: Flags) -> float:
    """`TIMES_NOISE`, or more in a band so narrow that two noises of equal strength may look that different.

    Noise in a band of width B over a time T is worth 2 B T independent numbers, and its RMS scatters by one part in
    the square root of twice as many. Six times that does not happen.
    """
    if band is None:
        return TIMES_NOISE
    numbers = 2.0 * (band[1] - band[0]) * np.count_nonzero(known) / rate_hz
    return max(TIMES_NOISE, 1.0 + 6.0 / math.sqrt(2.0 * numbers))


def _scale(recorded: Array, *, together: bool) -> Array:
    """What the errors of the columns are relative to, (k,): the RMS of all their spreads, or each one's own."""
    spread = recorded.std(axis=0)
    if together:
        spread = np.full(len(spread), np.sqrt(np.mean(spread**2)))
    largest = np.abs(recorded).max(axis=0)
    return np.where(spread > 0.0, spread, np.where(largest > 0.0, largest, 1.0))


def _size(values: Array, band: tuple[float, float] | None, rate_hz: float, known: Flags) -> float:
    return float(np.linalg.norm(in_band(values, band, rate_hz)[known]))


def _left(recorded: Array, replayed: Array, steps: float, known: Flags, scale: Array) -> float:
    """The nrmse with the replay later by so many samples."""
    k = np.arange(len(replayed), dtype=np.float64)
    late = np.column_stack([np.interp(k - steps, k, values) for values in replayed.T])
    return float(np.sqrt(np.mean(np.mean((recorded - late)[known] ** 2, axis=0) / scale**2)))


def _samples(flags: Flags) -> str:
    count = np.count_nonzero(flags)
    return f"{count} sample{'' if count == 1 else 's'}"


def _agreement(found: BlockReplay) -> str:
    if found.nrmse == 0.0:
        return "The replay gives it again to the last bit."
    if found.nrmse is not None and found.nrmse <= EXACT:
        return "The replay gives it again to rounding."
    return f"Off by {_three(found.nrmse)} of its spread, which sensor noise accounts for."


def _difference(found: BlockReplay, delay: float | None, left: float) -> str:
    said = f"Off by {_three(found.nrmse)} of its spread"
    bands = {name: ratio for name, ratio in found.by_band.items() if name != "all"}
    worst = max(bands, key=bands.__getitem__, default=None)
    if worst is not None:
        said += f", by {_three(bands[worst])} of its size {'' if worst[0] == 'b' else 'at '}{BAND_NAMES[worst]}"
        if bands[worst] < found.by_band["all"]:
            said += " and more above"
    if delay is None or found.nrmse is None or abs(delay) < _RESOLUTION_S or left > _HELPS * found.nrmse:
        return f"{said}; no delay explains it."
    way, time = "late" if delay > 0.0 else "early", milliseconds(abs(delay))
    if left <= _IS_LATE * found.nrmse:
        return f"{said}; it is {time} {way}, and without that off by {_three(left)}."
    return f"{said}; most like the replay {time} {way}, and then off by {_three(left)}."


def _three(ratio: float | None) -> str:
    """A ratio, and not as percent, which is said of the error of a model alone."""
    return "an unknown part" if ratio is None else significant(ratio, 3)
