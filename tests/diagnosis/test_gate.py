"""What a fit leaves, and what that allows to be said."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from trial_samples import beside, model, problem_of, recorded

from mmt_drake.diagnosis.decide.budget import BudgetPart
from mmt_drake.diagnosis.decide.gate import (
    COLOURED,
    LEAST,
    NAMED,
    NAMELESS,
    NOTHING_LEFT,
    OF_REFIT,
    REMAINS,
    WHOLE,
    NoiseReference,
    is_worth_naming,
    leaves_much,
    ranked,
    with_physics,
    without_names,
    without_physics,
)
from mmt_drake.diagnosis.fit.comparison import at_bounds, fit_widening
from mmt_drake.diagnosis.fit.hypothesis import WIDEST, Hypothesis
from mmt_drake.diagnosis.fit.problem import Fitted
from mmt_drake.diagnosis.session import DiagnosisSession
from mmt_drake.effects import LIBRARY
from mmt_drake.numeric.least_squares import Minimum

PLAIN, ONE, PAIR = beside(), beside("coulomb_friction"), beside("coulomb_friction", "force_bias")


@pytest.fixture(scope="module")
def standard() -> NoiseReference:
    return NoiseReference.of(problem_of(recorded(), model()))


def costing(hypothesis: Hypothesis, cost: float) -> Fitted:
    """A fit that leaves this sum of squares."""
    start = {n: {p.symbol: 0.01 for p in LIBRARY[n].parameters if p.default is None} for n in hypothesis.names}
    x = hypothesis.vector({}, start)
    return Fitted(hypothesis, Minimum(x, np.array([np.sqrt(cost)]), np.zeros((1, len(x))), True, 1))


def test_what_a_fit_leaves_is_judged_on_data_that_it_has_not_seen(standard):
    fitted = standard.problem.unchanged(PLAIN, PLAIN.vector({"k2": 1.5 * PLAIN.nominal.parameter("k2")}, {}))
    seen, unseen = (standard.problem.ratio(fitted.model, fitted.skew, heldout=flag) for flag in (False, True))
    assert standard.heldout(fitted) == unseen != seen
    problem = standard.problem
    by_axis = problem.ratios(problem.residual(fitted.model, heldout=True, coarse=1.0), heldout=True)
    assert set(by_axis) == {"y", "z"} and by_axis["z"] < 1.5 < by_axis["y"]
    assert standard.left(fitted) == pytest.approx(
        max(standard.excess(ratios)["y"] for ratios in (by_axis, problem.ratios(fitted.minimum.residual))), rel=1e-12
    )


def test_a_mismatch_along_one_axis_counts_in_full_however_well_others_are_explained(standard):
    wrong = replace(model(), normal=replace(model().normal, k=1.3 * model().normal.k))
    hypothesis = Hypothesis(wrong)
    fitted = standard.problem.unchanged(hypothesis, hypothesis.base())
    alone = tuple(track for track in standard.problem.tracks if track.axis == "z")
    of_z = NoiseReference.of(replace(standard.problem, tracks=alone))
    assert standard.left(fitted) == pytest.approx(
        of_z.left(of_z.problem.unchanged(hypothesis, hypothesis.base())), rel=1e-9
    )
    right = standard.problem.unchanged(PLAIN, PLAIN.base())
    assert standard.gain(fitted, right) > 1.0 > NOTHING_LEFT > standard.left(right)


def test_what_is_left_counts_beyond_the_noise_and_over_the_sensors(standard):
    assert standard.excess({"y": 0.9, "z": 1.0}) == {"y": 0.0, "z": 0.0}
    ratios = {axis: np.hypot(1.0, 0.5 * sensor) for axis, sensor in standard.sensor.items()}
    assert standard.excess(ratios) == pytest.approx({"y": 0.5, "z": 0.5}, rel=1e-12)


def test_noise_within_the_band_that_outweighs_the_sensors_own_is_the_measure(standard):
    problem = standard.problem
    twice = {axis: 2.0 * sensor for axis, sensor in standard.sensor.items()}
    for factor, sensor in ((0.5, twice), (1e4, {"y": 1.0, "z": 1.0})):  # the position's noise, sent through the model
        tracks = tuple(replace(track, floor=factor * track.floor) for track in problem.tracks)
        assert NoiseReference.of(replace(problem, tracks=tracks)).sensor == pytest.approx(sensor, rel=1e-12)


@pytest.mark.parametrize("strength", [1.0, 9.0])
def test_a_number_more_costs_ln_samples_and_errors_count_over_what_the_best_leaves(standard, strength):
    problem, n = standard.problem, standard.problem.samples()
    one = costing(ONE, strength * n)
    price = (len(costing(PAIR, 0.0).x) - len(one.x)) * np.log(n)
    assert price > 0.0 and ranked(problem, [one, costing(PAIR, strength * (n - 0.99 * price))])[0] is one
    assert ranked(problem, [one, costing(PAIR, strength * (n - 1.01 * price))])[1] is one


def test_a_model_is_right_or_wrong_in_its_values_alone_before_any_physics_is_missed():
    assert without_physics(0.4, 0.1) == "no_mismatch"
    assert without_physics(2.0, 0.3) == "parameters"
    assert without_physics(2.0, 0.4) is None


@pytest.mark.parametrize(
    ("left", "named", "nameless", "of_refit", "verdict"),
    [
        (NOTHING_LEFT, 0.5, 0.5, 0.0, "missing_physics"),
        (5.0, 0.9, NAMELESS, 0.9, "missing_physics"),
        (5.0, 0.1, NAMELESS, WHOLE - 0.01, "partly_explained"),  # the first model was far off: all is next to nothing
        (5.0, NAMED, 0.5, LEAST, "partly_explained"),
        (5.0, NAMED, 0.5, LEAST - 0.01, "unexplained"),  # other numbers would have taken that share as well
        (5.0, 0.01, 0.01 + NAMELESS, OF_REFIT, "partly_explained"),
        (5.0, NAMED - 0.01, 0.5, OF_REFIT - 0.01, "unexplained"),
    ],
)
def test_what_is_named_is_all_of_it_a_part_or_too_little(left, named, nameless, of_refit, verdict):
    parts = {"parameters": 0.05, "coulomb_friction": named, "nameless": nameless, "noise": 0.0}
    shares = [BudgetPart(part, share) for part, share in parts.items()]
    assert with_physics(left, shares, of_refit) == verdict


@pytest.mark.parametrize(
    ("refit", "left", "worth"),
    [
        (1.0, 0.6, True),  # a mismatch of its own size
        (1.0, 0.7, False),
        (0.4, 0.1, True),  # next to nothing, which is all that a refit leaves
        (0.4, 0.3, False),  # ... or a little of it
        (0.34, 0.0, False),  # ... or all, of what is nothing
    ],
)
def test_an_effect_is_worth_naming_if_it_takes_much_or_most_of_what_there_is(refit, left, worth):
    assert is_worth_naming(refit - left, refit, left) is worth


@pytest.mark.parametrize(
    ("named", "nameless", "of_refit", "much"),
    [
        ((0.4,), 0.11, 0.9, True),
        ((0.4,), 0.09, 0.9, False),
        ((0.2, 0.2), 0.09, 0.9, False),
        ((0.4,), 0.01, 0.79, True),  # beside a first model that was far off all is next to nothing
        ((0.4,), 0.01, 0.81, False),
    ],
)
def test_effects_that_may_stand_for_one_another_leave_much_from_a_quarter_of_what_they_take(
    named, nameless, of_refit, much
):
    effects = [BudgetPart(f"effect {i}", share) for i, share in enumerate(named)]
    rest = {"parameters": 1.0 - nameless - sum(named), "shared": 0.0, "nameless": nameless, "noise": 0.0}
    assert leaves_much([*effects, *(BudgetPart(*part) for part in rest.items())], of_refit) == much


@pytest.mark.parametrize(
    ("left", "noise", "verdict"),
    [
        (REMAINS, 0.5, "missing_physics"),
        (REMAINS + 0.1, 0.5, "partly_explained"),
        (REMAINS + 0.1, NAMELESS, "missing_physics"),
    ],
)
def test_much_noise_hides_no_rest_that_stands_out_where_noise_is_small(left, noise, verdict):
    parts = {"coulomb_friction": 1.0 - noise, "nameless": 0.0, "noise": noise}
    assert with_physics(left, [BudgetPart(*part) for part in parts.items()], of_refit=1.0) == verdict


@pytest.mark.parametrize(
    ("refit", "best", "noise", "verdict"),
    [
        (0.0137, 0.0014, 0.0015, "missing_physics"),  # all but noise, which is a ninth of what the refit leaves
        (0.0137, 0.0014, 1e-5, "partly_explained"),
        (0.0137, 0.0137, 1e-5, "unexplained"),
        (math.inf, 0.0014, 1e-5, "missing_physics"),  # what diverges without the effect
        (math.inf, math.inf, 1e-5, "unexplained"),
    ],
)
def test_noise_is_nothing_that_an_effect_should_have_taken_off(refit, best, noise, verdict):
    ruler = SimpleNamespace(of={"refit": refit, "best": best}.get, noise=lambda model: noise)
    session = SimpleNamespace(ruler=lambda problem: ruler)
    reference = SimpleNamespace(problem=None)
    shares = [BudgetPart("coulomb_friction", 0.1), BudgetPart("nameless", 0.0), BudgetPart("noise", 0.9)]
    fits = (SimpleNamespace(model=name) for name in ("best", "refit"))
    assert with_physics(0.4, shares, DiagnosisSession.of_refit(session, *fits, reference)) == verdict


@pytest.mark.parametrize(
    ("nameless", "handed_in", "refit", "changed", "verdict"),
    [
        (0.9 * NAMELESS, 50.0, REMAINS, True, "parameters"),
        (0.9 * NAMELESS, 50.0, 1.1 * REMAINS, True, "unexplained"),  # next to nothing of a first model that was far off
        (1.1 * NAMELESS, 50.0, 5.0, True, "unexplained"),
        (1.1 * NAMELESS, 5.0, 5.0, True, "unexplained"),
        (0.4, 5.0, 0.9 * COLOURED, True, "parameters"),
        (0.4, 0.9 * COLOURED, 0.89 * COLOURED, True, "no_mismatch"),
        (0.4, 1.1 * COLOURED, 0.9 * COLOURED, False, "no_mismatch"),
        (
            0.4,
            5.0,
            0.9 * COLOURED,
            False,
            "unexplained",
        ),  # what was handed in is far off, and no other numbers are told
    ],
)
def test_where_no_law_takes_anything_off_next_to_nothing_or_as_much_as_noise_is_no_reason_to_doubt_the_structure(
    nameless, handed_in, refit, changed, verdict
):
    shares = [BudgetPart("parameters", 1.0 - nameless), BudgetPart("nameless", nameless), BudgetPart("noise", 0.0)]
    assert without_names(shares, handed_in, refit, changed) == verdict


@pytest.mark.parametrize(("refit", "verdict"), [(0.9 * COLOURED, "parameters"), (1.1 * COLOURED, "unexplained")])
def test_where_touches_are_late_what_is_left_beyond_the_noise_is_no_colour_of_it(refit, verdict):
    shares = [BudgetPart("parameters", 1.0), BudgetPart("nameless", 0.0), BudgetPart("noise", 0.0)]
    assert without_names(shares, 50.0, refit, True, late=True) == verdict
    assert without_names(shares, 50.0, refit, True) == "parameters"


def test_a_parameter_at_its_bound_is_told_and_one_that_may_vanish_may(standard):
    high = PLAIN.vector({"k2": WIDEST * PLAIN.nominal.parameter("k2")}, {})
    fitted = standard.problem.unchanged(PLAIN, high)
    assert at_bounds(fitted) == {"k2"}
    assert not at_bounds(fit_widening(standard.problem, PLAIN, high, steps=8))
    assert not at_bounds(standard.problem.unchanged(PLAIN, PLAIN.base()))
    assert not at_bounds(standard.problem.unchanged(PLAIN, PLAIN.vector({"b1": 0.0}, {})))
