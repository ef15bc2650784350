"""What fits say of the force sensor in free space."""

import numpy as np
import pytest
from trial_samples import beside, changed, cut, model, problem_of, recorded

from mmt_drake.diagnosis.decide.confidence import MUCH_FARTHER, not_to_be_named
from mmt_drake.diagnosis.fit.free_space import SURELY, leaves_an_offset, off_in_free_space
from mmt_drake.recording import Recording

OFF = recorded(("force_bias", (("bias", 0.3),)), seed=3)


@pytest.mark.parametrize(("name", "number"), [("force_bias", "bias"), ("constant_force", "F")])
def test_an_offset_shows_in_free_space_and_a_force_on_the_body_does_not(name: str, number: str) -> None:
    problem, hypothesis = problem_of(OFF, model()), beside(name)
    fitted = problem.fit(hypothesis, hypothesis.vector({}, {name: {number: 0.2}}))
    off = off_in_free_space(problem, fitted)
    assert off < SURELY if name == "force_bias" else off > SURELY * MUCH_FARTHER


@pytest.mark.parametrize("size", [0.3, 0.01])
def test_no_effect_is_named_in_the_place_of_an_offset_that_free_space_shows(size: float) -> None:
    """A sensor is off along one axis alone, which no effect says; what is next to nothing stands in no one's way."""
    clean = recorded(("coulomb_friction", (("Fc", 0.2),)), seed=3)
    problem = problem_of(changed(clean, force_y=clean["force_y"] + size), model())
    plain, turned = beside(), beside("constant_force")
    refit = problem.fit(plain, plain.base())
    fitted = problem.fit(turned, turned.vector({}, {"constant_force": {"F": 0.1}}))
    is_much = size > 0.1
    assert leaves_an_offset(problem, refit, fitted) == is_much
    assert ("constant_force" in not_to_be_named(problem, refit, fitted)) or not is_much


def test_without_free_space_nothing_is_off() -> None:
    touching = np.flatnonzero(OFF["in_contact"] > 0.5)
    within: Recording = cut(OFF, (np.arange(len(OFF)) >= touching[0]) & (np.arange(len(OFF)) <= touching[0] + 2000))
    assert (within["in_contact"] > 0.5).all()
    problem, hypothesis = problem_of(within, model()), beside()
    assert off_in_free_space(problem, problem.unchanged(hypothesis, hypothesis.base())) == 0.0
