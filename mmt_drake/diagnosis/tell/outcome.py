"""What a diagnosis has come to: in fits, and as the document that is written and read."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from mmt_drake.diagnosis.decide.budget import BudgetPart, Ruler
from mmt_drake.diagnosis.decide.confidence import ConfidenceSet
from mmt_drake.diagnosis.decide.gate import NoiseReference
from mmt_drake.diagnosis.decide.locate import locate
from mmt_drake.diagnosis.decide.mismatch import Mismatch
from mmt_drake.diagnosis.decide.verdict import NAMING, Verdict
from mmt_drake.diagnosis.fit.comparison import at_bounds
from mmt_drake.diagnosis.fit.errors import heldout_nrmse
from mmt_drake.diagnosis.fit.prepare import NormalFit, Prepared, with_normal
from mmt_drake.diagnosis.fit.problem import Fitted
from mmt_drake.diagnosis.fit.validate import intervals
from mmt_drake.diagnosis.search.learn import Learned
from mmt_drake.diagnosis.tell import document
from mmt_drake.diagnosis.tell.prescribe import Prescription
from mmt_drake.diagnosis.tell.result import Alternative, Diagnosis, Fit, NamedEffect
from mmt_drake.diagnosis.tell.summary import summary_of
from mmt_drake.errors import MmtError
from mmt_drake.model.structure import Structure


@dataclass(frozen=True)
class Outcome:
    """A diagnosis and what it rests on.

    Attributes:
        diagnosis: what is said.
        prepared: the recordings as they were used.
        nominal: the model handed in.
        refit: the fit of its own parameters; None where nothing was fitted.
        best: the fit that is delivered: with effects where some are named, else `refit`.
        normal: the normal axis, where there is one.
        candidates: all that was tried, best first.
        prescription: what to record next, where explanations remain that these recordings cannot tell apart.
    """

    diagnosis: Diagnosis
    prepared: Prepared
    nominal: Structure
    refit: Fitted | None = None
    best: Fitted | None = None
    normal: NormalFit | None = None
    candidates: tuple[Fitted, ...] = ()
    prescription: Prescription | None = None

    @property
    def augmented(self) -> Structure | None:
        """The model that is delivered."""
        if self.best is None:
            return None
        return with_normal(self.best.model, None if self.normal is None else self.normal.normal)


@dataclass(frozen=True)
class Judgement:
    """A verdict and the fits that it was given on.

    Attributes:
        verdict: the verdict.
        standard: what the fits were held to; its problem is theirs.
        refit: the fit of the model's own parameters.
        best: the fit that is delivered, but for a table.
        ruler: of held-out errors.
        shares: the budget of what is delivered.
        ranked: all that was tried and is told, best first.
        believed: what is not ruled out; None where nothing is named.
        tried: how many sets of effects were tried.
        learned: the table that is delivered beside it, for what has no name.
        shapes: all the tables that were learned.
        untried: what there was no time for.
    """

    verdict: Verdict
    standard: NoiseReference
    refit: Fitted
    best: Fitted
    ruler: Ruler
    shares: tuple[BudgetPart, ...]
    ranked: Sequence[Fitted] = ()
    believed: ConfidenceSet | None = None
    tried: int = 0
    learned: Learned | None = None
    shapes: Sequence[Learned] = ()
    untried: tuple[str, ...] = ()

    @property
    def named(self) -> Fitted | None:
        """The fit whose effects are named."""
        return self.best if self.verdict in NAMING else None

    @property
    def delivered(self) -> Fitted:
        """The fit of the model that is delivered."""
        return self.best if self.learned is None else self.learned.fitted


def outcome_of(prepared: Prepared, model: Structure, judgement: Judgement) -> Outcome:
    """The document of a judgement, its figures simulated, and what it rests on, but for the time it took.

    Args:
        prepared: the recordings as they were used.
        model: the model handed in.
        judgement: what was found.
    """
    problem, named, ruler, delivered = judgement.standard.problem, judgement.named, judgement.ruler, judgement.delivered
    ranked, believed, normal = judgement.ranked, judgement.believed, judgement.ruler.normal
    nothing = judgement.verdict == "no_mismatch"
    known_to = intervals(problem, delivered)
    wrong = {} if nothing else document.parameters(model, delivered, known_to, normal)
    models = model, ruler.delivered(judgement.refit.model), ruler.delivered(delivered.model)
    figures, *further = document.figures(prepared, problem, models)
    errors = {f.hypothesis.key: _error(prepared, ruler.delivered(f.model), figures) for f in ranked}
    effects: tuple[NamedEffect, ...] = document.tabulated(judgement.learned)
    alternatives: tuple[Alternative, ...] = ()
    rivals: list[Fitted] = []
    if named is not None and believed is not None:
        rivals = [f for f in believed.members if f.hypothesis.key != named.hypothesis.key]
        sure = judgement.verdict != "ambiguous"
        depths = {e.name: believed.depth(e) if sure else None for e in named.hypothesis.effects}
        effects = (*document.named(delivered, known_to, depths), *effects)
        alternatives = document.alternatives(named, rivals, ranked, believed, errors)
    told = figures.heldout_nrmse.refit
    diagnosis = Diagnosis(
        verdict=judgement.verdict,
        summary="",
        budget=judgement.shares,
        effects=effects,
        alternatives=alternatives,
        parameters=wrong,
        mismatch=Mismatch() if nothing else locate(problem, judgement.refit, ranked, named, judgement.shapes),
        fit=figures,
        model="augmented_model.yaml",
        preflight=prepared.findings,
        candidates=document.candidates(told, named, ranked, rivals, errors, believed),
        tried=judgement.tried,
        untried=judgement.untried,
        recordings=tuple(recording.source for recording in prepared.recordings),
        further_fits=tuple(further),
    )
    diagnosis = replace(diagnosis, summary=summary_of(diagnosis, at_bounds(judgement.refit)))
    return Outcome(diagnosis, prepared, model, judgement.refit, delivered, normal, tuple(ranked))


def refused(prepared: Prepared, model: Structure, reason: str | None = None) -> Outcome:
    """The outcome where recordings cannot say anything, but for the time it took.

    Args:
        prepared: the recordings as they were used.
        model: the model handed in.
        reason: why, where it is not the check before the diagnosis that refused them.
    """
    diagnosis = Diagnosis(
        verdict="insufficient_data",
        summary=reason or prepared.reason or "Nothing in these recordings moves.",
        preflight=prepared.findings,
        recordings=tuple(recording.source for recording in prepared.recordings),
    )
    return Outcome(diagnosis, prepared, model)


def _error(prepared: Prepared, model: Structure, fit: Fit) -> float | None:
    """The contract's held-out error of a model; None where its simulation of the raw recording diverges."""
    try:
        return heldout_nrmse(prepared.recordings[0], model, fit.heldout_s, fit.axes)
    except MmtError:
        return None
