"""The diagnosis of a tip that presses on a surface: recordings of palpation.

The surface is unknown, so it is learned with what else may be missing, and so flexible an explanation is believed only
where it predicts what its fit has not seen: stretches of time, and places. A name holds as deep as every explanation
has it that neither of the two rules out; blocks that no fit and no choice has seen bear it out and give every figure.
"""

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from mmt_drake.analysis.wording import significant
from mmt_drake.diagnosis.checks.finding import Finding
from mmt_drake.diagnosis.decide import gate
from mmt_drake.diagnosis.decide.budget import BudgetPart, Ruler, budget
from mmt_drake.diagnosis.decide.confirm import is_confirmed
from mmt_drake.diagnosis.decide.gate import NoiseReference
from mmt_drake.diagnosis.decide.on_surface import believed_of
from mmt_drake.diagnosis.fit.comparison import at_bounds
from mmt_drake.diagnosis.fit.floors import with_floors
from mmt_drake.diagnosis.fit.places import Explained, Scan
from mmt_drake.diagnosis.fit.prepare import Prepared
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.diagnosis.fit.validate import intervals
from mmt_drake.diagnosis.search.base import fit_base
from mmt_drake.diagnosis.search.surfaces import MISSING, OFFSET, ONE_MORE, SMOOTHNESS, SurfaceSearch
from mmt_drake.diagnosis.search.watch import Watch
from mmt_drake.diagnosis.tell import document
from mmt_drake.diagnosis.tell.outcome import Judgement, Outcome, outcome_of, refused
from mmt_drake.diagnosis.tell.summary import summary_of
from mmt_drake.effects.effect import Effect
from mmt_drake.model.surface_contact import SurfaceContact
from mmt_drake.numeric.arrays import Array

PARAMETERS, BEST = "parameters", "what came out best, once more"
"""Stages that every diagnosis has."""
STAGES = (PARAMETERS, SMOOTHNESS, MISSING, OFFSET, ONE_MORE, BEST)
"""Of the work."""
_TOLD = 0.5
"""A stiffness is told if its interval is less than this part of it."""
_NOT_LEVEL = (
    "The tip cannot be simulated on a level surface with numbers near those handed in, so nothing can be held against "
    "that. Hand in a stiffness nearer to the truth."
)


@dataclass(frozen=True)
class SurfaceSession:
    """One diagnosis of a tip on a surface, on its way.

    Attributes:
        prepared: the recordings.
        problem: these, with a noise floor for each axis.
        model: the model handed in.
        library: effects that may be missing.
        executor: runs the fits.
        watch: sees to the time.
    """

    prepared: Prepared
    problem: Problem
    model: SurfaceContact
    library: Sequence[Effect]
    executor: Executor
    watch: Watch

    def run(self) -> Outcome:
        """The verdict, and all that it rests on."""
        self.watch.begin(PARAMETERS)
        skew = self.prepared.skew
        _, first = fit_base(replace(self.problem, coarse=1.0), self.model, skew, self.executor)
        own = replace(self.problem, coarse=1.0, tracks=with_floors(self.problem.tracks, first.model))
        nominal, refit = fit_base(own, self.model, skew, self.executor, first)
        standard = NoiseReference.of(own)
        verdict = gate.without_physics(standard.left(nominal), standard.left(refit))
        if verdict == "parameters" and not document.parameters(refit, intervals(own, refit)):
            verdict = "no_mismatch"
        if verdict is not None:
            best = nominal if verdict == "no_mismatch" else refit
            ruler = Ruler(self.prepared, own)
            wrong = document.parameters(best, intervals(own, best))
            judgement = Judgement(verdict, standard, refit, best, ruler, budget(ruler, self.model, best, wrong, {}))
            return outcome_of(self.prepared, self.model, judgement)
        return self._searched(_one_noise(own), refit)

    def _searched(self, problem: Problem, refit: Fitted) -> Outcome:
        scan, explained = SurfaceSearch(problem, refit, self.library, self.executor, self.watch).run()
        if not explained or explained[0].hypothesis.effects:  # what leaves nothing out cannot be simulated
            return refused(self.prepared, self.model, _NOT_LEVEL)
        self.watch.begin(BEST)
        # What noise leaves of perfect data depends on the model: a stiff contact makes more of the same motion.
        best = min(explained, key=lambda e: e.unseen_cost)
        problem = _one_noise(
            replace(problem, tracks=with_floors(problem.tracks, scan.surface.model_of(best.hypothesis, best.found)))
        )
        scan, explained = scan.held_to(problem, explained)
        fits = [scan.fitted(one) for one in explained]
        standard, refit = NoiseReference.of(problem), fits[0]
        believed = believed_of(scan, explained, fits)
        ruler = Ruler(self.prepared, problem)
        ranked = sorted(fits, key=lambda f: f.cost)
        nothing = Judgement(
            "unexplained", standard, refit, refit, ruler, (), ranked, believed, len(fits), untried=self.watch.missed
        )
        judgement = self._named(nothing, scan, explained, fits)
        if judgement is None:
            best_fit = refit
            if ruler.of(self.model) < ruler.fitted(refit):
                best_fit = problem.at(refit.hypothesis, refit.hypothesis.base())
            judgement = replace(nothing, best=best_fit, shares=self._shares(nothing, best_fit, ()))
        unseen = _unseen(scan, explained, judgement.best)
        return _with_findings(outcome_of(self.prepared, self.model, judgement), problem, unseen)

    def _named(
        self, nothing: Judgement, scan: Scan, explained: Sequence[Explained], fits: Sequence[Fitted]
    ) -> Judgement | None:
        """The judgement that names what the explanations that stand agree on; None if that is nothing of use."""
        believed, refit = nothing.believed, nothing.refit
        assert believed is not None  # of what was searched
        hypothesis = believed.members[0].hypothesis
        unsaid = believed.unsaid[hypothesis.key]
        for effect in hypothesis.effects:
            if effect.name in unsaid or believed.depth(effect) is None:
                hypothesis = hypothesis.without(effect.name)
        best = next((f for f in fits if f.hypothesis.key == hypothesis.key), refit)
        sure = bool(best.hypothesis.effects)
        if not sure and believed.members[0].hypothesis.effects:
            best = believed.best()  # of several that have nothing in common
        problem = nothing.standard.problem
        if not best.hypothesis.effects or nothing.standard.gain(refit, best) < gate.GAIN:
            return None
        if sure and not is_confirmed(problem, refit, best, believed, fits):
            return None
        shares = self._shares(nothing, best, [f for f in fits if f.hypothesis.key < best.hypothesis.key])
        of_refit = 1.0 - nothing.ruler.fitted(best) / nothing.ruler.fitted(refit)
        verdict = gate.with_physics(nothing.standard.left(best), shares, of_refit)
        if verdict == "unexplained":
            return None
        return replace(nothing, verdict=verdict if sure else "ambiguous", best=best, shares=shares)

    def _shares(self, nothing: Judgement, best: Fitted, fewer: Sequence[Fitted]) -> tuple[BudgetPart, ...]:
        """The budget of a delivered fit, given fits with some of its effects less."""
        wrong = document.parameters(best, intervals(nothing.standard.problem, best))
        without = {
            name: f
            for f in fewer
            for name in best.hypothesis.key - f.hypothesis.key
            if len(f.hypothesis.key) == len(best.hypothesis.key) - 1
        }
        return budget(nothing.ruler, self.model, best, wrong, without)


def _unseen(scan: Scan, explained: Sequence[Explained], best: Fitted) -> Finding:
    """How well what is delivered predicts times and places that its fit has not seen, and how well nothing added does.

    RMS of the three forces' errors [N], the mean over the axes.
    """
    floor = float(np.mean([track.floor for track in scan.surface.problem.tracks]))

    def rms(residual: Array) -> float:
        return floor * float(np.sqrt(np.mean(residual**2)))

    chosen = next((one for one in explained if one.hypothesis.key == best.hypothesis.key), explained[0])
    figures = {
        "time_N": rms(chosen.by_time),
        "place_N": rms(chosen.by_place),
        "nothing_time_N": rms(explained[0].by_time),
        "nothing_place_N": rms(explained[0].by_place),
    }
    told = {name: significant(value, 3) for name, value in figures.items()}
    text = (
        f"Times left out in turn are predicted to {told['time_N']} N RMS "
        f"({told['nothing_time_N']} N with nothing added), places to {told['place_N']} N ({told['nothing_place_N']} N)."
    )
    return Finding("unseen", "note", text, figures)


def _with_findings(outcome: Outcome, problem: Problem, unseen: Finding) -> Outcome:
    """The outcome with what unseen times and places say, and a word on a stiffness that an even pressure hides."""
    told = outcome.diagnosis
    outcome = replace(outcome, diagnosis=replace(told, preflight=(*told.preflight, unseen)))
    best = outcome.best
    if best is None or "k" not in best.hypothesis.free:
        return outcome
    at = best.hypothesis.free.index("k")
    (low, high), value = intervals(problem, best)[at], float(best.x[at])
    if high - low < _TOLD * value and "k" not in at_bounds(best):
        return outcome
    text = (
        f"The tip presses so evenly that these recordings do not tell how stiff the contact is: k may be anywhere from "
        f"{low:.3g} to {high:.3g} N/m or beyond. Press lightly and hard at the same places."
    )
    told = outcome.diagnosis
    told = replace(told, preflight=(Finding("stiffness_untold", "warn", text), *told.preflight))
    return replace(outcome, diagnosis=replace(told, summary=summary_of(told)))


def _one_noise(problem: Problem) -> Problem:
    """The recordings with one noise for the three axes of each: a slope takes from one what it gives another."""
    tracks = []
    for own in problem.by_recording():
        floor = float(np.sqrt(np.mean([track.floor**2 for track in own])))
        tracks += [replace(track, floor=floor) for track in own]
    return replace(problem, tracks=tuple(tracks))
