"""The search for missing physics: every effect is tried beside what is known, from several starts; then several.

A missing effect distorts the fit without it, sometimes into another regime altogether. So every candidate starts from
that fit and, where they are worse, from the nominal parameters. What does not happen in the recordings (half a period
of a disturbance, a law of turns where nothing turns) imitates any drift: it may rule out others, but nothing is built
on it.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from mmt_drake.diagnosis.fit.comparison import at_bounds
from mmt_drake.diagnosis.fit.left_out import gained_by_chance
from mmt_drake.diagnosis.fit.prepare import scales_of
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.diagnosis.fit.validate import absent
from mmt_drake.diagnosis.search.minima import (
    at_the_limit,
    from_handed_in,
    kin,
    prune,
    random_restarts,
    simplify,
    swap,
    the_other_friction,
)
from mmt_drake.diagnosis.search.screening import Enough, best_of_each, refine, screen
from mmt_drake.diagnosis.search.starts import SETTLING_STEPS, Screened, Seed, Start, added, all_starts, together
from mmt_drake.diagnosis.search.watch import SearchSetup, Watch

LEVELS = (
    "one missing effect",
    "two missing effects",
    "three missing effects",
    "four missing effects",
    "five missing effects",
)
"""What a search looks for, stage by stage."""
_MOST_SEEDS = 4
_SETS, _FURTHER, _FURTHER_KEPT = 30, 24, 2
"""Of pairs so many are screened, so many starts go on to all tracks, and so many of each."""
_SHARE = 0.5
"""Of the time that is left one more effect at once may take: a single one must leave time for two."""
_RESTARTING = 0.1
"""Of the time that is left each search for another minimum may take, where there are many."""
_ASKED = 3
"""A further effect is sought where one of so many gained more than chance gives the best of all that were tried."""
_LITTLE = 5.0
"""It is sought whatever single ones gained where the model leaves more than so many times the noise: of two that only
together are any good neither is, alone."""
_PAIRS, _PROMISED = 4, 0.3
"""Pairs that are tried for what both promise together: so many at most, and what promises this part of the cost."""
_ADDED = 12
"""And so many that are expected to leave least by what each did alone."""
_TAKES_MOST, _TAKES_NEARLY_ALL = 0.5, 0.25
"""A third effect, or a further one, is sought where the last one left less than this part of what was left beyond the
noise, and kept where it leaves no more than this: any law takes a part of what has no name, and laws are many."""
_BESIDE_MORE, _MORE_KEPT, _MOST_PRUNED = 20, 12, 3
"""Of three effects and more so many sets are screened, so many starts go on to all tracks, and of so many of the best
every one must do worse with one effect less."""
_ALIKE = 1.1
"""The numbers handed in are a second origin where they cost so many times as much as the fitted ones, or bounds hold
these."""
_WORTH = 0.1
"""A fit is worth adding to if it gained this share of what the best one did."""


def search(setup: SearchSetup, base: Fitted, *, enough: Enough) -> list[list[Fitted]]:
    """Try one effect, then two and up to five, as long as more than noise is left.

    Args:
        setup: what is fitted, and what is tried.
        base: the fit without effects.
        enough: whether a fit leaves so little that nothing more need be sought.

    Returns:
        Of each number of effects, from one on: the candidates, best first.
    """
    problem, watch = setup.problem, setup.watch
    origins = _origins(problem, base)
    tries = all_starts(origins, setup.library, setup.scales)
    watch.begin(LEVELS[0])
    with watch.within(_SHARE):
        screened = screen(setup, tries)
        found = _in_full(setup, screened, base.cost, enough)
    if not found:
        return []
    found = _other_minima(setup, found)
    singles = best_of_each([*found, *(s.fitted for s in screened)])
    if enough(found[0]):
        return [_made_up(setup, tries, singles)]
    if _no_time_for(2, watch):
        return [singles]
    seeds = _seeds(problem, found, base.cost)
    is_little = problem.left(base) <= _LITTLE
    if not seeds or (is_little and _is_chance(problem, base, seeds[:_ASKED], len(singles))):
        return [singles]
    levels = _two(setup, origins, screened, seeds, singles, enough)
    while 1 < len(levels) < len(LEVELS) and (more := _one_more(setup, screened, levels[-2:], enough)):
        levels[-1:] = more
    return levels


def _two(
    setup: SearchSetup,
    origins: Sequence[Seed],
    screened: Sequence[Screened],
    seeds: Sequence[Fitted],
    singles: Sequence[Fitted],
    enough: Enough,
) -> list[list[Fitted]]:
    """Try two effects: the single ones, better where a pair's numbers say how, and the pairs. See `_beside`."""
    setup.watch.begin(LEVELS[1])
    tries = _beside(setup, origins, screened, seeds, singles)
    found, pairs = _fitted(setup, tries, min(seed.cost for seed in seeds), enough, sets=_SETS, further=_FURTHER)
    if not found:
        return [list(singles)]
    return [_pruned(setup, found[:1], singles), pairs]


def _one_more(
    setup: SearchSetup, screened: Sequence[Screened], levels: Sequence[Sequence[Fitted]], enough: Enough
) -> list[list[Fitted]]:
    """Try one effect more beside the best sets of two or more.

    Args:
        setup: of the search.
        screened: single effects as screening left them.
        levels: the fits with one effect less than the best sets, and the best sets; best first.
        enough: as for `search`.

    Returns:
        The best sets, better where a greater set's numbers say how, and the greater ones; nothing where these are not
        sought, or leave too much to be believed.
    """
    (fewer, *_), (best, *others) = levels
    count = len(best.hypothesis.effects)
    if enough(best) or _rest(setup.problem, best) >= _TAKES_MOST * _rest(setup.problem, fewer):
        return []
    if _no_time_for(count + 1, setup.watch):
        return []
    seeds = _seeds(setup.problem, [best, *others], fewer.cost)
    if not seeds:  # beside numbers moved about, one effect less does as well
        return []
    setup.watch.begin(LEVELS[count])
    parts = setup.problem.eased(best)[:1]
    begun = [begun for seed in seeds for begun in Seed.on_parts(seed, parts)]
    if not begun:
        return []
    first, *beside = begun
    tries = [
        *all_starts([first], setup.library, setup.scales),
        *_further(beside, _best_starts(screened)),
        *_at_what_is_left(setup, [first, *beside]),
    ]
    found, more = _fitted(setup, tries, best.cost, enough, sets=_BESIDE_MORE, further=_MORE_KEPT)
    if not found or _rest(setup.problem, found[0]) > _TAKES_NEARLY_ALL * _rest(setup.problem, best):
        return []
    return [_pruned(setup, found[:_MOST_PRUNED], levels[-1]), more]


def _fitted(
    setup: SearchSetup, tries: Sequence[Start], least: float, enough: Enough, *, sets: int, further: int
) -> tuple[list[Fitted], list[Fitted]]:
    """Sets of two effects or more, fitted from their starts.

    Args:
        setup: of the search.
        tries: the starts.
        least: what the fits that they start from cost.
        enough: as for `search`.
        sets, further: see `screen`.

    Returns:
        The promising sets, fitted in full, and these with all that were screened; best first.
    """
    with setup.watch.within(_SHARE):
        screened = screen(setup, tries, kept=_FURTHER_KEPT, sets=sets, further=further)
        found = _in_full(setup, screened, least, enough)
    if not found:
        return [], []
    if not enough(found[0]):
        found = swap(setup, found)
    found = _other_minima(setup, simplify(setup, found))
    return found, best_of_each([*found, *(s.fitted for s in screened)])


def _no_time_for(count: int, watch: Watch) -> bool:
    """Whether it is late, and told so of sets of so many effects."""
    late = watch.is_late()
    if late:
        watch.miss([f"sets of {count} effects"])
    return late


def _rest(problem: Problem, fitted: Fitted) -> float:
    """What a fit leaves beyond the noise, a sum of squares."""
    return max(fitted.cost - problem.samples(), 0.0)


def _origins(problem: Problem, base: Fitted) -> list[Seed]:
    """The fit of no effect, and the numbers handed in where they cost more, each on parts of the problem.

    A fit that bounds hold is nowhere in particular: it may cost as much as the numbers that it has left.
    """
    parts = problem.eased(base)
    nominal = problem.at(base.hypothesis, base.hypothesis.base())
    is_another = nominal.cost > _ALIKE * base.cost or bool(at_bounds(base))
    others = Seed.on_parts(nominal, parts) if is_another else []
    return [*Seed.on_parts(base, parts, steps=SETTLING_STEPS, instead=problem), *others]


def _in_full(setup: SearchSetup, screened: Sequence[Screened], least: float, enough: Enough) -> list[Fitted]:
    """Of what was screened the promising sets, fitted in full; those that show in the recordings, where any does."""
    present = [s for s in screened if not absent(setup.problem, s.fitted)] or screened
    return refine(setup, present, least, enough)


def _other_minima(setup: SearchSetup, found: Sequence[Fitted]) -> list[Fitted]:
    """The fits with what the best ones become from other numbers, as simpler laws and as their kin; best first."""
    with setup.watch.within(_RESTARTING):
        simpler = kin(setup, at_the_limit(setup.problem, setup.library, from_handed_in(setup, found)))
        return random_restarts(setup, the_other_friction(setup, simpler))


def _beside(
    setup: SearchSetup,
    origins: Sequence[Seed],
    screened: Sequence[Screened],
    seeds: Sequence[Fitted],
    singles: Sequence[Fitted],
) -> list[Start]:
    """What is tried beside one effect: all beside the first seed, what promises something beside the others.

    Args:
        setup: of the search.
        origins: the fit of no effect, and the numbers handed in where they are another origin.
        screened: single effects as screening left them, from each origin, best first.
        seeds: fits of one effect each.
        singles: all fits of one effect.
    """
    parts = setup.problem.eased(seeds[0])[:1]
    begun = [begun for seed in seeds for begun in Seed.on_parts(seed, parts)]
    starts = _best_starts(screened)
    base, *nominal = {id(origin.fitted): origin.fitted for origin in origins}.values()
    alone = [(base, singles), *((one, _from(one, screened)) for one in nominal)]
    return [
        *(all_starts(begun[:1], setup.library, setup.scales) if begun else ()),
        *_further(begun[1:], starts),
        *_at_what_is_left(setup, begun),
        *_together(setup, singles, [replace(start, seed=origins[0]) for start in starts.values()]),
        *(start for origin, fits in alone for start in _added(setup.problem, origin, fits)),
    ]


def _best_starts(screened: Sequence[Screened]) -> dict[str, Start]:
    """Of each effect the start from which screening, its best first, went furthest."""
    return {s.start.effect.name: s.start for s in reversed(screened)}


def _from(origin: Fitted, screened: Sequence[Screened]) -> list[Fitted]:
    """What screening made of each effect from one origin; best first."""
    return best_of_each(s.fitted for s in screened if s.start.seed.fitted is origin)


def _pruned(setup: SearchSetup, best: Sequence[Fitted], fewer: Sequence[Fitted]) -> list[Fitted]:
    """The fits of one effect less, with those that the best sets' numbers bring further, moved about; best first."""
    before = {f.hypothesis.key: f.cost for f in fewer}
    found = best_of_each(f for one in best for f in prune(setup.problem, one, setup.executor))
    better = [f for f in found if f.cost < before.get(f.hypothesis.key, math.inf)]
    with setup.watch.within(_RESTARTING):
        return best_of_each([*fewer, *(random_restarts(setup, better) if better else [])])


def _made_up(setup: SearchSetup, tries: Sequence[Start], found: Sequence[Fitted]) -> list[Fitted]:
    """With single effects that there was no time for: what sets of more would have had is left to them."""
    if setup.watch.is_late():
        return list(found)
    missed = setup.watch.took_up()
    waiting = [start for start in tries if start.name in missed]
    screened = screen(setup, waiting) if waiting else []
    return best_of_each([*found, *(s.fitted for s in screened)])


def _seeds(problem: Problem, found: Sequence[Fitted], before: float) -> list[Fitted]:
    """The fits that a further effect is added to: the best ones, if they gained anything worth while.

    Of those that show in the recordings, where any does.
    """
    shown = [f for f in found if not absent(problem, f)] or found
    gain = before - shown[0].cost
    return [f for f in shown if before - f.cost > _WORTH * gain][:_MOST_SEEDS]


def _is_chance(problem: Problem, before: Fitted, seeds: Sequence[Fitted], tried: int) -> bool:
    """Whether of so many tries chance alone makes one do as much as any of these: they call for nothing beside them."""
    one, *others = (problem.at(f.hypothesis, f.x) for f in (before, *seeds))  # a search's derivatives are near by only
    return all(gained_by_chance(problem, one, other) * tried > 1.0 for other in others)


def _together(setup: SearchSetup, singles: Sequence[Fitted], starts: Sequence[Start]) -> list[Start]:
    """Pairs that promise most to first order, each from that of the two which did better alone.

    An offset beside a damper that differs by direction: neither takes anything without the other, and of each alone
    nothing is seen.
    """
    fits = {f.hypothesis.names[0]: f for f in singles}
    tries = []
    for promise, *pair in together([s for s in starts if s.effect.name in fits], setup.executor)[:_PAIRS]:
        if promise < _PROMISED:
            break
        better, other = sorted(pair, key=lambda start: fits[start.effect.name].cost)
        alone = fits[better.effect.name]
        if alone.hypothesis.admits(other.effect):
            parts = setup.problem.eased(alone)[:1]
            tries += [Start(seed, other.effect, other.values) for seed in Seed.on_parts(alone, parts)]
    return tries


def _added(problem: Problem, base: Fitted, singles: Sequence[Fitted]) -> list[Start]:
    """Pairs that are expected to leave least by what each did alone, each from the numbers of both."""
    tries = []
    for left, *pair in added(base, singles)[:_ADDED]:
        better, other = sorted(pair, key=lambda single: single.cost)
        (effect,) = other.hypothesis.effects
        if better.hypothesis.admits(effect):
            seeds = Seed.on_parts(better, problem.eased(better)[:1])
            values = other.effect_values[effect.name]
            tries += [Start(seed, effect, values, 1.0 - left / better.cost) for seed in seeds]
    return tries


def _at_what_is_left(setup: SearchSetup, seeds: Sequence[Seed]) -> list[Start]:
    """Starts at the frequencies and lengths of what each seed leaves: what it has taken may have hidden these."""
    tries = []
    for seed in seeds:
        left = scales_of(setup.problem, seed.fitted.model)
        scales = setup.scales._replace(peaks=left.peaks, ripples=left.ripples)
        tries += [s for s in all_starts([seed], setup.library, scales) if s.values not in s.effect.starts(setup.scales)]
    return tries


def _further(seeds: Sequence[Seed], starts: Mapping[str, Start]) -> list[Start]:
    """Each seed with each other effect from where that did best alone; every set once, from its better seed."""
    tries: dict[frozenset[str], Start] = {}
    for seed in seeds:
        for name, start in starts.items():
            if seed.fitted.hypothesis.admits(start.effect):
                names = frozenset((*seed.fitted.hypothesis.names, name))
                tries.setdefault(names, Start(seed, start.effect, start.values))
    return list(tries.values())
