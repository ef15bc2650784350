"""Validation of a fit: intervals of its numbers, and its gain on data that it never saw."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy import stats

from mmt_drake.diagnosis.fit.bootstrap import Deviations, deviations
from mmt_drake.diagnosis.fit.box_tracks import NormalTrack
from mmt_drake.diagnosis.fit.event_times import event_times
from mmt_drake.diagnosis.fit.hypothesis import Hypothesis
from mmt_drake.diagnosis.fit.latest import Latest
from mmt_drake.diagnosis.fit.nameless import nameless_laws
from mmt_drake.diagnosis.fit.problem import MOST_SKEW_S, Fitted, Problem
from mmt_drake.effects import LIBRARY
from mmt_drake.effects.effect import Effect
from mmt_drake.errors import attempt
from mmt_drake.model.over import plain
from mmt_drake.numeric.arrays import Array

_CLOCK_DEVIATION = 0.5
"""A delay is known to this part of a sample at best: no recording says when within a sample a channel was read."""
_ACCURACY = 1e-3
"""Deviation of a number, over itself, that comes from what happens between samples."""
_STEPS_OUT, _FURTHER = 8, 1.5
_STEPS_ON, _HALVINGS = 25, 6
"""Where nothing touches for long, an event may be anywhere: so many steps on, and then so many halvings of the last."""

_latest = Latest()


def intervals(problem: Problem, fitted: Fitted) -> tuple[tuple[float, float], ...]:
    """95 % interval of each free number of a fit; as wide as its bounds where the data say nothing about it.

    From `bootstrap.deviations`, with what laws may hide that nobody has named (`nameless_laws`). No number is taken to
    be known better than _ACCURACY of itself, and an effect's number goes as far as the cost stays flat.

    Args:
        problem: what was fitted.
        fitted: the fit.
    """
    return _latest.of((problem, fitted), None, lambda: _intervals(problem, fitted))


def _intervals(problem: Problem, fitted: Fitted) -> tuple[tuple[float, float], ...]:
    known = _known(problem, fitted, nameless_laws(problem, fitted))
    step = problem.tracks[0].smoothed.clock.step
    moments, end = event_times(fitted.hypothesis), max(track.duration for track in problem.tracks)
    result = []
    for i, parameter in enumerate(fitted.hypothesis.free_parameters()):
        value, own = float(fitted.x[i]), float(known.deviation[i])
        is_beyond = i in moments and known.t * own > end
        if is_beyond or (parameter.effect and not fitted.minimum.jacobian[:, i].any()):
            own = 0.0  # flat just there, as an event between two samples or two touches is: `_reach` sees how far
        half = known.t * math.hypot(own, _ACCURACY * abs(value))
        if parameter.key == ("time_delay", "delay"):
            half = math.hypot(half, known.t * _CLOCK_DEVIATION * step)
        down, up = half, half
        if parameter.effect:
            within, finely = known.strength * known.t**2, i in moments
            down, up = (_reach(problem, fitted, i, sign * half, within, finely=finely) for sign in (-1.0, 1.0))
        most = max(end, value) if i in moments else parameter.high  # later than the recording nothing shows
        result.append((max(value - down, parameter.low), min(value + up, most)))
    return tuple(result)


def _known(problem: Problem, fitted: Fitted, laws: Sequence[Array] = ()) -> Deviations:
    """How well the numbers of a fit are known: `bootstrap.deviations`.

    Where the data say nothing of a parameter of the structure but together with an effect, as of the mass of what falls
    and its drag, that parameter is held: how well the effect's numbers are known is asked beside the value it has. A
    skew is never held: what is left without a name may have moved it anywhere, and dampers with it.
    """
    parameters, minimum = fitted.hypothesis.free_parameters(), fitted.minimum
    effects = np.array([bool(parameter.effect) for parameter in parameters])
    low, high = (np.array([getattr(parameter, end) for parameter in parameters]) for end in ("low", "high"))
    blocks, samples = problem.objective_blocks(), problem.samples()
    jacobian = minimum.jacobian
    known = deviations(jacobian, minimum.residual, blocks, samples)
    kept = effects | (fitted.x - known.half_width > low) | (fitted.x + known.half_width < high)
    deviation, is_whole = known.deviation.copy(), kept.all()
    if fitted.hypothesis.has_skew and not kept[-1]:  # within its bounds it may be anything, and no more than that
        kept[-1], jacobian = True, jacobian.copy()
        jacobian[-1, -1] = max(jacobian[-1, -1], math.sqrt(3.0 * known.strength) / MOST_SKEW_S)
    if laws or not is_whole:
        known = deviations(jacobian[:, kept], minimum.residual, blocks, samples, laws)
        deviation[kept] = known.deviation
    return replace(known, deviation=deviation)


def vanishing(problem: Problem, fitted: Fitted) -> frozenset[str]:
    """Effects of a fit that may as well be nothing: their intervals hold the values at which they vanish.

    Intervals over blocks alone: whether another law may stand in the place of an effect is asked where explanations are
    compared, and its strength then says nothing more.
    """
    known = _known(problem, fitted)
    half = np.hypot(known.half_width, known.t * _ACCURACY * np.abs(fitted.x))
    return within_reach_of_nothing(fitted, [(x - h, x + h) for x, h in zip(fitted.x, half, strict=True)])


def within_reach_of_nothing(fitted: Fitted, known_to: Sequence[tuple[float, float]]) -> frozenset[str]:
    """Effects of a fit whose intervals, one of each free number, hold the values at which they vanish."""
    spans = {p.key: span for p, span in zip(fitted.hypothesis.free_parameters(), known_to, strict=True)}

    def may_vanish(effect: Effect) -> bool:
        used = {common: _common(fitted.hypothesis, common, spans) for common in effect.uses}
        # Of a curve the number that is surest to be there: none is, only if all may be nothing.
        own: dict[str, tuple[float, float]] = {}
        for (name, symbol), interval in spans.items():
            if name == effect.name:
                own[plain(symbol)] = max(own.get(plain(symbol), interval), interval, key=_sureness)
        return effect.may_vanish({**used, **own})

    return frozenset(effect.name for effect in fitted.hypothesis.effects if may_vanish(effect))


def of_no_mass(fitted: Fitted, known_to: Sequence[tuple[float, float]]) -> frozenset[str]:
    """Effects of a body of next to no mass, its interval ends where it may go, that are laws of another structure too.

    Those that a law which this structure cannot have is nearly equal to (`Effect.near_equal`).

    Args:
        fitted: the fit.
        known_to: interval of each free number.
    """
    numbers = zip(fitted.hypothesis.free_parameters(), known_to, strict=True)
    if not any(parameter.key == ("", "m") and low <= parameter.low for parameter, (low, _) in numbers):
        return frozenset()
    nominal, names = fitted.hypothesis.nominal, frozenset(fitted.hypothesis.names)
    elsewhere = (law.near_equal for law in LIBRARY.values() if not law.acts_on(nominal))
    return names & frozenset().union(*elsewhere)


def ranges(problem: Problem, fitted: Fitted) -> dict[str, tuple[float, float]]:
    """Least and greatest value of every signal within the recordings, as a fit has them: what `Effect.engages` asks."""
    found: dict[str, tuple[float, float]] = {}
    for track in problem.tracks:
        _, states = track.replay(fitted.model, problem.coarse, fitted.late)
        smoothed, used = track.smoothed, track.weight > 0.0
        own = {**states, "time": track.time - track.time[0], "since_touch": smoothed.contact.since(track.time)}
        own["step"] = np.full(len(track.time), smoothed.clock.step)
        if not isinstance(track, NormalTrack):
            own["force"] = track.measured
        seen = {name: values[used] for name, values in own.items()}
        seen["time_in_contact"] = own["time"][used & smoothed.in_contact]
        for name, values in seen.items():
            low, high = found.get(name, (math.inf, -math.inf))
            found[name] = (float(values.min(initial=low)), float(values.max(initial=high)))
    return found


def absent(problem: Problem, fitted: Fitted) -> frozenset[str]:
    """Effects of which the fit says that they happen, but not within the recordings."""
    values, within, model = fitted.effect_values, ranges(problem, fitted), fitted.model

    def engages(effect: Effect) -> bool:
        used = {
            symbol: (model.value(symbol), model.value(symbol)) for symbol in effect.uses if symbol != effect.replaces
        }
        return effect.engages(values[effect.name], {**within, **used})

    return frozenset(effect.name for effect in fitted.hypothesis.effects if not engages(effect))


def _sureness(interval: tuple[float, float]) -> float:
    """Distance of the middle of an interval from 0 over its width."""
    low, high = interval
    return abs(low + high) / max(high - low, 1e-300) if math.isfinite(high - low) else 0.0


def _common(
    hypothesis: Hypothesis, common: str, spans: Mapping[tuple[str, str], tuple[float, float]]
) -> tuple[float, float]:
    """The interval of a number of the structure and of what effects add to it, each as far as it is fitted."""
    value = hypothesis.nominal.value(common)
    own = hypothesis.nominal.SYMBOLS.get(common, "")
    parts = [_hull([s for (name, symbol), s in spans.items() if (name, plain(symbol)) == ("", own)], (value, value))]
    for effect in hypothesis.acting:
        if effect.adds_to == common:
            parts.append(
                _hull([spans[effect.name, p.symbol] for p in hypothesis.fitted_parameters(effect)], (0.0, 0.0))
            )
    return math.fsum(low for low, _ in parts), math.fsum(high for _, high in parts)


def _hull(spans: Sequence[tuple[float, float]], unfitted: tuple[float, float]) -> tuple[float, float]:
    """The interval that holds those of all numbers of a curve, or the one of what is one number."""
    return (min(low for low, _ in spans), max(high for _, high in spans)) if spans else unfitted


def _reach(problem: Problem, fitted: Fitted, i: int, half: float, limit: float, *, finely: bool = False) -> float:
    """How far from the minimum a number may go: half of its interval, or as far as the cost stays within a limit.

    When and where something begins shows in a few samples alone: between them the cost is flat, and its slope at the
    minimum says nothing.

    Args:
        problem: what was fitted.
        fitted: the fit.
        i: which number.
        half: of its interval, to either side.
        limit: of what the cost may grow by.
        finely: seek the edge itself, however far; else it is known to a third.
    """
    low, high, _ = fitted.hypothesis.limits(fitted.x)

    def is_within(reach: float) -> bool:
        x = fitted.x.copy()
        x[i] += math.copysign(reach, half)
        if not low[i] <= x[i] <= high[i]:
            return False
        changed = attempt(problem.unchanged, fitted.hypothesis, x)
        return changed is not None and changed.cost - fitted.cost <= limit

    reach, steps = abs(half), _STEPS_ON if finely else _STEPS_OUT
    while steps > 0 and is_within(_FURTHER * reach):
        reach, steps = _FURTHER * reach, steps - 1
    if not finely:
        return reach
    beyond = _FURTHER * reach
    for _ in range(_HALVINGS):
        middle = 0.5 * (reach + beyond)
        reach, beyond = (middle, beyond) if is_within(middle) else (reach, middle)
    return beyond


def chance(problem: Problem, before: Fitted, after: Fitted, tries: int) -> float:
    """Probability that chance alone made the held-out error of `after` as much smaller as it is, corrected.

    The better of two tests, times two and times the number of candidates that were tried (Bonferroni). One is a
    one-sided t test of the mean of the logarithm of the ratio of the sums of squares of each held-out block in contact:
    it sees a small gain that holds everywhere. The other is an F test of the ratio of all of them, each block with one
    degree of freedom: it sees a great gain in few blocks.

    Args:
        problem: with the held-out blocks.
        before: the fit without.
        after: the fit with what was added.
        tries: how many candidates were tried.
    """
    touching = problem.touching(heldout=True)
    numbers = problem.blocks(heldout=True)[touching]
    counts = np.bincount(numbers)

    def sums(fitted: Fitted) -> Array:
        residual = problem.residual(fitted.model, fitted.skew, heldout=True)[touching]
        return np.asarray(np.bincount(numbers, residual**2)[counts > 0], dtype=np.float64)

    one, other = sums(before), sums(after)
    count, ratio = len(one), np.log(one / other)
    p = float(stats.f.sf(one.sum() / other.sum(), count, count))
    if count > 1 and ratio.std(ddof=1) > 0.0:
        t = ratio.mean() / (ratio.std(ddof=1) / math.sqrt(count))
        p = min(p, float(stats.t.sf(t, count - 1)))
    return min(1.0, 2.0 * tries * p)
