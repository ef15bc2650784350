"""Of explanations that are as good, the one that says least."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from trial_samples import model, recorded

from mmt_drake.diagnosis.decide.gate import (
    FAR_BEHIND,
    NEAR,
    NOTHING_LEFT,
    Standard,
    explains,
    rivals,
    simplest,
    without_physics,
)
from mmt_drake.diagnosis.fit.comparison import RULED_OUT, at_bound
from mmt_drake.diagnosis.fit.hypothesis import WIDEST, Hypothesis
from mmt_drake.diagnosis.fit.prepare import prepare
from mmt_drake.diagnosis.fit.problem import Fitted
from mmt_drake.effects import LIBRARY
from mmt_drake.numeric.least_squares import Minimum

PLAIN = Hypothesis(model())
COULOMB = PLAIN.adding(LIBRARY["coulomb_friction"])
STATIC = PLAIN.adding(LIBRARY["static_friction"])
BIAS = PLAIN.adding(LIBRARY["force_bias"])
PAIR = COULOMB.adding(LIBRARY["force_bias"])


@dataclass(frozen=True)
class Told(Standard):
    """A standard that was told what each set of effects leaves: the excess, and the error on held-out data."""

    said: tuple[tuple[Hypothesis, float, float], ...] = ()

    def left(self, fitted: Fitted) -> float:
        return next(left for hypothesis, left, _ in self.said if hypothesis is fitted.hypothesis)

    def heldout(self, fitted: Fitted) -> float:
        return next(heldout for hypothesis, _, heldout in self.said if hypothesis is fitted.hypothesis)


@pytest.fixture(scope="module")
def standard() -> Standard:
    problem = prepare([recorded()], model()).problem
    assert problem is not None
    return Standard.of(problem)


def chosen(standard: Standard, *said: tuple[Hypothesis, float, float]) -> Hypothesis:
    """Which of some hypotheses, best first, each with what it leaves and its held-out error, is the simplest."""
    # So slight that all fit the recording alike.
    start = {"coulomb_friction": {"Fc": 1e-6}, "static_friction": {"Fs": 1e-6, "Fd": 1e-6, "v_d": 0.01}}
    start["force_bias"] = {"bias": 1e-6}
    fits = [standard.problem.unchanged(h, h.vector({}, {n: start[n] for n in h.names})) for h, *_ in said]
    return simplest(Told(standard.problem, standard.sensor, said), fits).hypothesis


def test_more_numbers_in_the_same_place_must_predict_better(standard):
    assert chosen(standard, (STATIC, 0.31, 1.05), (COULOMB, 0.23, 1.04)) is COULOMB
    assert chosen(standard, (STATIC, 0.1, 1.0), (COULOMB, 0.3, 1.04)) is STATIC
    # It does not matter how well the simpler one predicts if it leaves something.
    assert chosen(standard, (STATIC, 0.1, 1.04), (COULOMB, 2.0 * NOTHING_LEFT, 1.0)) is STATIC


def test_where_both_leave_something_the_simpler_one_may_leave_a_little_more(standard):
    assert chosen(standard, (STATIC, 1.27, 3.0), (COULOMB, 1.29, 3.1)) is COULOMB
    assert chosen(standard, (STATIC, 1.27, 3.0), (COULOMB, 1.6, 3.1)) is STATIC


def test_laws_of_different_places_are_not_exchanged_for_a_number_less(standard):
    assert chosen(standard, (STATIC, 0.31, 1.05), (BIAS, 0.23, 1.04)) is STATIC


def test_of_two_that_leave_something_and_fit_alike_the_one_that_predicts_better_is_chosen(standard):
    assert chosen(standard, (STATIC, 2.0, 3.0), (BIAS, 1.0, 2.0)) is BIAS
    assert chosen(standard, (STATIC, 0.3, 1.1), (BIAS, 0.2, 1.0)) is STATIC  # neither leaves anything: the better fit


def test_a_second_effect_must_be_worth_it(standard):
    assert chosen(standard, (PAIR, 0.05, 1.0), (COULOMB, 0.3, 1.1)) is COULOMB
    assert chosen(standard, (PAIR, 0.05, 1.0), (COULOMB, 2.0, 1.1)) is PAIR


def costing(hypothesis: Hypothesis, cost: float) -> Fitted:
    """A fit that leaves this sum of squares."""
    start = {n: {p.symbol: 0.01 for p in LIBRARY[n].parameters if p.default is None} for n in hypothesis.names}
    x = hypothesis.vector({}, start)
    return Fitted(hypothesis, Minimum(x, np.array([np.sqrt(cost)]), np.zeros((1, len(x))), True, 1))


def told(standard: Standard, *said: tuple[Hypothesis, float, float]) -> Told:
    return Told(standard.problem, standard.sensor, said)


def test_a_rival_is_whatever_the_likelihood_does_not_rule_out(standard):
    n = standard.problem.samples()
    best, close, out = (
        costing(h, n + more) for h, more in ((COULOMB, 0.0), (BIAS, RULED_OUT - 1), (BIAS, RULED_OUT + 1))
    )
    plain = told(standard, (COULOMB, 0.0, 1.0), (BIAS, 0.0, 1.0), (STATIC, 0.0, 1.0))
    assert rivals(plain, best, [close]) == [close]
    assert rivals(plain, best, [out]) == []
    assert rivals(plain, best, [costing(STATIC, n)]) == []  # as good with more numbers is no rival
    assert rivals(plain, best, [best]) == []


def test_what_a_fit_leaves_is_judged_on_data_that_it_has_not_seen(standard):
    model = PLAIN.vector({"k2": 1.5 * PLAIN.nominal.parameter("k2")}, {})
    fitted = standard.problem.unchanged(PLAIN, model)
    seen, unseen = (standard.problem.ratio(fitted.model, fitted.skew, heldout=flag) for flag in (False, True))
    assert standard.heldout(fitted) == unseen != seen
    assert standard.left(fitted) == max(
        map(standard.excess, (unseen, np.sqrt(fitted.cost / standard.problem.samples())))
    )


def test_what_is_left_counts_beyond_the_noise_and_over_the_sensors(standard):
    assert standard.excess(0.9) == standard.excess(1.0) == 0.0
    assert standard.excess(np.hypot(1.0, 0.5 * standard.sensor)) == pytest.approx(0.5, rel=1e-12)


def test_noise_within_the_band_that_outweighs_the_sensors_own_is_the_measure(standard):
    problem = standard.problem
    for factor, sensor in ((0.5, 2.0 * standard.sensor), (1e4, 1.0)):  # the position's noise, sent through the model
        tracks = tuple(replace(track, floor=factor * track.floor) for track in problem.tracks)
        assert Standard.of(replace(problem, tracks=tracks)).sensor == pytest.approx(sensor, rel=1e-12)


@pytest.mark.parametrize("strength", [1.0, 9.0])
def test_a_number_more_costs_ln_samples_and_errors_count_over_what_the_best_leaves(standard, strength):
    n = standard.problem.samples()
    one, two = costing(COULOMB, strength * n), costing(PAIR, strength * (n + 5.0))
    more = len(two.x) - len(one.x)
    score = standard.score(two, one.cost) - standard.score(one, one.cost)
    assert more > 0 and score == pytest.approx(5.0 + more * np.log(n), rel=1e-9)


def test_where_something_is_left_whatever_comes_near_is_a_rival(standard):
    n = standard.problem.samples()
    some = told(standard, (COULOMB, 5.0, 5.0), (BIAS, 5.0, 5.0))
    best = costing(COULOMB, 100.0 * n)
    near, far = costing(BIAS, (NEAR - 0.1) * 100.0 * n), costing(BIAS, (NEAR + 0.1) * 100.0 * n)
    assert rivals(some, best, [near]) == [near]
    assert rivals(some, best, [far]) == []


def test_what_leaves_something_must_explain_nearly_all_with_nothing_else_near(standard):
    n = standard.problem.samples()
    refit, best = costing(PLAIN, 1e6 * n), costing(COULOMB, 1e4 * n)

    def verdict(left: float, heldout: float, other: float) -> bool:
        said = told(standard, (PLAIN, 1000.0, 1000.0), (COULOMB, left, heldout), (BIAS, left, heldout))
        return explains(said, refit, best, [costing(BIAS, other * best.cost)])

    assert verdict(NOTHING_LEFT, 1.0, 1.0)  # nothing left: rivals are another question
    assert verdict(100.0, 100.0, FAR_BEHIND + 0.1)
    assert not verdict(100.0, 100.0, FAR_BEHIND - 0.1)
    assert not verdict(100.0, 300.0, FAR_BEHIND + 0.1)  # 91 % of the variance, held out


def test_a_model_is_right_or_wrong_in_its_values_alone_before_any_physics_is_missed():
    assert without_physics(0.4, 0.1) == "no_mismatch"
    assert without_physics(2.0, 0.3) == "parameters"
    assert without_physics(2.0, 0.4) is None


def test_a_parameter_at_its_bound_is_told_and_one_that_may_vanish_may(standard):
    high = PLAIN.vector({"k2": WIDEST * PLAIN.nominal.parameter("k2")}, {})
    assert at_bound(standard.problem.unchanged(PLAIN, high)) == "k2"
    assert at_bound(standard.problem.unchanged(PLAIN, PLAIN.base())) is None
    assert at_bound(standard.problem.unchanged(PLAIN, PLAIN.vector({"b1": 0.0}, {}))) is None
