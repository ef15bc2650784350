"""Screening by halves: many starts on a part of the problem, the better ones on all of it, the best in full.

A few steps from each start, on the track that is explained worst, with the derivatives after the known parameters
carried over; a few steps more, with all derivatives and on all tracks, from the best of each effect and origin; a fit
in full of what is promising. One track at first is faster, and safer: an axis that slips now and then only takes
stick-slip into one of many minima.
"""

import math
import statistics
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Executor
from itertools import zip_longest

from mmt_drake.diagnosis.fit.event_times import at_best_times
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.diagnosis.search.in_plane import per_axis_if_better
from mmt_drake.diagnosis.search.starts import Screened, Start
from mmt_drake.diagnosis.search.watch import SearchSetup, Watch
from mmt_drake.errors import attempt

Enough = Callable[[Fitted], bool]

REFINING_STEPS = 25
_PROMISING = 0.5
"""A candidate is fitted in full if screening gave it this share of the best one's improvement."""
_MOST_REFINED = 8
TRY_MORE = 1.5
"""RMS of the residual over the noise floor above which a further effect is looked for."""
_LOOK_STEPS, _HOPELESS = 6, 4.0
"""Where one explains enough, what leaves this many times its variance after so many steps goes no further."""
_POOR = 0.1
"""Nor, where none explains enough, what gained less than this part of what the best one did."""
_FEW_STARTS, _HOPEFUL = 4, 12
"""So many starts are screened of each of so many sets of effects that promise most, and one of each of the others."""
_GOING_ON = 16
"""So many sets of effects go on after a first look; the others stay as it found them."""
_WIDENED, _SAME_MINIMUM = 2, 0.01
"""Of each set of effects so many go on to the whole problem; less apart than this part of it they ended alike."""
_FIRST = 2
"""A first answer is told when so many sets of effects have been fitted to all tracks."""
_ASKING, _LOOKING, _SETTLING, _LEAST_SETTLED = 0.25, 0.4, 0.5, 4
"""Shares of the time that is left for asking what promises most, of what is left then for the first steps from all
starts, and again for more steps from the better ones, best first; so many sets of effects go on whatever the time."""


def screen(
    setup: SearchSetup, tries: Sequence[Start], *, kept: int = 1, sets: int = 60, further: int = 1000
) -> list[Screened]:
    """Screen all starts, as long as there is time; of each set of effects the best from each origin, best first.

    Those that a first look leaves most of are as it found them.

    Args:
        setup: of the search.
        tries: the starts.
        kept: how many starts of each set and origin go on; more where there are many, for there are many minima.
        sets: how many sets of effects are screened, those that promise most.
        further: how many starts go on to the whole problem; the others are left behind. All then look at the same part.
    """
    problem, executor, watch = setup.problem, setup.executor, setup.watch
    left = _left(tries)
    with watch.within(_ASKING):
        tries = _promising(tries, executor, watch, sets)
    found: dict[tuple[frozenset[str], int], list[Screened]] = {}
    tried: set[str] = set()
    with watch.within(_LOOKING):
        # In the order of the starts, not of their ends: equals must come out the same whoever does the work.
        for done, (start, fitted) in enumerate(zip(tries, executor.map(Start.screened, tries), strict=True), 1):
            if fitted is not None:
                watch.did(f"a first look at {fitted.hypothesis.label}", done, len(tries))
                key = fitted.hypothesis.key, id(start.seed.fitted)
                found.setdefault(key, []).append(Screened(start, fitted))
            tried.add(start.name)
            if watch.is_late():  # what is not begun by now is cancelled
                watch.miss(a.name for a in tries if a.name not in tried)
                break
    better = (s for starts in found.values() for s in sorted(starts, key=left)[:kept])
    chosen, behind = _going_on(sorted(better, key=lambda s: s.fitted.cost)[:further], left)
    fits = executor.map(Start.settled, *zip(*((s.start, problem, s.fitted) for s in chosen), strict=True))
    settled: dict[frozenset[str], list[tuple[Start, Fitted | None]]] = {}
    with watch.within(_SETTLING):  # those that promise most come first
        for done, (one, fit) in enumerate(zip(chosen, fits, strict=True), 1):
            settled.setdefault(one.fitted.hypothesis.key, []).append((one.start, fit))
            if fit is not None:
                watch.saw(fit.hypothesis.label, problem.left(fit))
                watch.did(f"a second look at {fit.hypothesis.label}", done, len(chosen))
            if len(settled) == _FIRST:
                watch.answer()
            if len(settled) >= _LEAST_SETTLED and watch.is_late():  # those that promise least are left
                watch.miss(one.start.name for one in chosen if one.fitted.hypothesis.key not in settled)
                break
    best = sorted((pair for pairs in settled.values() for pair in _apart(pairs)), key=_cost)
    most = math.inf
    if best and (first := best[0][1]) is not None:
        base = best[0][0].seed.fitted.cost
        most = _HOPELESS * first.cost if problem.left(first) <= TRY_MORE else base - _POOR * (base - first.cost)
    fits = executor.map(Start.widened, *zip(*((start, problem, fit, most) for start, fit in best), strict=True))
    again = [Screened(start, fit) for (start, _), fit in zip(best, fits, strict=True) if fit is not None]
    for s in again:
        watch.saw(s.fitted.hypothesis.label, problem.left(s.fitted))
    fits = executor.map(lambda s: attempt(problem.unchanged, s.fitted.hypothesis, s.fitted.x), behind)
    again += [Screened(s.start, fit) for s, fit in zip(behind, fits, strict=True) if fit is not None]
    return sorted(again, key=lambda s: s.fitted.cost)


def _left(tries: Sequence[Start]) -> Callable[[Screened], float]:
    """What a first look leaves of the least that any seed does on the same part of the problem.

    Not of its own seed: numbers that were far off are put right by whatever effect stands beside them.
    """
    least: dict[int, float] = {}
    for seed in (start.seed for start in tries):
        least[id(seed.part)] = min(seed.near.cost, least.get(id(seed.part), math.inf))
    return lambda screened: screened.fitted.cost / least[id(screened.start.seed.part)]


def _going_on(
    looked_at: Sequence[Screened], left: Callable[[Screened], float]
) -> tuple[list[Screened], list[Screened]]:
    """All starts of those sets of effects that a first look leaves least of, and of each other set the best start."""
    by_left = sorted(looked_at, key=left)
    ranked = list(dict.fromkeys(s.fitted.hypothesis.key for s in by_left))
    first, others = set(ranked[:_GOING_ON]), ranked[_GOING_ON:]
    best = {s.fitted.hypothesis.key: s for s in reversed(by_left)}
    return [s for s in looked_at if s.fitted.hypothesis.key in first], [best[key] for key in others]


def _promising(tries: Sequence[Start], executor: Executor, watch: Watch, sets: int) -> list[Start]:
    """Of the many starts of a set of effects beside one seed those that promise most.

    One, where the set is not among those that promise most, and none of those that promise least of very many.

    The best one of each effect and seed comes first, then the second ones; of these what promises most. Should time be
    short, what promises least has had no turn. What a little of an effect does not show (an end stop further out)
    stands in the middle, and so does what there was no time to ask; one start of each is asked whatever the time.
    """
    tries, least = _in_turn(tries), len({(start.name, id(start.seed)) for start in tries})
    promised: list[float] = []
    for promise in executor.map(Start.promise, tries):
        promised.append(promise)
        watch.did("what promises most", len(promised), len(tries))
        if watch.is_late() and len(promised) >= least:
            break
    middle = statistics.median(promised) if promised else 0.0
    promised = [promise or middle for promise in promised] + [middle] * (len(tries) - len(promised))
    best = [tries[i] for i in sorted(range(len(tries)), key=lambda i: -promised[i])]
    names = list(dict.fromkeys(start.name for start in best))[:sets]
    return _in_turn(best, {name: _FEW_STARTS if rank < _HOPEFUL else 1 for rank, name in enumerate(names)})


def _in_turn(tries: Sequence[Start], most: Mapping[str, int] | None = None) -> list[Start]:
    """The first start of each effect beside each seed, then the second ones, and so on; at most so many by name."""
    starts: dict[tuple[str, int], list[Start]] = {}
    for start in tries:
        starts.setdefault((start.name, id(start.seed)), []).append(start)
    kept = (some if most is None else some[: most.get(name, 0)] for (name, _), some in starts.items())
    turns = zip_longest(*kept)
    return [start for turn in turns for start in turn if start is not None]


def _apart(pairs: Sequence[tuple[Start, Fitted | None]]) -> list[tuple[Start, Fitted | None]]:
    """The best ones of a set of effects that have not ended in the same minimum."""
    kept: list[tuple[Start, Fitted | None]] = []
    for pair in sorted(pairs, key=_cost):
        if not kept or _cost(pair) > (1.0 + _SAME_MINIMUM) * _cost(kept[-1]):
            kept.append(pair)
    return kept[:_WIDENED]


def _cost(pair: tuple[Start, Fitted | None]) -> float:
    return math.inf if pair[1] is None else pair[1].cost


def refine(
    setup: SearchSetup, screened: Sequence[Screened], base_cost: float, enough: Enough = lambda _: False
) -> list[Fitted]:
    """Fit the promising sets of effects in full, from each origin; the best of each set, best first.

    If the best one explains enough, those that still leave much more after a few steps go no further: they are out.
    """
    if not screened:
        return []
    gain = base_cost - screened[0].fitted.cost
    fits = [s.fitted for s in screened]
    # The best one goes on whatever it gained: cut short, screening may have found nothing better than the base.
    good = [fits[0].hypothesis.key, *(f.hypothesis.key for f in fits if base_cost - f.cost >= _PROMISING * gain)]
    promising = set(list(dict.fromkeys(good))[:_MOST_REFINED])
    chosen = [f for f in fits if f.hypothesis.key in promising]
    first = [f for f in chosen if f.hypothesis.key == fits[0].hypothesis.key]
    others = [f for f in chosen if f.hypothesis.key != fits[0].hypothesis.key]
    best = min(_all_fitted_on(setup, first, REFINING_STEPS), key=lambda f: f.cost)
    if enough(best):
        others = _all_fitted_on(setup, others, _LOOK_STEPS)
        fits += others
        others = [f for f in others if f.cost <= _HOPELESS * best.cost]
    return best_of_each([best, *fits, *_all_fitted_on(setup, others, REFINING_STEPS)])


def best_of_each(fits: Iterable[Fitted]) -> list[Fitted]:
    """The best fit of each set of effects, best first."""
    best: dict[frozenset[str], Fitted] = {}
    for fitted in sorted(fits, key=lambda f: f.cost):
        best.setdefault(fitted.hypothesis.key, fitted)
    return list(best.values())


def _all_fitted_on(setup: SearchSetup, fits: Sequence[Fitted], steps: int) -> list[Fitted]:
    """Fits taken on by some steps each, in their order, as far as there is time: the first one always."""
    found: list[Fitted] = []
    for fitted in setup.executor.map(_fitted_on, [setup.problem] * len(fits), fits, [steps] * len(fits)):
        found.append(fitted)
        setup.watch.did(f"in full {fitted.hypothesis.label}", len(found), len(fits))
        if setup.watch.is_late():
            break
    return found


def _fitted_on(problem: Problem, fitted: Fitted, steps: int) -> Fitted:
    again = problem.fit(
        fitted.hypothesis, at_best_times(problem, fitted.hypothesis, fitted.x), steps=steps, secant=True
    )
    return per_axis_if_better(problem, again if again.cost <= fitted.cost else fitted, steps)
