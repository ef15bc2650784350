"""The search for laws: what is named of all that can be said, and what is told of the rest."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

from mmt_drake.diagnosis.decide import gate
from mmt_drake.diagnosis.decide.confidence import ConfidenceSet, not_to_be_named
from mmt_drake.diagnosis.decide.confirm import is_confirmed
from mmt_drake.diagnosis.decide.delivered import agreed, beyond_doubt, outstanding, surely_there
from mmt_drake.diagnosis.decide.exchange import contenders
from mmt_drake.diagnosis.decide.gate import NoiseReference
from mmt_drake.diagnosis.doubt import is_better, is_doubtful
from mmt_drake.diagnosis.fit.comparison import at_bounds
from mmt_drake.diagnosis.fit.dilution import undiluted
from mmt_drake.diagnosis.fit.event_times import released
from mmt_drake.diagnosis.fit.hypothesis import FARTHEST
from mmt_drake.diagnosis.fit.nameless import NOISE_ALONE
from mmt_drake.diagnosis.fit.prepare import scales_of
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.diagnosis.fit.validate import intervals
from mmt_drake.diagnosis.search.base import doubted, fit_base
from mmt_drake.diagnosis.search.learn import (
    elsewhere,
    more_branches,
    other_curves,
    tables,
    without_effects,
    worth_while,
)
from mmt_drake.diagnosis.search.minima import moved_about, other_numbers
from mmt_drake.diagnosis.search.name import LEVELS, search
from mmt_drake.diagnosis.search.polish import STEPS, Polish
from mmt_drake.diagnosis.search.screening import TRY_MORE
from mmt_drake.diagnosis.search.watch import NOTHING, SearchSetup
from mmt_drake.diagnosis.session import BEST, PARAMETERS, DiagnosisSession
from mmt_drake.diagnosis.tell import document
from mmt_drake.diagnosis.tell.outcome import Judgement, Outcome, refused
from mmt_drake.diagnosis.tell.prescribe import prescribe
from mmt_drake.diagnosis.tell.result import TABULATED
from mmt_drake.effects.tabulated_force import SIGNALS
from mmt_drake.errors import MmtError, attempt

SEARCHING = 0.6
"""Share of the time budget for the search; the rest is for what it has found."""
LOOK_CLOSER = 6.0
"""RMS of the residual over the noise floor above which accurate integration would not make a fit explain enough."""
CONTENDERS = 3
"""How many of the best candidates, and of the best single effects, are fitted once more before the verdict."""
OFFSETS, ALIKE = frozenset({"force_bias", "constant_force"}), 1.1
"""Effects that are no more than an offset; a table is as good without them where it leaves so many times as much."""
NEAR = 1.5
"""Candidates that leave at most so many times as much as the best may have the block of an event for the fit."""

_MINIMUM = "whether there is a better minimum"
_SHAPE, _NEXT = "the shape of what is left", "what to record next"
_AT_BOUND = (
    "Fitted to the recordings, the model's {} ends {:g} times away from what was handed in, or is driven further: the "
    "model is too far from this system, or this recording says nothing of it. Nothing can be said of physics that may "
    "be missing. Hand in values nearer to the truth, or record a motion that shows them."
)
_TOO_LITTLE = (
    "The model leaves more than noise, but so little was recorded that chance would explain as much as any effect "
    "does: it cannot be told what is missing. Record for longer, or make the effect larger."
)


@dataclass(frozen=True)
class LawSession(DiagnosisSession):
    """One diagnosis that searches laws, one, then two and more at once.

    Attributes:
        polish: takes fits on to the clock of the verdict.
        next_motion: whether to seek the motion that would tell apart what is left open.
        friction_unsaid: see `SearchSetup`.
    """

    STAGES = (PARAMETERS, *LEVELS, BEST, _MINIMUM, _SHAPE, _NEXT)
    """Of the work."""

    polish: Polish
    next_motion: bool
    friction_unsaid: bool

    def searched(self, problem: Problem, standard: NoiseReference, refit: Fitted) -> Outcome:
        """See `DiagnosisSession.searched`.

        Where what is given is doubtful all is sought once more without it.
        """
        found = self._searched(problem, standard, refit)
        if self.watch.is_late() or not is_doubtful(found) or (free := doubted(problem, refit, self.executor)) is None:
            return found
        again = self._searched(problem, standard, self._taken_on(standard.problem, free))
        return again if is_better(again, found) else found

    def _taken_on(self, problem: Problem, fitted: Fitted) -> Fitted:
        """A fit without effects on another clock."""
        return fit_base(problem, self.model, self.prepared.skew, self.executor, fitted)[1]

    def _searched(self, problem: Problem, standard: NoiseReference, refit: Fitted) -> Outcome:
        start = self._taken_on(problem, refit)
        self.watch.saw(NOTHING, problem.left(start))
        scales = scales_of(problem, start.model)
        setup = SearchSetup(problem, self.library, scales, self.executor, self.watch, self.friction_unsaid)
        with self.watch.within(SEARCHING):
            levels = search(setup, start, enough=partial(self._enough, problem, standard))
        return self._judged(problem, standard, refit, levels)

    def refused_at_bounds(self, refit: Fitted) -> Outcome | None:
        """See `DiagnosisSession.refused_at_bounds`."""
        driven = at_bounds(refit)
        if not driven:
            return None
        return refused(self.prepared, self.model, _AT_BOUND.format(" and ".join(sorted(driven)), FARTHEST))

    def _judged(
        self, problem: Problem, standard: NoiseReference, refit: Fitted, levels: Sequence[Sequence[Fitted]]
    ) -> Outcome:
        """The verdict on what the search has found, on the fine clock."""
        tried = len({f.hypothesis.key for level in levels for f in level})
        found = gate.ranked(problem, [f for level in levels for f in level])
        standard, refit = _with_events(standard, refit, found)
        fine = standard.problem
        self.watch.begin(BEST)
        first = contenders(found, CONTENDERS)
        polished = [f for f in self.polish(fine, first) if f is not None]
        believed = ConfidenceSet.of(
            fine, [refit, *polished], {f.hypothesis.key: not_to_be_named(fine, refit, f) for f in polished}
        )
        others = (attempt(fine.unchanged, f.hypothesis, f.x) for f in found[: document.MOST_LISTED] if f not in first)
        known = [*gate.ranked(fine, polished), *(f for f in others if f is not None)]
        nothing = Judgement("unexplained", standard, refit, refit, (), known, believed, tried, self.watch.missed)
        judgement = self._named(problem, nothing, [refit, *polished], levels)
        if judgement is not None and judgement.verdict == "partly_explained":
            judgement = self._beside_its_table(problem, self._with_table(problem, judgement, polished))
        if judgement is not None:
            outcome = self.told(judgement)
            named = outcome.diagnosis.effects[: len(judgement.best.hypothesis.effects)]
            settled = judgement.verdict != "ambiguous" and all(e.certain == "law" for e in named)
            # A name that nothing else stands against is unsure for want of time, or of a law: no motion would tell.
            is_left = self.next_motion and not settled and len(believed.members) > 1
            return self._prescribed(outcome, believed.members) if is_left else outcome
        nothing_stands = not believed.members[0].hypothesis.effects
        if nothing_stands and not self.watch.missed and (at_bound := self.refused_at_bounds(refit)) is not None:
            return at_bound
        judgement = self._with_table(problem, nothing, polished)
        if judgement.learned is None and self._is_short() and nothing_stands:
            return refused(self.prepared, self.model, _TOO_LITTLE)
        handed_in = fine.at(refit.hypothesis, refit.hypothesis.base())
        free, ruler = undiluted(fine, refit), self.ruler(fine)
        best = handed_in if ruler.of(self.model) < ruler.of(free.model) else free  # a refit may predict worse
        judgement = replace(judgement, best=best, shares=self.shares(fine, best))
        if nothing_stands and judgement.learned is None and not judgement.untried:
            changed = best is free and bool(document.parameters(free, intervals(fine, free)))
            left = standard.left(handed_in), standard.left(refit)
            verdict = gate.without_names(judgement.shares, *left, changed, self._warned("offset"))
            if verdict == "no_mismatch":
                judgement = replace(judgement, best=handed_in, shares=self.shares(fine, handed_in))
            judgement = replace(judgement, verdict=verdict)
        return self.told(judgement)

    def _with_table(self, problem: Problem, judgement: Judgement, tried: Sequence[Fitted]) -> Judgement:
        """The judgement with the table of what its fit leaves, if that is worth while.

        Args:
            problem: as it was searched.
            judgement: without it.
            tried: sets of effects; a table that predicts worse than one of these is not delivered in its place.
        """
        self.watch.begin(_SHAPE)
        if self.watch.is_late():
            self.watch.miss([TABULATED])
            return replace(judgement, untried=self.watch.missed)
        best, standard = judgement.best, judgement.standard
        refitted = problem.fit(best.hypothesis, best.x, steps=STEPS)
        shapes = tables(problem, refitted, self.executor, self.watch.is_late)
        learned = worth_while(standard.problem, best, shapes)
        if learned is not None:
            least, ruler = min((standard.heldout(f) for f in tried), default=math.inf), self.ruler(standard.problem)
            # In the band that was fitted, and over all that was recorded.
            better = standard.heldout(learned.fitted) < least and ruler.of(learned.fitted.model) < ruler.of(best.model)
            learned = replace(learned, fitted=undiluted(standard.problem, learned.fitted)) if better else None
        return replace(judgement, learned=learned, shapes=shapes)

    def _beside_its_table(self, problem: Problem, judgement: Judgement) -> Judgement | None:
        """The judgement, if a table alone predicts worse than with the names beside it; else without any name.

        A curve has an offset of its own: a spring that is stiffer one way than the other looks like one. And a curve
        in one block may look like a law in another: a soft force sensor like a softening spring.

        Args:
            problem: as it was searched.
            judgement: with the table of what its fit leaves, if there is one.
        """
        best, learned = judgement.best, judgement.learned
        if learned is None:
            return judgement
        in_another_block = SIGNALS[learned.values["of"]].block not in {e.block for e in best.hypothesis.effects}
        if not (in_another_block or best.hypothesis.key <= OFFSETS):
            return judgement
        alone, ruler = without_effects(problem, judgement.refit, learned), self.ruler(judgement.standard.problem)
        is_as_good = alone is not None and ruler.of(alone.fitted.model) <= ALIKE * ruler.of(learned.fitted.model)
        return None if is_as_good else judgement

    def _named(
        self, problem: Problem, nothing: Judgement, fits: Sequence[Fitted], levels: Sequence[Sequence[Fitted]]
    ) -> Judgement | None:
        """The judgement that names what the members of the confidence set agree on; None if that is nothing of use.

        Args:
            problem: as it was searched.
            nothing: the judgement without names.
            fits: what was held against each other.
            levels: all that was tried, by number of effects.
        """
        standard, refit, believed = nothing.standard, nothing.refit, nothing.believed
        assert believed is not None  # of what was searched
        best, sure = agreed(standard.problem, believed, fits)
        if not best.hypothesis.effects:
            return None
        self.watch.begin(_MINIMUM)
        # Above that what is named may stand in a poor minimum: intervals say nothing of a better one elsewhere.
        (best,) = moved_about(standard.problem, [best], self.executor, self.watch, until=NOISE_ALONE, in_vain=1)
        if not self.watch.is_late():
            best = other_numbers(standard.problem, best, self.executor)
        there = surely_there(standard.problem, best, fits)
        if not there.hypothesis.effects or (there is not best and not sure):
            return None
        best = there
        shares = self.shares(standard.problem, best, fits)
        for fewer_of in (outstanding, beyond_doubt) if sure else ():
            if (fewer := fewer_of(standard.problem, best, shares, fits)) is not best:
                best, shares = fewer, self.shares(standard.problem, fewer, fits)
        count = len(best.hypothesis.effects)
        tried = len({f.hypothesis.key for level in levels for f in level if len(f.hypothesis.effects) == count})
        confirmed = is_confirmed(standard.problem, refit, best, believed, fits, tried)
        gain, ruler = standard.gain(refit, best), self.ruler(standard.problem)
        is_worth_naming = confirmed and gate.is_worth_naming(gain, standard.left(refit), standard.left(best))
        if not is_worth_naming or ruler.of(self.model) <= ruler.of(best.model):  # a refit may predict worse than both
            return None
        verdict, of_refit = self.on_physics(best, refit, standard, shares)
        may_be_nameless = verdict == "partly_explained" and gate.leaves_much_of(of_refit)
        there = surely_there(standard.problem, best, fits, 1.0) if may_be_nameless else best
        if there is not best and self._may_be_a_curve(problem, refit, best):
            # What has no name may have it all: where much is left, a name needs an interval that holds no nothing.
            best, shares = there, self.shares(standard.problem, there, fits)
            verdict, of_refit = self.on_physics(best, refit, standard, shares)
        # Explanations that differ by their block may all draw something else; equals say the same.
        differs = verdict == "partly_explained" and not sure and not believed.has_equal(best)
        if verdict == "unexplained" or (differs and gate.leaves_much(shares, of_refit)):
            return None
        bent = other_curves(standard.problem, best, self.executor) if sure else frozenset()
        if sure and standard.left(best) > gate.NOTHING_LEFT:
            bent |= more_branches(standard.problem, best, self.executor, self.watch)
        if (free := undiluted(standard.problem, best)) is not best:
            best, shares = free, self.shares(standard.problem, free, fits)
        ranked = [best if f.hypothesis.key == best.hypothesis.key else f for f in nothing.ranked]
        verdict = verdict if sure else "ambiguous"
        judgement = replace(nothing, verdict=verdict, best=best, shares=shares, ranked=ranked, bent=bent)
        return replace(judgement, of_refit=of_refit, untried=self.watch.missed)

    def _may_be_a_curve(self, problem: Problem, refit: Fitted, best: Fitted) -> bool:
        """Whether a table in another block than the effects of a fit predicts as well in their place."""
        ruler, blocks = self.ruler(problem), {e.block for e in best.hypothesis.effects}
        least = ALIKE * ruler.of(best.model)
        return any(ruler.of(alone.model) <= least for alone in elsewhere(problem, refit, blocks, self.executor))

    def _enough(self, problem: Problem, standard: NoiseReference, fitted: Fitted) -> bool:
        """Whether a fit leaves next to nothing, if need be on the fine clock: a search integrates coarsely."""
        left = problem.left(fitted) ** 2
        if TRY_MORE**2 < left <= LOOK_CLOSER**2:
            (polished,) = self.polish(standard.problem, [fitted])
            if polished is not None:
                return standard.left(polished) <= gate.NOTHING_LEFT
        return left <= TRY_MORE**2

    def _is_short(self) -> bool:
        """Whether the check before the diagnosis found so little that counts that it warned."""
        return self._warned("short")

    def _warned(self, code: str) -> bool:
        """Whether the check before the diagnosis warned of this in every recording."""
        checks = (check.findings for check in self.prepared.preflights)
        return all(any(f.code == code and f.severity == "warn" for f in findings) for findings in checks)

    def _prescribed(self, outcome: Outcome, explanations: Sequence[Fitted]) -> Outcome:
        self.watch.begin(_NEXT)
        try:
            prescription = prescribe(explanations, self.prepared, self.executor, self.watch.is_late)
        except MmtError as error:  # found on the accurate clock, and beyond the one that motions are sought on
            text = f"No motion could be sought that would tell these apart: {error}."
            return replace(outcome, diagnosis=replace(outcome.diagnosis, next_recording=text))
        diagnosis = replace(outcome.diagnosis, next_recording=prescription.text)
        return replace(outcome, diagnosis=diagnosis, prescription=prescription)


def _with_events(standard: NoiseReference, refit: Fitted, found: Sequence[Fitted]) -> tuple[NoiseReference, Fitted]:
    """Standard and refit, after data that the best candidates need to say when something happened are not held out."""
    near = [f for f in found[:CONTENDERS] if f.cost <= NEAR * found[0].cost]
    problem = released(standard.problem, near)
    if problem is standard.problem:
        return standard, refit
    return NoiseReference.of(problem), problem.fit(refit.hypothesis, refit.x)
