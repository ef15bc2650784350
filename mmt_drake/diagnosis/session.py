"""A diagnosis whatever it searches: the fit of the numbers handed in, and the verdict where that explains it."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

from mmt_drake.diagnosis.decide import gate
from mmt_drake.diagnosis.decide.alike import play_or_friction
from mmt_drake.diagnosis.decide.budget import BudgetPart, Ruler, budget
from mmt_drake.diagnosis.decide.gate import NoiseReference
from mmt_drake.diagnosis.decide.verdict import Verdict
from mmt_drake.diagnosis.fit.dilution import undiluted
from mmt_drake.diagnosis.fit.floors import weighed, with_floors
from mmt_drake.diagnosis.fit.prepare import Prepared
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.diagnosis.fit.tracks import COARSE
from mmt_drake.diagnosis.fit.validate import intervals
from mmt_drake.diagnosis.search.base import fit_base
from mmt_drake.diagnosis.search.watch import Watch
from mmt_drake.diagnosis.tell import document
from mmt_drake.diagnosis.tell.outcome import Judgement, Outcome, outcome_of
from mmt_drake.effects.effect import Effect
from mmt_drake.model.structure import Structure

PARAMETERS, BEST = "parameters", "what came out best, once more"
"""Stages that every diagnosis has."""


@dataclass(frozen=True)
class DiagnosisSession(ABC):
    """One diagnosis on its way.

    Attributes:
        prepared: the recordings.
        problem: these, with a noise floor for each axis, as they are searched: over shorter windows, it may be.
        fine: the same on the clock of the verdict.
        model: the model handed in.
        library: effects that may be missing.
        executor: runs the fits.
        watch: sees to the time.
        begun: the fit of the numbers handed in, where there was one already.
    """

    prepared: Prepared
    problem: Problem
    fine: Problem
    model: Structure
    library: Sequence[Effect]
    executor: Executor
    watch: Watch
    begun: Fitted | None

    def run(self) -> Outcome:
        """The verdict, and all that it rests on."""
        skew = self.prepared.skew
        refit = self.begun or fit_base(self.problem, self.model, skew, self.executor)[1]
        # What noise leaves of perfect data depends on the model.
        problem, fine = (
            weighed(replace(p, tracks=with_floors(p.tracks, refit.model), coarse=coarse), refit)
            for p, coarse in ((self.problem, COARSE), (self.fine, 1.0))
        )
        nominal, refit = fit_base(fine, self.model, skew, self.executor, refit)
        standard = NoiseReference.of(fine)
        verdict = gate.without_physics(standard.left(nominal), standard.left(refit))
        free = undiluted(fine, refit) if verdict == "parameters" else refit
        if verdict == "parameters" and not document.parameters(free, intervals(fine, free)):
            verdict = "no_mismatch"
        if verdict == "parameters" and (refused := self.refused_at_bounds(refit)) is not None:
            return refused
        if verdict is None:
            return self.searched(problem, standard, refit)
        best = nominal if verdict == "no_mismatch" else free
        return self.told(Judgement(verdict, standard, refit, best, self.shares(fine, best)))

    @abstractmethod
    def searched(self, problem: Problem, standard: NoiseReference, refit: Fitted) -> Outcome:
        """The verdict where physics may be missing.

        Args:
            problem: as it is to be searched, its noise that of the refit.
            standard: what fits on the clock of the verdict are held to.
            refit: the fit of the numbers handed in, on that clock.
        """

    def refused_at_bounds(self, refit: Fitted) -> Outcome | None:
        """What is said where numbers at a bound prove nothing; None where they may be told."""
        return None

    def told(self, judgement: Judgement) -> Outcome:
        """The document of a judgement, and what it rests on."""
        changed = judgement.verdict != "no_mismatch"
        alike = play_or_friction(judgement.standard.problem, judgement.delivered) if changed else ()
        return outcome_of(self.prepared, self.model, judgement, alike)

    def ruler(self, problem: Problem) -> Ruler:
        """Of the held-out errors of a problem."""
        return Ruler(self.prepared, problem)

    def shares(self, problem: Problem, best: Fitted, fits: Sequence[Fitted] = ()) -> tuple[BudgetPart, ...]:
        """The budget of a delivered fit, given others: of these those with one of its effects less are used."""
        wrong = document.parameters(best, intervals(problem, best))
        key = best.hypothesis.key
        without = {
            name: f
            for f in fits
            for name in key - f.hypothesis.key
            if f.hypothesis.key < key and len(f.hypothesis.key) == len(key) - 1
        }
        return budget(self.ruler(problem), self.model, best, wrong, without)

    def on_physics(
        self, best: Fitted, refit: Fitted, standard: NoiseReference, shares: Sequence[BudgetPart]
    ) -> tuple[Verdict, float]:
        """The verdict on the effects of a fit by its budget, and what part they take off what a refit leaves."""
        of_refit = self.of_refit(best, refit, standard)
        return gate.with_physics(standard.left(best), shares, of_refit), of_refit

    def of_refit(self, best: Fitted, refit: Fitted, standard: NoiseReference) -> float:
        """What part a fit takes off what a refit leaves beyond the noise, on held-out data; 0 where it takes none."""
        ruler = self.ruler(standard.problem)
        after, before = ruler.of(best.model), ruler.of(refit.model)
        if after >= before:
            return 0.0
        noise = min(ruler.noise(best.model), after)
        return 1.0 - (after - noise) / (before - noise)
