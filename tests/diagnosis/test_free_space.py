"""What fits say of the force sensor in free space."""

import numpy as np
import pytest
from trial_samples import beside, cut, model, problem_of, recorded

from mmt_drake.diagnosis.decide.confidence import MUCH_FARTHER, SURELY
from mmt_drake.diagnosis.fit.free_space import off_in_free_space
from mmt_drake.recording import Recording

OFF = recorded(("force_bias", (("bias", 0.3),)), seed=3)


@pytest.mark.parametrize(("name", "number"), [("force_bias", "bias"), ("constant_force", "F")])
def test_an_offset_shows_in_free_space_and_a_force_on_the_body_does_not(name: str, number: str) -> None:
    problem, hypothesis = problem_of(OFF, model()), beside(name)
    fitted = problem.fit(hypothesis, hypothesis.vector({}, {name: {number: 0.2}}))
    off = off_in_free_space(problem, fitted)
    assert off < SURELY if name == "force_bias" else off > SURELY * MUCH_FARTHER


def test_without_free_space_nothing_is_off() -> None:
    touching = np.flatnonzero(OFF["in_contact"] > 0.5)
    within: Recording = cut(OFF, (np.arange(len(OFF)) >= touching[0]) & (np.arange(len(OFF)) <= touching[0] + 2000))
    assert (within["in_contact"] > 0.5).all()
    problem, hypothesis = problem_of(within, model()), beside()
    assert off_in_free_space(problem, problem.unchanged(hypothesis, hypothesis.base())) == 0.0
