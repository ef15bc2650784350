"""Outcomes of diagnoses whose answer is known, put together without a search."""

from collections.abc import Mapping
from dataclasses import replace

from diagnosis_samples import MODEL, contact_recording
from trial_samples import beside

from mmt_drake.diagnosis.fit.errors import HeldOutPart, intervals_of
from mmt_drake.diagnosis.fit.prepare import Prepared, prepare
from mmt_drake.diagnosis.fit.problem import Fitted
from mmt_drake.diagnosis.tell.outcome import Outcome
from mmt_drake.diagnosis.tell.result import Diagnosis, EffectParameter, Fit, HeldoutNrmse, NamedEffect
from mmt_drake.model.parameters import NormalContact
from mmt_drake.model.structure import Structure
from mmt_drake.recording import Recording

FRICTION = 0.4
WRONG = replace(MODEL, normal=NormalContact(k=370.0, b=10.0))


def fitted(prepared: Prepared, model: Structure, starts: Mapping[str, Mapping[str, float]] | None = None) -> Fitted:
    """The model fitted, with effects from these starting values."""
    assert prepared.problem is not None
    hypothesis = beside(*starts or (), nominal=model, skew=prepared.skew)
    return prepared.problem.fit(hypothesis, hypothesis.vector({}, starts or {}))


def rubbing_box(noise: float = 1.0) -> Recording:
    """The box of `MODEL` with Coulomb friction."""
    return contact_recording(friction=FRICTION, noise=noise)


def outcome(recording: Recording, model: Structure, starts: Mapping[str, Mapping[str, float]]) -> Outcome:
    """What a diagnosis ends with that has found these effects."""
    prepared = prepare([recording], model)
    assert prepared.problem is not None
    refit, best = fitted(prepared, model), fitted(prepared, model, starts)
    track = prepared.problem.tracks[0]
    axes = tuple(track.axis for track in prepared.problem.tracks)
    held = HeldOutPart(recording, intervals_of(track.time, track.heldout), track.smoothed, axes)
    found = [
        NamedEffect(e.name, e.family, e.block, "law", {p: EffectParameter(v, "") for p, v in values.items()})
        for e, values in zip(best.hypothesis.effects, best.hypothesis.effect_values(best.x).values(), strict=True)
    ]
    diagnosis = Diagnosis(
        verdict="missing_physics",
        summary="",
        effects=tuple(found),
        fit=Fit(
            axes=axes if recording.kind == "contact" else (),
            heldout_s=held.blocks,
            noise_floor=held.floor(best.model),
            heldout_nrmse=HeldoutNrmse(*(held.nrmse(one) for one in (model, refit.model, best.model))),
        ),
    )
    return Outcome(diagnosis, prepared, model, refit, best)
