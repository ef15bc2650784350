"""One look at a contact: whence its fits begin, and what of its answer is told."""

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from mmt_drake.diagnosis.decide.verdict import Verdict
from mmt_drake.diagnosis.tell.outcome import Outcome
from mmt_drake.diagnosis.tell.result import NamedEffect
from mmt_drake.errors import MmtError
from mmt_drake.estimation.output_error.options import Prior
from mmt_drake.learner_status import LearnerStatus
from mmt_drake.learning import answer
from mmt_drake.learning.answer import ROW, LookResult, answer_of, look
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel, NormalContact
from mmt_drake.model_message import UNKNOWN_THETA, ModelMessage, SensorError
from mmt_drake.recording import Recording

THETA = np.array([0.03, 0.0, 520.0, 66.0, 60.0, 0.5, 500.0, 60.0, 0.5, 0.0])


def asked(
    monkeypatch: pytest.MonkeyPatch, found: LookResult, fails: int = 0, free: int = 100, seen: int = 1000
) -> tuple[LookResult, list[FlexibleBoxModel]]:
    """What a look at 2 s of contact, after so many free samples, makes of an answer after so many failures.

    And its models; the diagnosis sees so many samples.
    """
    models: list[FlexibleBoxModel] = []

    def diagnose(
        recordings: list[Recording], model: FlexibleBoxModel, executor: object, next_motion: bool
    ) -> LookResult:
        assert len(recordings[0]) == seen and recordings[0].time[0] == 0.0 and not next_motion
        models.append(model)
        if len(models) <= fails:
            raise MmtError("the simulation diverges at the start of a fit")
        return found

    monkeypatch.setattr(answer, "diagnose", diagnose)
    monkeypatch.setattr(answer, "answer_of", lambda outcome: outcome)
    rows = np.zeros((free + 1000, ROW))
    rows[free:, -1] = 1.0
    return look(rows, 0.002, THETA, 10.0, None), models


def test_a_look_begins_with_the_estimator_s_numbers_and_where_these_are_no_object_s_with_the_prior(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    _, models = asked(monkeypatch, LookResult("parameters"), fails=1)
    assert [model.parameters.m for model in models] == [0.05, Prior().m]
    assert models[0].parameters.k2 == 520.0 and models[1].parameters.k2 == Prior().k2
    with pytest.raises(MmtError, match="diverges"):
        asked(monkeypatch, LookResult("parameters"), fails=2)


@pytest.mark.parametrize(("free", "first"), [(100, 10.2), (149, 10.298), (150, 10.0), (500, 10.0)])
def test_a_drift_that_a_look_finds_is_told_by_the_clock_of_the_run(
    monkeypatch: pytest.MonkeyPatch, free: int, first: float
) -> None:
    """Of free space before the touch, 0.3 s and more is looked at."""
    drifts = LookResult("missing_physics", sensor=SensorError(bias=0.5, rate=0.1))
    found, _ = asked(monkeypatch, drifts, free=free, seen=1000 + (free if first == 10.0 else 0))
    assert found.sensor.bias + 0.1 * first == pytest.approx(0.5), "at the first sample"
    assert found.sensor.rate == 0.1


def named(law: str, values: dict[str, float], verdict: Verdict = "missing_physics") -> LookResult:
    """What a look makes of a diagnosis that names a law, for sure."""
    effect = NamedEffect(law, "a_family", "contact", "law", {})
    model = FlexibleBoxModel(BoxParameters(Fc=0.4), NormalContact())
    hypothesis = SimpleNamespace(effect_values=lambda x: {law: values}, handed=lambda x: SimpleNamespace(bare=model))
    outcome = SimpleNamespace(
        diagnosis=SimpleNamespace(verdict=verdict, effects=[effect]),
        best=SimpleNamespace(hypothesis=hypothesis, x=None),
    )
    return answer_of(cast(Outcome, outcome))


def test_a_law_is_told_with_all_its_numbers_so_that_it_can_be_told_again_of_another_object() -> None:
    (bristles,) = named("presliding_friction", {"sigma0": 500.0}).laws
    assert bristles.parameters == {"sigma0": 500.0, "sigma1": 0.0, "Fs": 0.4, "v_s": 1e-3}
    assert ModelMessage(UNKNOWN_THETA, (bristles,), number=2).acting


@pytest.mark.parametrize(
    ("verdict", "status"),
    [
        ("missing_physics", LearnerStatus.TOLD),
        ("partly_explained", LearnerStatus.NOT_FELT),
        ("ambiguous", LearnerStatus.NOT_FELT),
    ],
)
def test_a_law_is_told_only_where_all_is_explained_and_else_it_says_why_not(
    verdict: Verdict, status: LearnerStatus
) -> None:
    found = named("nonlinear_stiffness", {"k3": 3e6}, verdict)
    assert found.status == status and bool(found.laws) == (verdict == "missing_physics")
    expected = "missing_physics, which explains it all"
    why = () if found.laws else (f"nonlinear_stiffness: found verdict {verdict}, expected {expected}",)
    assert found.refused == why
