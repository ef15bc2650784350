"""The summary of a diagnosis: the verdict, the figures, the place, and what to keep in mind of the recordings."""

from dataclasses import replace

import pytest

from mmt_drake.diagnosis.checks.finding import Finding
from mmt_drake.diagnosis.decide.budget import BudgetPart
from mmt_drake.diagnosis.decide.mismatch import BlockShare, Dependence, Mismatch
from mmt_drake.diagnosis.tell.report_text import headline
from mmt_drake.diagnosis.tell.result import Diagnosis, EffectParameter, Fit, FittedParameter, HeldoutNrmse, NamedEffect
from mmt_drake.diagnosis.tell.summary import MOST_WARNINGS, summary_of

GAPS = Finding("gaps", "warn", "No samples for 1 s in all.")
BIAS = Finding("bias", "warn", "In free space the sensor is off zero: force_y 0.25 N.")
CLIPPED = Finding("saturation", "warn", "force_y stands at exactly 2 in 8 % of the samples.")
CLOCK = Finding("clock", "note", "1000 samples/s on an even clock.")
FIT = Fit(("y",), ((3.0, 4.0),), 0.02, HeldoutNrmse(0.4, 0.1, 0.021), spread=2.0, unit="N")


def named(name: str, symbol: str, value: float, unit: str) -> NamedEffect:
    return NamedEffect(name, "sensor", "force_sensor", "law", {symbol: EffectParameter(value, unit)})


def test_what_the_check_warned_of_is_said_whatever_the_verdict():
    for verdict in ("no_mismatch", "unexplained"):
        told = summary_of(Diagnosis(verdict, "", fit=FIT, preflight=(GAPS, BIAS)))
        assert told.endswith(f"Keep in mind: {GAPS.text} {BIAS.text}") and "\n" not in told


def test_what_is_only_noted_is_not_in_the_summary():
    assert "Keep in mind" not in summary_of(Diagnosis("no_mismatch", "", preflight=(CLOCK,)))
    assert CLOCK.text not in summary_of(Diagnosis("no_mismatch", "", preflight=(GAPS, CLOCK)))


def test_a_warning_that_an_effect_accounts_for_is_not_said_twice():
    bias, limit = named("force_bias", "bias", 0.25, "N"), named("force_saturation", "limit", 2.0, "N")
    told = summary_of(Diagnosis("missing_physics", "", effects=(bias,), preflight=(BIAS, CLIPPED)))
    assert BIAS.text not in told and told.endswith(f"Keep in mind: {CLIPPED.text}")
    assert "Keep in mind" not in summary_of(
        Diagnosis("missing_physics", "", effects=(bias, limit), preflight=(BIAS, CLIPPED))
    )


def test_a_crowd_of_warnings_is_counted():
    warnings = tuple(Finding("bias", "warn", f"Warning {i}.") for i in range(MOST_WARNINGS + 2))
    told = summary_of(Diagnosis("no_mismatch", "", preflight=warnings))
    assert f"Warning {MOST_WARNINGS - 1}. And 2 more (see the report)." in told
    assert f"Warning {MOST_WARNINGS}." not in told


def test_a_refusal_stays_as_it_is():
    refused = Diagnosis("insufficient_data", "Nothing moves.", preflight=(Finding("motionless", "refuse", "Nothing."),))
    assert summary_of(refused) == "Nothing moves."


def test_errors_with_what_was_missing_stand_beside_those_without():
    friction = named("coulomb_friction", "Fc", 0.4, "N")
    told = summary_of(Diagnosis("missing_physics", "", effects=(friction,), fit=FIT))
    assert told == (
        "The model leaves out Coulomb friction (Fc = 0.4 N). On held-out data the RMS error is 0.8 N with the model "
        "handed in, 0.2 N with its parameters fitted, 0.042 N with what was missing; noise alone would leave 0.04 N."
    )


def test_the_budget_comes_first_and_names_say_how_deep_they_hold():
    parts = (BudgetPart("parameters", 0.301), BudgetPart("force_bias", 0.5), BudgetPart("shared", 0.0))
    parts = (*parts, BudgetPart("nameless", 0.195), BudgetPart("noise", 0.004))
    bias = replace(named("force_bias", "bias", 0.25, "N"), certain="family")
    told = summary_of(Diagnosis("partly_explained", "", parts, (bias,), fit=FIT))
    first = "Of the model's squared error on held-out data: 30 % wrong parameters, 50 % force bias, "
    assert told.startswith(f"{first}20 % what nobody has named. The model leaves out force bias")
    assert "certain is sensor, another law of it would do as well" in told


def test_beside_numbers_that_were_far_off_an_effect_keeps_its_share_of_the_rest():
    parts = (BudgetPart("parameters", 0.996), BudgetPart("coulomb_friction", 0.003), BudgetPart("noise", 0.001))
    told = summary_of(Diagnosis("missing_physics", "", parts, (named("coulomb_friction", "Fc", 0.4, "N"),), fit=FIT))
    assert "100 % wrong parameters. Of the rest: 75 % Coulomb friction, 25 % noise." in told


def test_a_fit_at_its_bounds_is_told_before_anything_else():
    told = summary_of(Diagnosis("unexplained", "", fit=FIT, at_bounds=("b1", "m")))
    assert told.startswith("Without effects, fitting drives b1 and m out of all bounds: that fit proves nothing.")


def test_many_effects_that_there_was_no_time_for_are_counted():
    names = tuple(f"law_{k}" for k in range(8))
    told = summary_of(Diagnosis("no_mismatch", "", untried=names))
    assert "There was no time to try law 0, law 1, law 2, law 3, law 4 and 3 more; --time-budget" in told


def test_a_signal_that_the_error_follows_is_told_only_where_no_other_does_as_well():
    def told(*scores: float) -> str:
        signals = zip(("deflection", "sliding_velocity"), scores, strict=True)
        found = Mismatch((BlockShare("friction", 1.0),), (), None, tuple(Dependence(s, r, "") for s, r in signals))
        return summary_of(Diagnosis("unexplained", "", mismatch=found))

    assert "follows the deflection" in told(0.801, 0.5)
    assert "It most likely acts in the block friction." in told(0.801, 0.799)
    assert "follows" not in told(0.08, 0.0)


def test_a_table_of_the_rest_is_no_name():
    friction = named("coulomb_friction", "Fc", 0.4, "N")
    over = {"of": EffectParameter("sliding_velocity", "signal"), "value": EffectParameter((0.1, 0.2), "N")}
    table = NamedEffect("tabulated_force", "tabulated_force", "friction", None, over)
    said = summary_of(Diagnosis("partly_explained", "", effects=(friction, table)))
    assert said == (
        "The model leaves out Coulomb friction (Fc = 0.4 N), and more that nobody has named; a table over the sliding "
        "velocity takes some of that."
    )


def test_of_parameters_that_cannot_be_told_apart_no_effect_is_spoken():
    nothing = Diagnosis("unexplained", "", budget=(BudgetPart("shared", 0.9), BudgetPart("nameless", 0.1)))
    assert "90 % wrong parameters that cannot be told apart, 10 %" in summary_of(nothing)
    friction = named("coulomb_friction", "Fc", 0.4, "N")
    assert "90 % parameters and effects together" in summary_of(
        replace(nothing, verdict="partly_explained", effects=(friction,))
    )


def test_an_effect_for_which_another_would_do_is_said_to_be_not_certain():
    friction, bias = (
        named("coulomb_friction", "Fc", 0.4, "N"),
        replace(named("force_bias", "bias", 0.2, "N"), certain=None),
    )
    told = summary_of(Diagnosis("missing_physics", "", effects=(friction, bias)))
    assert "force bias (bias = 0.2 N; not certain, another effect would do as well)" in told
    assert told.count("certain") == 1


def test_fitted_numbers_of_what_is_not_explained_need_not_be_the_system_s_own():
    wrong = {"m": FittedParameter(1.0, 0.5, "kg", (0.4, 0.6))}
    told = summary_of(Diagnosis("unexplained", "", fit=FIT, parameters=wrong))
    assert "no effect of the library was found to explain it. So the numbers that fit best need not be" in told
    assert "need not be" not in summary_of(Diagnosis("unexplained", "", fit=FIT))


def test_where_other_values_predict_to_the_noise_it_is_not_said_that_something_is_missing():
    fit = replace(FIT, heldout_nrmse=HeldoutNrmse(0.7, 0.019, 0.019))
    somewhere = Mismatch((BlockShare("friction", 1.0),), (), None, ())
    told = summary_of(Diagnosis("unexplained", "", mismatch=somewhere, fit=fit))
    assert "cannot be told which are wrong" in told and "Something real" not in told
    assert "It most likely acts" not in told


@pytest.mark.parametrize(("refit", "says"), [(0.039, True), (0.041, False)])
def test_where_less_than_twice_the_noise_is_left_it_may_be_noise_of_another_colour(refit: float, says: bool) -> None:
    fit = replace(FIT, heldout_nrmse=HeldoutNrmse(0.7, refit, refit), noise_floor=0.02)
    somewhere = Mismatch((BlockShare("force_sensor", 1.0),), (), None, ())
    diagnosis = Diagnosis("unexplained", "", mismatch=somewhere, fit=fit)
    told = summary_of(diagnosis)
    assert ("1.95 times that, and no effect of the library was found" in told) is says
    assert ("If physics, it most likely acts in the block force sensor" in told) is says
    assert ("Something real is missing" in told) is not says and ("Something real" in headline(diagnosis)) is not says
    assert "cannot be told which" not in summary_of(replace(diagnosis, untried=("coulomb_friction",)))


def test_noise_that_a_model_undercuts_was_taken_for_too_much():
    friction = named("coulomb_friction", "Fc", 0.4, "N")
    undercut = replace(FIT, noise_floor=0.05)
    told = summary_of(Diagnosis("missing_physics", "", effects=(friction,), fit=undercut))
    assert told.endswith("; that is less than the 0.1 N taken for noise, which is then less too.")
