"""The diagnosis of a tip that presses on a surface: recordings of palpation.

The surface is unknown, so it is learned with what else may be missing, and so flexible an explanation is believed only
where it predicts what its fit has not seen: stretches of time, and places. A name holds as deep as every explanation
has it that neither of the two rules out; blocks that no fit and no choice has seen bear it out and give every figure.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mmt_drake.analysis.nrmse import rms
from mmt_drake.analysis.wording import significant
from mmt_drake.diagnosis.checks.finding import Finding
from mmt_drake.diagnosis.decide import gate
from mmt_drake.diagnosis.decide.confirm import is_confirmed
from mmt_drake.diagnosis.decide.gate import NoiseReference
from mmt_drake.diagnosis.decide.on_surface import believed_of
from mmt_drake.diagnosis.fit.comparison import at_bounds
from mmt_drake.diagnosis.fit.floors import with_floors
from mmt_drake.diagnosis.fit.places import Explained, Scan
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.diagnosis.fit.validate import intervals
from mmt_drake.diagnosis.search.surfaces import MISSING, OFFSET, ONE_MORE, SMOOTHNESS, SurfaceSearch
from mmt_drake.diagnosis.session import BEST, PARAMETERS, DiagnosisSession
from mmt_drake.diagnosis.tell.outcome import Judgement, Outcome, refused
from mmt_drake.diagnosis.tell.summary import summary_of

_TOLD = 0.5
"""A stiffness is told if its interval is less than this part of it."""
_NOT_LEVEL = (
    "The tip cannot be simulated on a level surface with numbers near those handed in, so nothing can be held against "
    "that. Hand in a stiffness nearer to the truth."
)


class SurfaceSession(DiagnosisSession):
    """One diagnosis of a tip on a surface; it is searched on the clock of the verdict."""

    STAGES = (PARAMETERS, SMOOTHNESS, MISSING, OFFSET, ONE_MORE, BEST)
    """Of the work."""

    def searched(self, problem: Problem, standard: NoiseReference, refit: Fitted) -> Outcome:
        """See `DiagnosisSession.searched`."""
        problem = _one_noise(standard.problem)
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
        ranked = sorted(fits, key=lambda f: f.cost)
        nothing = Judgement("unexplained", standard, refit, refit, (), ranked, believed, len(fits), self.watch.missed)
        judgement = self._named(nothing, scan, explained, fits)
        if judgement is None:
            best_fit, ruler = refit, self.ruler(problem)
            if ruler.of(self.model) < ruler.of(refit.model):
                best_fit = problem.at(refit.hypothesis, refit.hypothesis.base())
            judgement = replace(nothing, best=best_fit, shares=self.shares(problem, best_fit))
        unseen = _unseen(scan, explained, judgement.best)
        return _with_findings(self.told(judgement), problem, unseen)

    def _named(
        self, nothing: Judgement, scan: Scan, explained: Sequence[Explained], fits: Sequence[Fitted]
    ) -> Judgement | None:
        """The judgement that names what the explanations that stand agree on; None if that is nothing of use."""
        believed, refit = nothing.believed, nothing.refit
        assert believed is not None  # of what was searched
        hypothesis = believed.members[0].hypothesis
        unsaid = believed.unsaid[hypothesis.key]
        left_out = [e.name for e in hypothesis.effects if e.name in unsaid or believed.depth(e) is None]
        hypothesis = hypothesis.without(*left_out)
        best = next((f for f in fits if f.hypothesis.key == hypothesis.key), refit)
        sure = bool(best.hypothesis.effects)
        if not sure and believed.members[0].hypothesis.effects:
            best = believed.best()  # of several that have nothing in common
        standard = nothing.standard
        problem = standard.problem
        gain = standard.gain(refit, best)
        if not best.hypothesis.effects or not gate.is_worth_naming(gain, standard.left(refit), standard.left(best)):
            return None
        if sure and not is_confirmed(problem, refit, best, believed, fits):
            return None
        shares = self.shares(problem, best, fits)
        verdict, _ = self.on_physics(best, refit, standard, shares)
        if verdict == "unexplained":
            return None
        return replace(nothing, verdict=verdict if sure else "ambiguous", best=best, shares=shares)


def _unseen(scan: Scan, explained: Sequence[Explained], best: Fitted) -> Finding:
    """How well what is delivered predicts times and places that its fit has not seen, and how well nothing added does.

    RMS of the three forces' errors [N], the mean over the axes.
    """
    floor = float(np.mean([track.floor for track in scan.surface.problem.tracks]))
    chosen = next((one for one in explained if one.hypothesis.key == best.hypothesis.key), explained[0])
    figures = {
        "time_N": floor * rms(chosen.by_time),
        "place_N": floor * rms(chosen.by_place),
        "nothing_time_N": floor * rms(explained[0].by_time),
        "nothing_place_N": floor * rms(explained[0].by_place),
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
