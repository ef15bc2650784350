"""An estimator that is told a law of the object finds the numbers beside it; one that is not bends them."""

import numpy as np
import pytest
from hand_and_box import OBJECT, contact, free_running_error

from mmt_drake.errors import BadInput, MmtError
from mmt_drake.estimation.output_error.adequacy import ModelStatus
from mmt_drake.estimation.output_error.layout import MODEL, STATUS, Status
from mmt_drake.estimation.output_error.offline import estimate_output_error
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.model.parameters import THETA
from mmt_drake.model_files import with_effects
from mmt_drake.model_message import ToldEffect
from mmt_drake.numeric.arrays import Array
from mmt_drake.systems.output_error_estimator import OutputErrorEstimator
from mmt_drake.told_laws import told_by_bytes

CUBIC = ToldEffect("nonlinear_stiffness", {"k3": 3e6})
LATE_SPRING = ToldEffect("viscoelastic_relaxation", {"k_maxwell": 300.0, "tau": 0.1})
AMONTONS = ToldEffect("load_dependent_friction", {"mu": 0.3})
BRISTLES = ToldEffect("presliding_friction", {"sigma0": 2000.0, "sigma1": 0.0, "Fs": 0.4, "v_s": 0.01})


def found(effect: ToldEffect, *told: ToldEffect) -> tuple[Array, float]:
    """The numbers that are found of an object with an effect by who is told some, and how far their force is off."""
    seen = contact(model=with_effects(OBJECT, [{"name": effect.name, "parameters": effect.parameters}], "test"))
    options = OutputErrorOptions(effects=told)
    theta = estimate_output_error(seen.measurement, seen.in_contact, options).theta[-1]
    return theta, free_running_error(theta, seen, laws=told_by_bytes(options.model.tobytes()))


@pytest.mark.parametrize("effect", [CUBIC, LATE_SPRING, AMONTONS, BRISTLES], ids=lambda effect: effect.name)
def test_numbers_beside_a_known_law_are_found_and_the_force_is_the_object_s(effect: ToldEffect) -> None:
    theta, off = found(effect, effect)
    _, far_off = found(effect)
    np.testing.assert_allclose(theta[:6], OBJECT.theta()[:6], rtol=0.05)
    assert off < 0.003 and far_off > 0.01


@pytest.mark.parametrize(
    "effect",
    [
        ToldEffect("normal_nonlinear_stiffness", {"k3": 2e7}),
        ToldEffect("normal_hunt_crossley_damping", {"lambda": 500.0}),
        ToldEffect("normal_viscoelastic_relaxation", {"k_maxwell": 300.0, "tau": 0.1}),
        ToldEffect("normal_hysteresis", {"alpha": 300.0, "beta": 150.0}),
    ],
    ids=lambda effect: effect.name,
)
def test_the_normal_axis_beside_a_law_that_is_known_is_found(effect: ToldEffect) -> None:
    (theta, _), (bent, _) = found(effect, effect), found(effect)
    np.testing.assert_allclose(theta[6:8], OBJECT.theta()[6:8], rtol=0.005)
    assert np.abs(bent[6:8] / OBJECT.theta()[6:8] - 1.0).max() > 0.1, "without it the numbers bend"


def test_a_law_along_the_normal_and_friction_of_the_load_are_not_both_taken_up() -> None:
    pressed = ToldEffect("normal_nonlinear_stiffness", {"k3": 2e7})
    with pytest.raises(BadInput, match="no law along the normal beside it"):
        OutputErrorOptions(effects=(AMONTONS, pressed))


def test_a_law_too_fast_to_follow_is_left_out_and_the_run_goes_on() -> None:
    seen = contact(1.0)
    tick = np.column_stack([seen.time, seen.measurement, seen.in_contact])
    fast = ToldEffect("viscoelastic_relaxation", {"k_maxwell": 300.0, "tau": 1e-5})
    estimator = OutputErrorEstimator(OutputErrorOptions(effects=(fast,)))
    readout, statuses = estimator.CreateDefaultContext().get_discrete_state().value().copy(), []
    for t, *sample, flag in tick:
        estimator._step(t, readout, np.array(sample), np.array([flag]), None, None, None)
        statuses.append(readout[STATUS].item())
    assert np.isfinite(readout[: MODEL.start]).all()
    assert statuses.count(Status.NO_FIT) == 1 and statuses[-1] == Status.LEARNING
    stiff = ToldEffect("presliding_friction", {"sigma0": 1e12, "sigma1": 0.0, "Fs": 0.4, "v_s": 0.01})
    with pytest.raises(MmtError, match="too stiff"):
        OutputErrorEstimator(OutputErrorOptions(effects=(stiff,)))


def test_numbers_beside_a_small_clearance_are_found_and_the_force_is_nearly_the_object_s() -> None:
    # The damper takes hold at once at its edges, so that a thousandth in a number moves steps of the force.
    slack = ToldEffect("contact_gap", {"gap": 0.0005})
    (theta, off), (bent, far_off) = found(slack, slack), found(slack)
    np.testing.assert_allclose(theta[:6], OBJECT.theta()[:6], rtol=0.01)
    assert off < 0.03 and far_off > 0.06 and abs(bent[2] / OBJECT.theta()[2] - 1.0) > 0.1


@pytest.mark.parametrize(
    ("effect", "idle"),
    [
        (ToldEffect("asymmetric_friction", {"Fc_plus": 0.6, "Fc_minus": 0.1}), 5),
        (ToldEffect("asymmetric_viscous_friction", {"b_plus": 20.0, "b_minus": 90.0}), 3),
    ],
    ids=lambda case: getattr(case, "name", None),
)
def test_a_number_whose_place_a_law_takes_stays_what_was_believed_and_is_not_waited_for(
    effect: ToldEffect, idle: int
) -> None:
    seen = contact(model=with_effects(OBJECT, [{"name": effect.name, "parameters": effect.parameters}], "test"))
    options = OutputErrorOptions(effects=(effect,))
    estimate = estimate_output_error(seen.measurement, seen.in_contact, options)
    theta, others = estimate.theta[-1], [i for i in range(6) if i != idle]
    assert estimate.model_status[-1] == ModelStatus.ADEQUATE
    np.testing.assert_allclose(theta[others], OBJECT.theta()[others], rtol=0.05)
    assert theta[idle] == pytest.approx(getattr(options.prior, THETA[idle]), rel=1e-6)
    assert free_running_error(theta, seen, laws=told_by_bytes(options.model.tobytes())) < 0.003


def test_the_normal_axis_of_a_power_law_is_found_and_its_spring_stays_what_was_believed() -> None:
    ball = ToldEffect("power_law_stiffness", {"k": 8000.0, "p": 1.5})
    theta, off = found(ball, ball)
    np.testing.assert_allclose(theta[7], OBJECT.theta()[7], rtol=0.01)
    assert theta[6] == pytest.approx(OutputErrorOptions().prior.normal_k) and off < 0.003


def test_a_law_that_may_not_be_felt_is_refused() -> None:
    with pytest.raises(BadInput, match="force_bias"):
        OutputErrorOptions(effects=(ToldEffect("force_bias", {"f0": 0.1}),))
