"""Of explanations that are as good, the one that says least."""

from __future__ import annotations

from dataclasses import dataclass

import pytest
from trial_samples import model, recorded

from mmt_drake.diagnosis.gate import NOTHING_LEFT, Standard, simplest
from mmt_drake.diagnosis.hypothesis import Hypothesis
from mmt_drake.diagnosis.prepare import prepare
from mmt_drake.diagnosis.problem import Fitted
from mmt_drake.effects import LIBRARY

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
