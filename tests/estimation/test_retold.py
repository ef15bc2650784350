"""An estimator that is told another model of the object while it runs."""

import numpy as np
import pytest
from hand_and_box import OBJECT, Contact, contact

from mmt_drake.errors import BadInput
from mmt_drake.estimation.output_error import layout as at
from mmt_drake.estimation.output_error.gate import hand_over, initial_readout, settings, take_samples, tick
from mmt_drake.estimation.output_error.knowledge import Knowledge
from mmt_drake.estimation.output_error.learn import Learner
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.model_files import with_effects
from mmt_drake.model_message import UNKNOWN_THETA, ModelMessage, ToldEffect
from mmt_drake.numeric.arrays import Array
from mmt_drake.systems.output_error_estimator import OutputErrorEstimator

CUBIC = ToldEffect("nonlinear_stiffness", {"k3": 3e6})
MESSAGE = ModelMessage(UNKNOWN_THETA, (CUBIC,), number=3)


@pytest.fixture(scope="module")
def stiffening() -> Contact:
    return contact(12.0, model=with_effects(OBJECT, [{"name": CUBIC.name, "parameters": CUBIC.parameters}], "test"))


def told_at(seen: Contact, at_s: float, options: OutputErrorOptions) -> tuple[Knowledge, Array, list[float]]:
    """Knowledge in the end, the readout, and what was left fit by fit, of a contact of which it is told on its way."""
    learner, fixed = Learner(options), settings(options)
    known = learner.beginning()
    readout, left = initial_readout(fixed, known), []
    every = options.samples_per_fit * options.ticks
    for k in range(len(seen.time)):
        if k % every == 0:
            hand_over(readout, known.told)
            if seen.time[k] >= at_s:
                known = learner.retold(known, MESSAGE.vector())
            known = learner.learned(known, *take_samples(readout, fixed))
            left.append(known.adequacy.left)
        sample = seen.measurement[k]
        tick(sample, sample[6:], seen.in_contact[k], seen.time[k], seen.time[k], readout, fixed)
    return known, readout, left


@pytest.mark.parametrize("window", [30.0, 3.0], ids=["all of it", "a window that has let samples go"])
def test_numbers_come_right_soon_after_a_law_is_told(stiffening: Contact, window: float) -> None:
    options = OutputErrorOptions(window=window)
    known, readout, left = told_at(stiffening, 8.0, options)
    before, after = (
        max(left[round(since / options.latency) :][: round(3.0 / options.latency)]) for since in (5.0, 9.0)
    )
    assert before > 2.5 and after < 1.7
    np.testing.assert_allclose(known.theta[:6], OBJECT.theta()[:6], rtol=0.05)
    np.testing.assert_array_equal(readout[at.MODEL], MESSAGE.vector())


def test_an_older_message_or_none_changes_nothing() -> None:
    learner = Learner(OutputErrorOptions(effects=(CUBIC,)))
    known = learner.beginning()
    for model in (np.zeros(len(known.model)), ModelMessage(UNKNOWN_THETA).vector()):
        assert learner.retold(known, model) is known


def test_a_law_beside_which_a_number_would_do_nothing_is_refused_and_told() -> None:
    wrong = ToldEffect("asymmetric_friction", {"Fc_plus": 0.2, "Fc_minus": 0.3})
    message = ModelMessage(UNKNOWN_THETA, (wrong,)).vector()
    learner = Learner(OutputErrorOptions())
    with pytest.raises(BadInput, match="does without Fc"):
        learner.retold(learner.beginning(), message)
    estimator = OutputErrorEstimator()
    readout = estimator.CreateDefaultContext().get_discrete_state().value().copy()
    estimator._step(0.0, readout, np.zeros(9), np.ones(1), None, None, message)
    assert readout[at.STATUS] == at.Status.NO_MODEL and not readout[at.MODEL].any()
    estimator._step(0.001, readout, np.zeros(9), np.ones(1), None, None, np.zeros(len(message)))
    assert readout[at.STATUS] != at.Status.NO_MODEL


def test_what_is_no_message_is_refused_and_told() -> None:
    estimator = OutputErrorEstimator()
    readout = estimator.CreateDefaultContext().get_discrete_state().value().copy()
    broken = MESSAGE.vector()
    broken[0] = 99.0
    estimator._step(0.0, readout, np.zeros(9), np.ones(1), None, None, broken)
    assert readout[at.STATUS] == at.Status.NO_MODEL
