"""A force that is measured late: the low pass and the delay themselves, and what the estimator makes of them."""

import numpy as np
import pytest
from hand_and_box import OBJECT, STEP, contact, free_running_error
from scipy.signal import TransferFunction, lsim

from mmt_drake.estimation.output_error.adequacy import ModelStatus
from mmt_drake.estimation.output_error.lateness import late_means
from mmt_drake.estimation.output_error.offline import estimate_output_error
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.numeric.arrays import Array


def behind(force: Array, delay: float, lag: float) -> Array:
    """The force (n, 3) behind a low pass and a delay, by SciPy's simulation."""
    time = np.arange(len(force)) * STEP
    passed = [lsim(TransferFunction([1.0], [lag, 1.0]), axis, time)[1] if lag else axis for axis in force.T]
    return np.stack([np.interp(time - delay, time, axis) for axis in passed], axis=1)


@pytest.mark.parametrize(("total", "share"), [(0.0, 0.5), (0.0043, 0.0), (0.008, 1.0), (0.0137, 0.4), (0.02, 0.25)])
def test_a_sine_is_damped_and_late_as_a_low_pass_and_a_delay_do_it(total: float, share: float) -> None:
    w, n, parts = 2.0 * np.pi * 5.0, 400, 5
    ticks = np.arange((n - 1) * parts + 1) * STEP
    found = np.empty((1, n))
    late_means(np.sin(w * ticks)[np.newaxis], STEP, parts, np.array([total, share]), found)
    response = np.exp(-1j * w * total * (1.0 - share)) / (1.0 + 1j * w * total * share)
    mean = np.sin(0.5 * w * parts * STEP) / (parts * np.sin(0.5 * w * STEP))  # of so many ticks of a sine
    expected = mean * np.imag(response * np.exp(1j * w * ticks[::parts]))
    np.testing.assert_allclose(found[0, 100:-1], expected[100:-1], atol=2e-4)


def test_what_is_not_late_is_the_mean_over_its_ticks_with_half_of_them_at_the_ends() -> None:
    ticks, found = np.random.default_rng(0).standard_normal((2, 16)), np.empty((2, 4))
    late_means(ticks, STEP, 5, np.zeros(2), found)
    for k, span in enumerate((slice(0, 3), slice(3, 8), slice(8, 13), slice(13, 16))):
        np.testing.assert_allclose(found[:, k], ticks[:, span].mean(axis=1))


@pytest.mark.parametrize(("delay", "lag"), [(0.0, 0.0), (0.004, 0.0), (0.02, 0.0), (0.0, 0.008), (0.01, 0.004)])
def test_a_late_force_is_found_to_half_a_millisecond_and_the_object_all_the_same(delay: float, lag: float) -> None:
    seen = contact(8.0)
    measurement = seen.measurement.copy()
    measurement[:, 6:] += behind(seen.force, delay, lag) - seen.force
    trace = estimate_output_error(measurement, seen.in_contact, OutputErrorOptions(step=STEP))
    _, _, total, _, _, deviation = trace.force_lateness[-1]
    assert abs(total - delay - lag) < 5e-4
    assert deviation < 5e-4
    np.testing.assert_allclose(trace.theta[-1][:8], OBJECT.theta()[:8], rtol=0.06)
    assert free_running_error(trace.theta[-1], seen) < 0.01
    assert trace.model_status[-1] == ModelStatus.ADEQUATE


def test_before_the_first_touch_nothing_is_known_of_it() -> None:
    seen = contact(1.5)
    trace = estimate_output_error(seen.measurement, np.zeros(len(seen.time)), OutputErrorOptions(step=STEP))
    np.testing.assert_allclose(trace.force_lateness[-1][[2, 5]], [0.0, 0.005], atol=1e-9)
