"""Location of a mismatch: when, in which band, at which states, in which block."""

from collections.abc import Sequence

import numpy as np
from scipy import signal

from mmt_drake.diagnosis.decide import attribution
from mmt_drake.diagnosis.decide.mismatch import BlockShare, Dependence, Mismatch
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.diagnosis.fit.tracks import STATES, Track
from mmt_drake.diagnosis.search.learn import Learned
from mmt_drake.numeric.arrays import Array

_WINDOW_S = 0.5
_LOUD = 2.0
_BINS = 16
_BAND_SHARE = 0.9
_TIME = ("t", "time", "s")


def locate(
    problem: Problem, refit: Fitted, ranked: Sequence[Fitted], named: Fitted | None, tables: Sequence[Learned] = ()
) -> Mismatch:
    """Where the mismatch of the refitted model is.

    Args:
        problem: with the recordings.
        refit: the fit without effects.
        ranked: the candidates, best first.
        named: the one that is believed, if any.
        tables: learned where none is.
    """
    loudest = max(problem.tracks, key=lambda t: float(np.sum(t.residual(refit.model, refit.skew) ** 2)) / t.floor**2)
    return Mismatch(
        blocks=_blocks(problem, refit, ranked, named, tables),
        intervals_s=_intervals(problem, refit),
        band_hz=_band(loudest, loudest.residual(refit.model, refit.skew)),
        depends_on=_dependences(loudest, refit),
        axes=_axes(problem, refit),
    )


def _axes(problem: Problem, refit: Fitted) -> dict[str, float]:
    """Shares of the axes in what the fit leaves beyond the noise, each over its own; none of one axis alone."""
    ratios = problem.ratios(problem.residual(refit.model, refit.skew))
    beyond = {axis: max(ratio**2 - 1.0, 0.0) for axis, ratio in ratios.items()}
    total = sum(beyond.values())
    if len(beyond) < 2 or total == 0.0:
        return {}
    return {axis: part / total for axis, part in sorted(beyond.items(), key=lambda one: -one[1])}


def _blocks(
    problem: Problem, refit: Fitted, ranked: Sequence[Fitted], named: Fitted | None, tables: Sequence[Learned]
) -> tuple[BlockShare, ...]:
    """Shares of the blocks: how much each named effect takes off the misfit alone; else `attribution.shares`."""
    singles = [c for c in ranked if len(c.hypothesis.names) == 1]
    if named is None:
        found = attribution.shares(problem, refit, singles, tables) if singles or tables else {}
        return tuple(BlockShare(block, share) for block, share in found.items())
    alone = {c.hypothesis.names[0]: refit.cost - c.cost for c in singles}
    gains: dict[str, float] = {}
    for effect in named.hypothesis.effects:
        gain = max(alone.get(effect.name, 0.0), 1e-3 * refit.cost)
        gains[effect.block] = gains.get(effect.block, 0.0) + gain
    total = sum(gains.values())
    return tuple(sorted((BlockShare(block, gain / total) for block, gain in gains.items()), key=lambda s: -s.share))


def _intervals(problem: Problem, refit: Fitted) -> tuple[tuple[float, float], ...]:
    """Windows in which the residual stands out of its noise and of its own level, joined where they touch [s]."""
    windows: list[tuple[float, float]] = []
    track = problem.tracks[0]
    start = track.time[0]
    count = max(1, int((track.time[-1] - start) / _WINDOW_S))
    which = np.minimum(((track.time - start) / _WINDOW_S).astype(int), count - 1)
    level = np.zeros(count)
    for other in problem.tracks:
        if other.smoothed is track.smoothed:
            r = other.residual(refit.model, refit.skew) / other.floor
            level += np.bincount(which, r**2, count) / np.maximum(np.bincount(which, other.weight, count), 1.0)
    loud = level > max(_LOUD**2, float(np.mean(level)))
    for k in np.flatnonzero(loud):
        low, high = start + k * _WINDOW_S, min(start + (k + 1) * _WINDOW_S, float(track.time[-1]))
        if windows and abs(windows[-1][1] - low) < 1e-9:
            low = windows.pop()[0]
        windows.append((round(float(low), 4), round(float(high), 4)))
    return tuple(windows)


def _band(track: Track, residual: Array) -> tuple[float, float] | None:
    """The band of frequencies that holds most of the residual's power [Hz]."""
    rate = track.smoothed.rate_hz
    frequency, power = signal.welch(residual, rate, nperseg=min(len(residual), int(8 * rate)))
    total = np.cumsum(power)
    if not total[-1] > 0.0:
        return None
    tail = 0.5 * (1.0 - _BAND_SHARE)
    low, high = np.searchsorted(total, [tail * total[-1], (1.0 - tail) * total[-1]])
    return float(frequency[low]), float(frequency[min(high, len(frequency) - 1)])


def _dependences(track: Track, refit: Fitted) -> tuple[Dependence, ...]:
    """How much of the residual's variance its mean over each signal explains, and where along it that is strongest."""
    residual = track.residual(refit.model, refit.skew)
    used = track.weight > 0.0
    _, states = track.replay(refit.model, late=refit.late)
    result = []
    for name, values in {**states, "time": track.time - track.time[0]}.items():
        symbol, _, unit = STATES.get(name, _TIME)
        found = _over(values[used], residual[used])
        if found is not None:
            score, low, high = found
            span = f"{low:.3g} < {symbol} < {high:.3g} {refit.model.unit(unit) or 'units'}"
            result.append(Dependence(name, round(score, 4), span))
    return tuple(sorted(result, key=lambda d: -d.score))


def _over(values: Array, residual: Array) -> tuple[float, float, float] | None:
    """Share of variance that bins of equal count explain, less what chance would, and the bin with most of it."""
    edges = np.unique(np.quantile(values, np.linspace(0.0, 1.0, _BINS + 1)))
    total = float(np.sum(residual**2))
    if len(edges) < 3 or total == 0.0:
        return None
    which = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, len(edges) - 2)
    count = np.maximum(np.bincount(which, minlength=len(edges) - 1), 1)
    sums = np.bincount(which, residual, len(edges) - 1)
    explained = sums**2 / count
    worst = int(np.argmax(explained))
    score = max(0.0, float(explained.sum()) / total - len(count) / len(values))
    return score, float(edges[worst]), float(edges[worst + 1])
