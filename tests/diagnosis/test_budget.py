"""What the error of a model is made of: shares that sum to 1, booked to what they come from."""

import math
from dataclasses import replace
from types import SimpleNamespace

import pytest
from trial_samples import COULOMB, beside, changed, model, recorded

from mmt_drake.diagnosis.decide.budget import NAMELESS, NOISE, PARAMETERS, Ruler, budget
from mmt_drake.diagnosis.fit.prepare import prepare

START = {"coulomb_friction": {"Fc": 0.3}, "force_bias": {"bias": 0.1}}
RUBBING = recorded(COULOMB, seed=3, seconds=10.0)
BOTH = recorded(COULOMB, ("force_bias", (("bias", 0.2),)), seed=3, seconds=10.0)


def shares(recording, nominal, *names, wrong=(), steps=30):
    """Part -> share of the budget with these effects fitted."""
    prepared = prepare([recording], nominal)
    assert prepared.problem is not None
    hypothesis = beside(*names, nominal=nominal, skew=prepared.skew)
    best = prepared.problem.fit(hypothesis, hypothesis.vector({}, START), steps=steps)
    parts = budget(Ruler(prepared, prepared.problem), nominal, best, wrong, {})
    assert sum(part.share for part in parts) == pytest.approx(1.0, abs=1e-12)
    assert all(part.share >= 0.0 for part in parts)
    return {part.part: part.share for part in parts}


def test_friction_alone_is_booked_to_friction_though_a_refit_would_hide_it_in_the_damper():
    found = shares(RUBBING, model(), "coulomb_friction", wrong=("b1", "m"))
    assert found[PARAMETERS] <= 0.02 and found["coulomb_friction"] > 0.9 and found[NAMELESS] < 0.02


def test_a_wrong_damper_alone_is_booked_to_the_parameters():
    found = shares(recorded(seed=3, seconds=10.0), model(b1=15.0), wrong=("b1",))
    assert found[PARAMETERS] > 0.9 and found[NAMELESS] < 0.02


def test_two_effects_are_booked_each_to_its_own_whatever_the_order():
    one = shares(BOTH, model(), "coulomb_friction", "force_bias")
    other = shares(BOTH, model(), "force_bias", "coulomb_friction")
    assert one["coulomb_friction"] == pytest.approx(other["coulomb_friction"], rel=0.02)
    assert min(one["coulomb_friction"], one["force_bias"]) > 0.1


def test_what_is_unique_to_an_effect_is_what_comes_back_without_it_when_all_else_is_fitted_again():
    prepared = prepare([RUBBING], model())
    plain, rubbing = (beside(*names, skew=prepared.skew) for names in ((), ("coulomb_friction",)))
    best = prepared.problem.fit(rubbing, rubbing.vector({}, START), steps=30)
    as_handed_in = prepared.problem.unchanged(plain, plain.base())
    for without, missed in ((best, 0.0), (as_handed_in, 1.0)):
        parts = budget(Ruler(prepared, prepared.problem), model(), best, (), {"coulomb_friction": without})
        found = {part.part: part for part in parts}
        gone = 1.0 - found[NAMELESS].share - found[NOISE].share
        assert found["coulomb_friction"].unique == pytest.approx(missed * gone, abs=1e-12)


def test_where_the_model_without_an_effect_diverges_nobody_knows_what_is_unique_to_it(monkeypatch):
    prepared = prepare([RUBBING], model())
    rubbing, diverging, of = beside("coulomb_friction", skew=prepared.skew), SimpleNamespace(model=None), Ruler.of
    best = prepared.problem.fit(rubbing, rubbing.vector({}, START), steps=30)
    monkeypatch.setattr(Ruler, "of", lambda self, model: math.inf if model is None else of(self, model))
    parts = budget(Ruler(prepared, prepared.problem), model(), best, (), {"coulomb_friction": diverging})
    found = {part.part: part for part in parts}
    assert found["coulomb_friction"].unique is None and found["coulomb_friction"].share > 0.9


def test_recordings_count_in_a_budget_as_they_do_in_the_fit():
    slow = changed(RUBBING, **{name: 0.1 * RUBBING[name] for name in ("force_x", "force_y", "force_z")})
    prepared = prepare([RUBBING, slow], model())
    for counts in (1.0, 0.1):
        first, other = prepared.problem.by_recording()
        tracks = (*first, *(replace(track, counts=counts) for track in other))
        ruler = Ruler(prepared, replace(prepared.problem, tracks=tracks))
        loud, quiet = (held.error(model()) for held in ruler.heldout)
        assert quiet.ratio > 8.0, "of ten times the force that was measured"
        share = (counts * first[0].floor / other[0].floor) ** 2
        expected = (loud.rms**2 + share * quiet.rms**2) / (loud.spread**2 + share * quiet.spread**2)
        assert ruler.of(model()) == pytest.approx(expected, rel=1e-9)


def test_what_is_not_in_the_model_has_no_name():
    found = shares(BOTH, model(), "coulomb_friction")
    assert found[NAMELESS] > 0.1 and found[NOISE] < 0.05


def test_a_fit_that_is_worse_than_the_model_handed_in_explains_nothing():
    prepared = prepare([RUBBING], model())
    hypothesis = beside(skew=prepared.skew)
    worse = prepared.problem.unchanged(hypothesis, hypothesis.vector({"b1": 5.0}, {}))
    parts = {p.part: p.share for p in budget(Ruler(prepared, prepared.problem), model(), worse, ("b1",), {})}
    assert parts[PARAMETERS] == 0.0 and parts[NAMELESS] + parts[NOISE] == pytest.approx(1.0)


def test_a_model_that_is_right_to_the_last_bit_leaves_noise_alone(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(Ruler, "of", lambda self, model: 0.0)
    assert shares(RUBBING, model(), "coulomb_friction", steps=1)[NOISE] == 1.0


def test_a_body_that_loses_more_mass_than_was_handed_in_has_a_budget_all_the_same():
    nominal, lost = model(m=0.3), {"mass_change": {"time": 9.0, "dm": -0.5}}
    prepared = prepare([RUBBING], nominal)
    hypothesis = beside("mass_change", nominal=nominal, skew=prepared.skew)
    best = prepared.problem.unchanged(hypothesis, hypothesis.vector({"m": 1.0}, lost))
    parts = budget(Ruler(prepared, prepared.problem), nominal, best, ("m",), {})
    assert sum(part.share for part in parts) == pytest.approx(1.0)
