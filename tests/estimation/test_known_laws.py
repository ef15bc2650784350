"""An estimator that is told a law of the object finds the numbers beside it; one that is not bends them."""

import numpy as np
import pytest
from hand_and_box import OBJECT, contact, free_running_error

from mmt_drake.errors import BadInput, MmtError
from mmt_drake.estimation.output_error.layout import MODEL, STATUS, Status
from mmt_drake.estimation.output_error.offline import estimate_output_error
from mmt_drake.estimation.output_error.options import OutputErrorOptions
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


def test_a_law_that_does_without_what_is_sought_is_refused() -> None:
    with pytest.raises(BadInput, match="does without Fc"):
        OutputErrorOptions(effects=(ToldEffect("asymmetric_friction", {"Fc_plus": 0.2, "Fc_minus": 0.3}),))


def test_a_law_that_may_not_be_felt_is_refused() -> None:
    with pytest.raises(BadInput, match="force_bias"):
        OutputErrorOptions(effects=(ToldEffect("force_bias", {"f0": 0.1}),))
