"""An estimator that is told another model of the object while it runs."""

from dataclasses import replace

import numpy as np
import pytest
from hand_and_box import OBJECT, Contact, contact, contact_motion, free_running_error

from mmt_drake.diagrams.proof.experiments.tick_by_tick import foreign_force
from mmt_drake.errors import BadInput
from mmt_drake.estimation.output_error import layout as at
from mmt_drake.estimation.output_error.gate import hand_over, initial_readout, settings, take_samples, tick
from mmt_drake.estimation.output_error.knowledge import Knowledge
from mmt_drake.estimation.output_error.learn import Learner
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.model_files import with_effects
from mmt_drake.model_message import UNKNOWN_THETA, ModelMessage, SensorError, ToldEffect
from mmt_drake.numeric.arrays import Array
from mmt_drake.systems.output_error_estimator import OutputErrorEstimator

CUBIC = ToldEffect("nonlinear_stiffness", {"k3": 3e6})
MESSAGE = ModelMessage(UNKNOWN_THETA, (CUBIC,), number=3)


@pytest.fixture(scope="module")
def stiffening() -> Contact:
    return contact(12.0, model=with_effects(OBJECT, [{"name": CUBIC.name, "parameters": CUBIC.parameters}], "test"))


def told_at(
    seen: Contact, at_s: float, options: OutputErrorOptions, message: ModelMessage = MESSAGE
) -> tuple[Knowledge, Array, list[float]]:
    """Knowledge in the end, the readout, and what was left fit by fit, of a contact of which it is told on its way."""
    learner, fixed = Learner(options), settings(options)
    known = learner.beginning()
    readout, left = initial_readout(fixed, known), []
    every = options.samples_per_fit * options.ticks
    for k in range(len(seen.time)):
        if k % every == 0:
            hand_over(readout, known.told)
            if seen.time[k] >= at_s:
                known = learner.retold(known, message.vector())
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


@pytest.mark.parametrize("off", [0.0, 0.001])
def test_a_wall_that_is_counted_from_elsewhere_moves_the_body_and_not_the_numbers(off: float) -> None:
    own = FlexibleBoxModel(replace(OBJECT.parameters, k1=0.0))  # nothing but the wall tells where the body is
    wall = {"position": 0.008, "stiffness": 900.0}
    seen = contact(12.0, model=with_effects(own, [{"name": "end_stop", "parameters": wall}], "test"))
    counted = ToldEffect("end_stop", {"side": 1.0, **wall, "position": wall["position"] + off})
    message = ModelMessage(UNKNOWN_THETA, (counted,), number=1)
    known, _, _ = told_at(seen, 8.0, OutputErrorOptions(window=3.0), message)
    np.testing.assert_allclose(known.theta[[0, 2, 3, 4, 5]], own.theta()[[0, 2, 3, 4, 5]], rtol=0.03)
    assert known.theta[1] < 2.0 and known.adequacy.left < 1.3


@pytest.mark.parametrize("window", [30.0, 3.0], ids=["all of it", "a window that has let samples go"])
def test_what_a_law_remembers_by_the_time_that_it_is_told_does_not_spoil_the_numbers(window: float) -> None:
    loop = {"alpha": 300.0, "beta": 150.0}
    seen = contact(12.0, model=with_effects(OBJECT, [{"name": "hysteresis", "parameters": loop}], "test"))
    message = ModelMessage(UNKNOWN_THETA, (ToldEffect("hysteresis", {**loop, "gamma": 150.0, "n": 1.0}),), number=1)
    known, _, left = told_at(seen, 8.0, OutputErrorOptions(window=window), message)
    np.testing.assert_allclose(known.theta[:6], OBJECT.theta()[:6], rtol=0.04)
    assert max(left[-10:]) < 1.3


SENSORS = {
    "bias": SensorError(bias=0.6),
    "drift": SensorError(bias=-0.4, rate=0.1),
    "crosstalk": SensorError(gain=0.2),
    "all": SensorError(0.3, 0.04, 0.1),
}


@pytest.mark.parametrize("plant", ["own", "foreign"])
@pytest.mark.parametrize("window", [30.0, 3.0], ids=["all of it", "a window that has let samples go"])
@pytest.mark.parametrize("error", SENSORS.values(), ids=SENSORS.keys())
def test_what_the_sensor_adds_is_taken_off_and_the_numbers_come_right(
    error: SensorError, window: float, plant: str
) -> None:
    seen, normal = contact(10.0), slice(8, 9)
    if plant == "foreign":
        motion = np.hstack(contact_motion(len(seen.time)))
        noise = seen.measurement[:, 6:] - seen.force
        force = foreign_force(seen.time, motion, OBJECT)
        seen = replace(seen, force=force, measurement=np.hstack([seen.measurement[:, :6], force + noise]))
    wrong = seen.measurement.copy()
    wrong[:, 6:8] += error.bias + error.rate * seen.time[:, np.newaxis] + error.gain * wrong[:, normal]
    wrong_seen, options = replace(seen, measurement=wrong), OutputErrorOptions(window=window)
    message = ModelMessage(UNKNOWN_THETA, sensor=error)
    known, readout, _ = told_at(wrong_seen, 5.0, options, message)
    untold, _, _ = told_at(wrong_seen, 99.0, options, message)
    np.testing.assert_allclose(known.theta[:6], OBJECT.theta()[:6], rtol=0.06)
    assert free_running_error(known.theta, seen) < 0.01 < 0.03 < free_running_error(untold.theta, seen)
    np.testing.assert_allclose(readout[at.FILTERED], seen.measurement[-1, 6:], atol=1e-12)


def test_a_lag_that_is_told_is_where_the_fit_of_it_begins() -> None:
    learner = Learner(OutputErrorOptions())
    lags = ModelMessage(UNKNOWN_THETA, sensor=SensorError(tau=0.03)).vector()
    assert learner.retold(learner.beginning(), lags).lateness[:3].tolist() == [0.0, 0.03, 0.03]
    with pytest.raises(BadInput, match=r"force_lag: found 0.08, expected 0.05 s at most"):
        learner.retold(learner.beginning(), ModelMessage(UNKNOWN_THETA, sensor=SensorError(tau=0.08)).vector())


def test_a_message_that_tells_the_same_of_another_object_changes_its_number_alone() -> None:
    learner = Learner(OutputErrorOptions())
    first = learner.retold(learner.beginning(), MESSAGE.vector())
    again = ModelMessage(UNKNOWN_THETA, (CUBIC,), thing=1, number=4).vector()
    assert learner.retold(first, again) == replace(first, model=again)


def test_an_older_message_or_none_changes_nothing() -> None:
    learner = Learner(OutputErrorOptions(effects=(CUBIC,)))
    known = learner.beginning()
    for model in (np.zeros(len(known.model)), ModelMessage(UNKNOWN_THETA).vector()):
        assert learner.retold(known, model) is known


def test_laws_that_a_fit_cannot_have_side_by_side_are_refused_and_told() -> None:
    loaded = ToldEffect("load_dependent_friction", {"mu": 0.2})
    pressed = ToldEffect("normal_nonlinear_stiffness", {"k3": 2e7})
    message = ModelMessage(UNKNOWN_THETA, (loaded, pressed)).vector()
    learner = Learner(OutputErrorOptions())
    with pytest.raises(BadInput, match="no law along the normal beside it"):
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
