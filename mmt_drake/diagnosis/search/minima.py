"""Better minima: other and simpler laws in the place of one found, one effect less, numbers moved about."""

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from itertools import product

from mmt_drake.diagnosis.fit.comparison import RULED_OUT, elsewhere
from mmt_drake.diagnosis.fit.dilution import undiluted
from mmt_drake.diagnosis.fit.nameless import NOISE_ALONE
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.diagnosis.fit.tracks import COARSE
from mmt_drake.diagnosis.search.in_plane import per_axis_if_better, the_other_if_better
from mmt_drake.diagnosis.search.screening import REFINING_STEPS, best_of_each, refine, screen
from mmt_drake.diagnosis.search.starts import SETTLED, SETTLING_STEPS, Seed, Start, all_starts
from mmt_drake.diagnosis.search.watch import SearchSetup, Watch
from mmt_drake.effects.effect import Effect, Parameter
from mmt_drake.effects.viscoelastic_relaxation import TIME_CONSTANT
from mmt_drake.errors import attempt

_OTHER_FRICTION = 4
"""So many of the best are tried with friction the other one of a vector and one for each axis."""
_RESTARTED, _MOVES = 2, 8
_FIRST_STEPS, _TAKEN_ON = 2, 3
"""After so many steps from every move, so many of each set are taken on."""
_TURNS, _IN_VAIN, _BETTER = 12, 2, 0.9
"""So many turns at most, and so many one after the other that leave more than this part of the variance."""
_WINDOWS = (48, 24)
"""A whole recording is cut into so many windows, one after the other, on the way to another minimum."""
_RUGGED = 2.5
"""RMS of the residual over the noise above which another minimum is sought where there are many ..."""
_NEAR = 4.0
"""... by fits that leave at most this many times as much variance as the best one."""


def swap(setup: SearchSetup, found: Sequence[Fitted]) -> list[Fitted]:
    """Try others from all their starts in the place of the friction that the best fit has; all, best first.

    Laws of friction resemble each other, and beside a second effect the right one is easily missed from one start.
    """
    rubbing = [effect for effect in found[0].hypothesis.effects if effect.target == "Fc"]
    if not rubbing or setup.watch.is_late():
        return list(found)
    siblings = [effect for effect in setup.library if effect.target == "Fc"]
    return best_of_each([*found, *_instead(setup, found[0], rubbing[0], siblings)])


def simplify(setup: SearchSetup, found: Sequence[Fitted]) -> list[Fitted]:
    """Try a simpler law in the place of each that the best fit has; all, best first.

    Without the second effect a law with more numbers is the better first one, and what it was to be is never tried.
    """
    others: list[Fitted] = []
    for effect in () if setup.watch.is_late() else found[0].hypothesis.effects:
        others += _instead(setup, found[0], effect, [law for law in setup.library if law.is_simpler_than(effect)])
    return best_of_each([*found, *others])


def at_the_limit(problem: Problem, library: Sequence[Effect], found: Sequence[Fitted]) -> list[Fitted]:
    """Try from its numbers the laws that the best fit's law is in a limit; all, best first.

    A law far out towards that limit says nothing but the simpler one, whose own starts may have ended in poor minima.
    """
    best, others = found[0], list(found)
    for effect in best.hypothesis.effects:
        rest, known = best.hypothesis.without(effect.name), best.effect_values[effect.name]
        for law in library:
            if law.name not in effect.holds or not rest.admits(law):
                continue
            limit = rest.adding(law)
            for values in _limits(rest.fitted_parameters(law), effect, known):
                start = best.numbers_for(limit, {law.name: values})
                fitted = attempt(problem.fit, limit, start, steps=REFINING_STEPS, secant=True)
                others += [] if fitted is None else [per_axis_if_better(problem, fitted, REFINING_STEPS)]
    return best_of_each(others)


def _limits(parameters: Sequence[Parameter], effect: Effect, known: Mapping[str, float]) -> list[dict[str, float]]:
    """Numbers of a law that another one is in a limit: those of the same symbol, or each that vanishes at it."""
    choices = []
    for p in parameters:
        there = [known[q.symbol] for q in effect.parameters if q.vanishes_at == p.symbol and q.symbol in known]
        choices.append([known[p.symbol]] if p.symbol in known else list(dict.fromkeys(there)))
    return [dict(zip((p.symbol for p in parameters), values, strict=True)) for values in product(*choices)]


def kin(setup: SearchSetup, found: Sequence[Fitted]) -> list[Fitted]:
    """Try the kin of the best fit's friction from its numbers; all, best first.

    A law is only as sure as its kin had a chance, and a body that sticks has many minima: from starts of its own the
    right one may have ended far off.
    """
    best, others = found[0], []
    for effect in best.hypothesis.effects:
        if effect.target == "Fc" and not setup.watch.is_late():
            ours = [law for law in setup.library if law.target == "Fc" and law is not effect]
            others += _instead(setup, best, effect, ours, alike_alone=True)
    return best_of_each([*found, *others])


def from_handed_in(setup: SearchSetup, found: Sequence[Fitted]) -> list[Fitted]:
    """The best fits again from the numbers handed in, beside their effects; all, best first.

    Numbers that have made up for what was missing may stay where they are: mass and spring have valleys of their own.
    """
    best = found[:_RESTARTED]
    starts = [(f.hypothesis, f.hypothesis.vector({}, f.effect_values)) for f in best]
    again = setup.problem.fits(starts, setup.executor, steps=REFINING_STEPS, secant=True)
    return best_of_each([*found, *again])


def the_other_friction(setup: SearchSetup, found: Sequence[Fitted]) -> list[Fitted]:
    """Try the best fits with friction the other one, a vector or one for each axis, if nobody said; all, best first.

    What fits better without the effect that is missing may be the wrong one, and stands in the way of all laws then.
    """
    best = found[:_OTHER_FRICTION] if setup.friction_unsaid and setup.problem.left(found[0]) > NOISE_ALONE else []
    steps = [REFINING_STEPS] * len(best)
    tried = setup.executor.map(the_other_if_better, [setup.problem] * len(best), best, steps)
    return best_of_each([*tried, *found])


def _instead(
    setup: SearchSetup, best: Fitted, effect: Effect, laws: Sequence[Effect], *, alike_alone: bool = False
) -> list[Fitted]:
    """A fit with other laws in the place of one effect, from all their starts and with what they have in common.

    Args:
        setup: of the search.
        best: the fit.
        effect: in its place others are tried.
        laws: the others.
        alike_alone: from what they have in common alone.
    """
    if not laws:
        return []
    problem = setup.problem
    hypothesis = best.hypothesis.without(effect.name)
    starts = best.numbers_for(hypothesis), hypothesis.vector({}, best.effect_values)
    # An object may be stable with the effect alone: then its rest is that with the numbers handed in.
    rest = next((fit for x in starts if (fit := attempt(problem.at, hypothesis, x)) is not None), None)
    if rest is None:
        return []
    seeds = Seed.on_parts(rest, problem.eased(rest)[:1], instead=problem)
    tries = all_starts(seeds, laws, setup.scales)
    known = {**best.structure_values, **best.effect_values[effect.name]}
    own = [(start.effect.name, start.values) for start in tries]
    carried = {(a.effect.name, *a.values.values()): a for a in (_carried(start, known) for start in tries)}
    alike = [a for a in carried.values() if (a.effect.name, a.values) not in own]
    tries = alike if alike_alone else [*tries, *alike]
    return refine(setup, screen(setup, tries), rest.cost) if tries else []


def _carried(start: Start, known: Mapping[str, float]) -> Start:
    """A start with the numbers that another law has already, by their symbols or by what they vanish at."""
    named = {p.symbol: p.symbol if p.symbol in known else str(p.vanishes_at) for p in start.effect.parameters}
    return replace(start, values={symbol: known.get(named[symbol], value) for symbol, value in start.values.items()})


def prune(problem: Problem, best: Fitted, executor: Executor) -> list[Fitted]:
    """The best set with one effect less each, fitted from its numbers.

    A first effect caught in a poor minimum calls for a second one that makes up for it, and may need none after all.
    """
    fewer = (best.hypothesis.without(name) for name in best.hypothesis.names)
    starts = [(hypothesis, best.numbers_for(hypothesis)) for hypothesis in fewer]
    return problem.fits(starts, executor, steps=REFINING_STEPS, secant=True)


def random_restarts(setup: SearchSetup, found: Sequence[Fitted]) -> list[Fitted]:
    """The best fits that have many minima taken through windows and moved about; all, best first."""
    near = [f for f in found if f.cost <= _NEAR * found[0].cost]
    best = [f for f in near if any(map(_has_events, f.hypothesis.effects))][:_RESTARTED]
    keys = {f.hypothesis.key for f in best}
    rest = [f for f in found if f.hypothesis.key not in keys]
    if min(f.cost for f in found) > _RUGGED**2 * setup.problem.samples():
        best = list(setup.executor.map(_through_windows, [setup.problem] * len(best), best))
        best = moved_about(setup.problem, best, setup.executor, setup.watch, until=_RUGGED, in_vain=_IN_VAIN)
    return sorted([*best, *rest], key=lambda f: f.cost)


def _through_windows(problem: Problem, fitted: Fitted) -> Fitted:
    """A fit, or a better one by way of ever longer windows: a body that sticks once more or less is lost for good.

    In a window it is not.
    """
    found: Fitted | None = fitted
    parts = [part for count in _WINDOWS if (part := problem.cut(count)) is not None]
    for part in (*parts, problem) if parts else ():
        found = found and attempt(part.fit, found.hypothesis, found.x, steps=REFINING_STEPS, secant=True)
    return fitted if found is None or fitted.cost <= found.cost else found


def moved_about(
    problem: Problem, best: Sequence[Fitted], executor: Executor, watch: Watch, *, until: float, in_vain: int
) -> list[Fitted]:
    """Fits moved about and fitted again, each in its place, as it was or better.

    Where bodies stick and slip, or something begins, one event more or less is another minimum, and there is no way
    down from there. Several moves of different size at once, and again from the best of them, until one leaves no more
    than another minimum could, or moving about has been in vain for a while.

    Args:
        problem: what is fitted.
        best: fits of different hypotheses.
        executor: runs the fits.
        watch: its clock.
        until: RMS of the residual over the noise that is low enough.
        in_vain: turns in vain, one after the other, after which it ends.
    """
    best, vain = list(best), 0
    for turn in range(_TURNS):
        low_enough = not best or min(map(problem.left, best)) <= until
        if low_enough or vain == in_vain or watch.is_late():
            break
        before = [f.cost for f in best]
        numbers = range(turn * _MOVES, (turn + 1) * _MOVES)
        moved = [(f.hypothesis, f.hypothesis.moved(f.x, number)) for f in best for number in numbers]
        begun = problem.fits(moved, executor, steps=_FIRST_STEPS, converged_at=SETTLED, secant=True)
        least_of_each = [sorted((b for b in begun if b.hypothesis is f.hypothesis), key=lambda b: b.cost) for f in best]
        hopeful = [(b.hypothesis, b.x) for some in least_of_each for b in some[:_TAKEN_ON]]
        again = problem.fits(hopeful, executor, steps=SETTLING_STEPS, converged_at=SETTLED, secant=True)
        best = [min([f, *(a for a in again if a.hypothesis is f.hypothesis)], key=lambda f: f.cost) for f in best]
        gained = any(f.cost < _BETTER * cost for f, cost in zip(best, before, strict=True))
        vain = 0 if gained else vain + 1
    return best


def other_numbers(problem: Problem, best: Fitted, executor: Executor) -> Fitted:
    """A fit, or a better one with other numbers of the structure.

    A spring and a damper before a spring and a damper answer nearly alike with two sets of numbers, and from one there
    is no way down to the other. So each number is begun far away, the others where they are.

    Args:
        problem: what is fitted; another minimum is sought on the step of a search.
        best: the fit, without what noise of the input did to it (`undiluted`).
        executor: runs the fits.
    """
    quick = replace(problem, coarse=max(problem.coarse, COARSE))
    hypothesis = best.hypothesis
    begun = [(hypothesis, x) for x in (best.x, *elsewhere(best))]
    found = quick.fits(begun, executor, steps=REFINING_STEPS, converged_at=SETTLED, secant=True)
    least = min(found, key=lambda f: f.cost, default=best)
    if not found or least.cost >= found[0].cost - RULED_OUT:
        return best
    return undiluted(problem, problem.fit(hypothesis, least.x))


def _has_events(effect: Effect) -> bool:
    """Whether it sticks, begins, ends or turns somewhere; what relaxes only goes on."""
    return effect.target == "Fc" or any(p.shape and p != TIME_CONSTANT for p in effect.parameters)
