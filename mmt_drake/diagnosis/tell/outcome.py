"""The outcome of a diagnosis: in fits, and as the document that is written and read."""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from mmt_drake.diagnosis.checks.finding import Finding
from mmt_drake.diagnosis.decide.budget import NAMELESS, SHARED, BudgetPart, Ruler
from mmt_drake.diagnosis.decide.confidence import ConfidenceSet
from mmt_drake.diagnosis.decide.depth import (
    MOST_NAMELESS,
    Depth,
    beside_another_curve,
    beside_another_size,
    beside_its_block,
    beside_its_kin,
    beside_the_nameless,
    beside_the_untried,
)
from mmt_drake.diagnosis.decide.exchange import as_good_kin
from mmt_drake.diagnosis.decide.gate import NoiseReference, leaves_much_of
from mmt_drake.diagnosis.decide.locate import locate
from mmt_drake.diagnosis.decide.mismatch import Mismatch
from mmt_drake.diagnosis.decide.verdict import NAMING, Verdict
from mmt_drake.diagnosis.fit.comparison import at_bounds
from mmt_drake.diagnosis.fit.prepare import Prepared
from mmt_drake.diagnosis.fit.problem import Fitted
from mmt_drake.diagnosis.fit.validate import intervals, of_no_mass, within_reach_of_nothing
from mmt_drake.diagnosis.search.learn import Learned
from mmt_drake.diagnosis.tell import document
from mmt_drake.diagnosis.tell.prescribe import Prescription
from mmt_drake.diagnosis.tell.reasons import Reasons
from mmt_drake.diagnosis.tell.result import Alternative, Diagnosis, NamedEffect
from mmt_drake.diagnosis.tell.summary import summary_of
from mmt_drake.effects import LIBRARY
from mmt_drake.effects.effect import Effect
from mmt_drake.errors import attempt
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
        candidates: all that was tried, best first.
        prescription: what to record next, where explanations remain that these recordings cannot tell apart.
    """

    diagnosis: Diagnosis
    prepared: Prepared
    nominal: Structure
    refit: Fitted | None = None
    best: Fitted | None = None
    candidates: tuple[Fitted, ...] = ()
    prescription: Prescription | None = None

    def __repr__(self) -> str:
        return f"Outcome({self.diagnosis!r})"

    def _repr_html_(self) -> str:
        return self.diagnosis._repr_html_()

    @property
    def fits(self) -> dict[str, Fitted]:
        """`refit`, and `augmented` where `best` has effects; empty where nothing was fitted."""
        known = {"refit": self.refit, "augmented": self.best if self.best and self.best.hypothesis.effects else None}
        return {name: fitted for name, fitted in known.items() if fitted is not None}

    @property
    def models(self) -> dict[str, Structure]:
        """`nominal` and the models of `fits`."""
        return {"nominal": self.nominal} | {name: f.model for name, f in self.fits.items()}

    @property
    def blocks(self) -> frozenset[str]:
        """That the effects found act in."""
        if self.best is None:
            return frozenset()
        values, effects = self.best.effect_values, self.best.hypothesis.effects
        return frozenset(e.block if e.block_of is None else e.block_of(values[e.name]) for e in effects)


@dataclass(frozen=True)
class Judgement:
    """A verdict and the fits that it was given on.

    Attributes:
        verdict: the verdict.
        standard: what the fits were held to; its problem is theirs.
        refit: the fit of the model's own parameters.
        best: the fit that is delivered, but for a table.
        shares: the budget of what is delivered.
        ranked: all that was tried and is listed, best first.
        believed: what is not ruled out; None where nothing is named.
        tried: how many sets of effects were tried.
        untried: what there was no time for.
        learned: the table that is delivered beside it, for what has no name.
        shapes: all the tables that were learned.
        bent: effects that depend on a signal in another way than their law says.
        of_refit: what part its effects take off what a refit leaves beyond the noise, on held-out data.
    """

    verdict: Verdict
    standard: NoiseReference
    refit: Fitted
    best: Fitted
    shares: tuple[BudgetPart, ...]
    ranked: Sequence[Fitted] = ()
    believed: ConfidenceSet | None = None
    tried: int = 0
    untried: tuple[str, ...] = ()
    learned: Learned | None = None
    shapes: Sequence[Learned] = ()
    bent: frozenset[str] = frozenset()
    of_refit: float = 1.0

    @property
    def named(self) -> Fitted | None:
        """The fit whose effects are named."""
        return self.best if self.verdict in NAMING else None

    @property
    def delivered(self) -> Fitted:
        """The fit of the model that is delivered."""
        return self.best if self.learned is None else self.learned.fitted


def outcome_of(prepared: Prepared, model: Structure, judgement: Judgement, alike: Sequence[Finding] = ()) -> Outcome:
    """The document of a judgement, its figures simulated, and what it rests on, but for the time it took.

    Args:
        prepared: the recordings as they were used.
        model: the model handed in.
        judgement: what was found.
        alike: what else its numbers may stand for.
    """
    problem, named, delivered = judgement.standard.problem, judgement.named, judgement.delivered
    ruler = Ruler(prepared, problem)
    ranked, believed = judgement.ranked, judgement.believed
    nothing = judgement.verdict == "no_mismatch"
    known_to = intervals(problem, delivered)
    wrong = {} if nothing else document.parameters(delivered, known_to)
    models = model, judgement.refit.model, delivered.model
    figures, *further = (document.figures(held, models) for held in ruler.heldout)
    errors = {f.hypothesis.key: _error(ruler, f) for f in ranked}
    reasons = Reasons(named, figures.heldout_nrmse.refit, errors, believed, ranked)
    effects: tuple[NamedEffect, ...] = document.tabulated(judgement.learned)
    alternatives: tuple[Alternative, ...] = ()
    rivals: list[Fitted] = []
    if named is not None and believed is not None:
        rivals = [f for f in believed.members if f.hypothesis.key != named.hypothesis.key]
        fitted = {e.name for e in delivered.hypothesis.effects if delivered.hypothesis.fitted_parameters(e)}
        unsure = fitted & within_reach_of_nothing(delivered, known_to)  # a learned surface has no such number
        unsure |= judgement.bent | of_no_mass(delivered, known_to) | as_good_kin(named, ranked, errors)
        if leaves_much_of(judgement.of_refit):
            unsure |= named.hypothesis.key
        depths = beside_its_block(
            {e: _depth(e, named, believed, judgement, e.name in unsure) for e in named.hypothesis.effects}
        )
        effects = (*document.named(delivered, known_to, depths), *effects)
        alternatives = document.alternatives(named, rivals, ranked, believed, reasons)
    mismatch = Mismatch() if nothing else locate(problem, judgement.refit, ranked, named, judgement.shapes)
    by_axis = tuple(replace(one, mismatch=mismatch.axes.get(one.axis)) for one in figures.by_axis)
    diagnosis = Diagnosis(
        verdict=judgement.verdict,
        summary="",
        budget=judgement.shares,
        effects=effects,
        alternatives=alternatives,
        parameters=wrong,
        curves=document.curves(delivered, known_to),
        mismatch=mismatch,
        fit=replace(figures, by_axis=by_axis),
        model="augmented_model.yaml",
        preflight=(*prepared.findings, *alike),
        candidates=document.candidates(ranked, rivals, reasons),
        tried=judgement.tried,
        untried=tuple(one for one in judgement.untried if named is None or _key(one) != named.hypothesis.key),
        recordings=tuple(recording.source for recording in prepared.recordings),
        further_fits=tuple(further),
        at_bounds=tuple(sorted(at_bounds(judgement.refit))),
    )
    diagnosis = replace(diagnosis, summary=summary_of(diagnosis))
    return Outcome(diagnosis, prepared, model, judgement.refit, delivered, tuple(ranked))


def _depth(
    effect: Effect, named: Fitted, believed: ConfidenceSet, judgement: Judgement, may_be_other: bool
) -> Depth | None:
    """How deep the name of an effect holds; None where not even its block is sure.

    Args:
        effect: of the set that is named.
        named, believed, judgement: that set, those that are not ruled out, and what was made of them.
        may_be_other: whether it may be another law of its family, whatever was tried.
    """
    if judgement.verdict == "ambiguous":
        return None
    shares = defaultdict(float, {part.part: part.share for part in judgement.shares})
    own, nameless = shares[effect.name], shares[NAMELESS]
    untried = _untried_for(effect, named, judgement.untried, nameless > MOST_NAMELESS * own)
    depth = beside_the_nameless(believed.depth(effect), own, nameless, may_be_other, shares[SHARED])
    depth = beside_another_size(depth, effect, {e: shares[e.name] for e in named.hypothesis.effects})
    depth = beside_another_curve(depth, effect, named.hypothesis.effects, judgement.bent)
    return beside_the_untried(beside_its_kin(depth, effect, named.hypothesis.effects), effect, untried)


def _untried_for(effect: Effect, named: Fitted, untried: Iterable[str], more_is_missing: bool = False) -> list[Effect]:
    """Effects that, with the rest of a set that is named, there was no time to try in the place of one.

    Where more is missing that has no name, they may have come with a further effect, which takes that.
    """
    sets = [_key(names) for names in untried]
    further = [names - named.hypothesis.key for names in sets if effect.name not in names]
    most = 2 if more_is_missing else 1
    found = {name for others in further if len(others) <= most for name in others if name in LIBRARY}
    return [LIBRARY[name].within(named.hypothesis.nominal) for name in sorted(found)]


def _key(names: str) -> frozenset[str]:
    """The set of effects of a name that stands for all of them."""
    return frozenset(names.split(" + "))


def refused(prepared: Prepared, model: Structure, reason: str | None = None) -> Outcome:
    """The outcome where recordings cannot say anything, but for the time it took.

    Args:
        prepared: the recordings as they were used.
        model: the model handed in.
        reason: why, where it is not the check before the diagnosis that refused them.
    """
    diagnosis = Diagnosis(
        verdict="insufficient_data",
        summary=reason or prepared.refusal,
        preflight=prepared.findings,
        recordings=tuple(recording.source for recording in prepared.recordings),
    )
    return Outcome(diagnosis, prepared, model)


def _error(ruler: Ruler, fitted: Fitted) -> float | None:
    """The contract's held-out error of the model of a fit; None where its simulation of the raw recording diverges."""
    return attempt(ruler.heldout[0].nrmse, fitted.model)
