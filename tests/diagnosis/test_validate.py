"""Intervals cover as often as they say, and chance is not mistaken for a gain."""

import numpy as np
import pytest
from residual_samples import leaving
from trial_samples import model, named, problem_of, recorded

from mmt_drake.diagnosis.fit.hypothesis import Hypothesis
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.diagnosis.fit.validate import chance, intervals, of_no_mass
from mmt_drake.effects import LIBRARY

PLAIN = Hypothesis(model())


@pytest.fixture(scope="module")
def problem() -> Problem:
    return problem_of(recorded(seed=5), model())


def test_intervals_cover_the_truth_as_often_as_they_say(problem):
    x = PLAIN.base()
    covered = []
    for seed in range(40):
        measured = leaving(problem, model=model(), seed=seed)
        ci = intervals(measured, measured.fit(PLAIN, x))
        covered += [low <= value <= high for (low, high), value in zip(ci, x, strict=True)]
    assert 0.90 <= np.mean(covered) <= 1.0 and len(covered) == 40 * len(x)


def test_what_explains_nothing_gains_by_chance_and_what_explains_gains_beyond_it(problem):
    rubbing = PLAIN.adding(LIBRARY["coulomb_friction"])
    x = rubbing.vector({}, {"coulomb_friction": {"Fc": 0.1}})

    def p(measured: Problem, tries: int) -> float:
        before: Fitted = measured.fit(PLAIN, PLAIN.base())
        after = measured.fit(
            rubbing, rubbing.vector(PLAIN.structure_values(before.x), {"coulomb_friction": {"Fc": 0.01}})
        )
        return chance(measured, before, after, tries)

    nothing = [p(leaving(problem, model=model(), seed=seed), 28) for seed in range(10)]
    assert min(nothing) > 0.01
    real = leaving(problem, model=rubbing.model(x), seed=0)
    assert p(real, 28) < 1e-4
    # Bonferroni: as many times as likely as there were tries, and never more than certain.
    assert p(real, 56) == pytest.approx(2.0 * p(real, 28)) and p(real, 10**15) == 1.0


@pytest.mark.parametrize(
    ("lightest", "names", "alike"),
    [
        (0.0, ("load_dependent_friction",), {"load_dependent_friction"}),  # or a tip that slips on the object
        (1.1, ("load_dependent_friction",), set()),
        (0.0, ("coulomb_friction",), set()),
    ],
)
def test_friction_by_load_of_a_body_that_may_have_no_mass_may_be_that_of_the_tip(lightest, names, alike):
    fitted = named(*names)
    parameters = fitted.hypothesis.free_parameters()
    known_to = [(p.low * lightest if p.symbol == "m" else p.low, p.high) for p in parameters]
    assert of_no_mass(fitted, known_to) == alike
