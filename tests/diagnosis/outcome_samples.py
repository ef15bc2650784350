"""Outcomes of diagnoses whose answer is known, put together without a search."""

from collections.abc import Mapping
from dataclasses import replace

from diagnosis_samples import MODEL, contact_recording

from mmt_drake.diagnosis.fit.errors import heldout_nrmse, intervals_of, noise_floor
from mmt_drake.diagnosis.fit.hypothesis import Hypothesis
from mmt_drake.diagnosis.fit.prepare import Prepared, prepare
from mmt_drake.diagnosis.fit.problem import Fitted
from mmt_drake.diagnosis.tell.outcome import Outcome
from mmt_drake.diagnosis.tell.result import Diagnosis, EffectParameter, Fit, HeldoutNrmse, NamedEffect
from mmt_drake.effects import LIBRARY
from mmt_drake.model.parameters import NormalContact
from mmt_drake.model.structure import Structure
from mmt_drake.recording import Recording

FRICTION = 0.4
WRONG = replace(MODEL, normal=NormalContact(k=370.0, b=10.0))


def fitted(prepared: Prepared, model: Structure, starts: Mapping[str, Mapping[str, float]] | None = None) -> Fitted:
    """The model fitted, with effects from these starting values."""
    assert prepared.problem is not None
    hypothesis = Hypothesis(model, prepared.skew)
    for name in starts or {}:
        hypothesis = hypothesis.adding(LIBRARY[name])
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
    blocks = intervals_of(track.time, track.heldout)
    after = best.model
    errors = [heldout_nrmse(recording, one, blocks, axes) for one in (model, refit.model, after)]
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
            heldout_s=blocks,
            noise_floor=noise_floor(recording, after, blocks, axes, track.smoothed),
            heldout_nrmse=HeldoutNrmse(*errors),
        ),
    )
    return Outcome(diagnosis, prepared, model, refit, best)
