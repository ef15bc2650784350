"""What is drawn is what was measured: forces read off the recording have the shape that was hidden in it."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_samples import B1, K2, MODEL
from outcome_samples import FRICTION, WRONG, fitted, outcome, rubbing_box

from mmt_drake.diagnosis.fit.prepare import prepare
from mmt_drake.diagnosis.tell.evidence import Evidence
from mmt_drake.diagnosis.tell.force_curves import curves_of, without_sensor
from mmt_drake.diagnosis.tell.outcome import Outcome
from mmt_drake.diagnosis.tell.pictured import pictures_of
from mmt_drake.effects import LIBRARY
from mmt_drake.model.driven_model import DrivenBodyModel
from mmt_drake.recording import Recording
from mmt_drake.replay import replayed


@pytest.fixture(scope="module")
def found() -> Outcome:
    """Of the rubbing box."""
    return outcome(rubbing_box(), WRONG, {"coulomb_friction": {"Fc": 0.2}})


@pytest.fixture(scope="module")
def evidence(found: Outcome) -> Evidence:
    """Of its one axis along the surface."""
    piece, _ = pictures_of(found)
    return piece


def test_models_are_those_that_the_figures_are_of(found: Outcome, evidence: Evidence) -> None:
    recording, errors = found.prepared.recordings[0], found.diagnosis.fit.heldout_nrmse
    assert evidence.label == "made.csv, y"
    assert evidence.heldout_s == found.diagnosis.fit.heldout_s
    np.testing.assert_array_equal(evidence.measured.values, recording["force_y"])
    np.testing.assert_array_equal(evidence.counted, recording["in_contact"] == 1.0)
    _, normal = pictures_of(found)
    assert normal.label == "made.csv, z" and set(normal.states) == {"depth", "depth_rate"}
    chosen = evidence.heldout & evidence.counted
    spread = np.std([recording["force_y"][chosen], recording["force_z"][chosen]])
    for name, residual in evidence.residuals.items():
        both = [residual[chosen], normal.residuals[name][chosen]]
        assert np.sqrt(np.mean(np.square(both))) / spread == pytest.approx(getattr(errors, name), rel=1e-9), name


def test_the_noise_is_what_the_right_model_leaves(evidence: Evidence) -> None:
    left = evidence.residuals["augmented"][evidence.counted]
    assert np.sqrt(np.mean(left**2)) == pytest.approx(evidence.noise, rel=0.05)
    spectrum = evidence.spectrum
    band = (spectrum.frequency > 20.0) & (spectrum.frequency < 400.0)
    assert np.mean(spectrum.residuals["augmented"][band]) == pytest.approx(np.mean(spectrum.noise[band]), rel=0.1)
    low = (spectrum.frequency > 0.2) & (spectrum.frequency < 3.0)
    assert np.mean(spectrum.residuals["refit"][low]) > 100.0 * np.mean(spectrum.noise[low])


def test_the_friction_curve_shows_what_was_hidden(evidence: Evidence) -> None:
    v, force = evidence.friction.over.values, evidence.friction.force.values
    slides = np.abs(v) > 0.01
    beside = (force - B1 * v)[slides] * np.sign(v[slides])
    assert np.median(beside) == pytest.approx(FRICTION, rel=0.05)
    assert np.quantile(np.abs(evidence.friction.models["augmented"] - force)[slides], 0.99) < 0.1
    before = evidence.friction.models["refit"]
    assert np.abs(before[np.abs(v) < 1e-4]).max() < 0.05  # a damper alone has none at rest


def test_friction_shows_even_before_it_is_in_the_model() -> None:
    """The residual of a model without it, turned into a force on the body, is Coulomb's law."""
    prepared = prepare([rubbing_box()], MODEL)
    track = prepared.problem.tracks[0]
    _, curve = curves_of(track, MODEL, None, frozenset())
    assert "augmented" not in curve.models
    v = curve.over.values
    slides = np.abs(v) > 0.03
    beside = (curve.force.values - B1 * v)[slides] * np.sign(v[slides])
    assert np.median(beside) == pytest.approx(FRICTION, rel=0.1)


def test_the_restoring_curve_has_the_spring_of_the_contact(evidence: Evidence) -> None:
    d, force = evidence.restoring.over.values, evidence.restoring.force.values
    slope = float(d @ force / (d @ d))
    assert slope == pytest.approx(K2, rel=0.02)


def test_states_are_on_the_recording_s_clock(found: Outcome, evidence: Evidence) -> None:
    assert set(evidence.states) == {"sliding_velocity", "deflection", "deflection_rate", "position", "load"}
    recording = found.prepared.recordings[0]
    z, rate = recording["position_z"], recording["velocity_z"]
    normal = found.best.model.normal
    load = np.where(evidence.counted, np.maximum(-normal.k * z - normal.b * rate, 0.0), 0.0)
    inner = slice(200, -200)
    np.testing.assert_allclose(evidence.states["load"].values[inner].mean(), load[inner].mean(), rtol=0.02)


def test_without_a_fit_there_is_the_nominal_model_alone(found: Outcome) -> None:
    piece, _ = pictures_of(replace(found, refit=None, best=None))
    assert list(piece.models) == ["nominal"]
    assert piece.friction is None
    assert piece.restoring is None


def test_a_perfect_sensor_has_no_bias_and_no_delay() -> None:
    biased = LIBRARY["force_bias"].apply(MODEL, {"bias": 0.3})
    late = LIBRARY["time_delay"].apply(biased, {"delay": 0.02})
    drag = LIBRARY["quadratic_drag"].apply(late, {"c": 2.0})
    bare = without_sensor(drag)
    assert bare.additions.delay == 0.0
    assert len(bare.additions.laws) == 1
    recording = rubbing_box(noise=0.0)
    expected = replayed(LIBRARY["quadratic_drag"].apply(MODEL, {"c": 2.0}), recording)
    np.testing.assert_array_equal(replayed(bare, recording)["force_y"], expected["force_y"])


def servo(friction: float) -> tuple[Recording, DrivenBodyModel]:
    """A driven body with Coulomb friction, and the model without."""
    t = np.arange(15000) / 500.0
    u = 3.0 * np.sin(2 * np.pi * 0.7 * t) + 2.0 * np.sin(2 * np.pi * 0.31 * t + 1.0)
    true = DrivenBodyModel(m=1.0, b=5.0, k=20.0, Fc=friction)
    empty = Recording(t, {"input": u, "output": np.zeros(len(t))}, "servo.csv")
    noise = 2e-5 * np.random.default_rng(1).standard_normal(len(t))
    output = replayed(true, empty)["output"] + noise
    return replace(empty, columns={"input": u, "output": output}), replace(true, Fc=0.0)


def test_a_driven_body_s_friction_is_read_off_its_motion() -> None:
    recording, model = servo(0.5)
    found = outcome(recording, model, {"coulomb_friction": {"Fc": 0.2}})
    (piece,) = pictures_of(found)
    assert piece.axis == ""
    assert piece.restoring is None  # friction was found: the spring is as the model has it
    v, force = piece.friction.over.values, piece.friction.force.values
    slides = np.abs(v) > 0.05
    beside = (force - 5.0 * v)[slides] * np.sign(v[slides])
    assert np.median(beside) == pytest.approx(0.5, rel=0.05)
    assert fitted(found.prepared, model).cost > found.best.cost


def test_the_noise_of_windows_is_known_though_their_lead_ins_are_not_scored() -> None:
    recording, model = servo(0.5)
    noisy = recording["input"] + 0.05 * np.random.default_rng(2).standard_normal(len(recording))
    recording = replace(recording, columns={**recording.columns, "input": noisy})
    (piece,) = pictures_of(outcome(recording, replace(model, window_s=2.5), {"coulomb_friction": {"Fc": 0.2}}))
    assert 2e-5 < piece.noise < 1e-3 and piece.spectrum is not None and np.isfinite(piece.spectrum.noise).all()
