"""Touches whose instant is not certain: as a part of the noise, and what the estimator makes of them."""

import numpy as np
import pytest
from hand_and_box import OBJECT, STEP, contact
from scipy.linalg import block_diag, inv, sqrtm

from mmt_drake.estimation.output_error.offline import OutputErrorTrace, estimate_output_error
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.estimation.output_error.unsure_touches import LONGEST_S, UnsureTouches, since_touch

LATE_S = 0.002


def test_a_difference_is_weighed_with_the_inverse_root_of_its_covariance() -> None:
    rng = np.random.default_rng(3)
    contact = np.array([1, 1, 0, 1, 1, 1, 0, 0, 1, 1], dtype=float)
    made, difference = rng.standard_normal((2, 20))
    parts = []
    for begin, end in ((3, 6), (8, 10)):  # the first contact did not begin here
        where = np.r_[begin:end, 10 + begin : 10 + end]
        parts.append((where, np.real(inv(sqrtm(np.eye(len(where)) + np.outer(made[where], made[where]))))))
    order = np.concatenate([where for where, _ in parts])
    expected = difference.copy()
    expected[order] = block_diag(*(root for _, root in parts)) @ difference[order]
    np.testing.assert_allclose(UnsureTouches.of(contact, made).taken_from(difference), expected, atol=1e-12)


def test_what_touches_cannot_have_made_stays_as_it_is() -> None:
    difference = np.arange(8.0)
    np.testing.assert_array_equal(
        UnsureTouches.of(np.array([0, 1, 1, 0.0]), np.zeros(8)).taken_from(difference), difference
    )
    held = UnsureTouches.of(np.ones(4), np.ones(8))  # no touch in this window
    np.testing.assert_array_equal(held.taken_from(difference), difference)


@pytest.mark.parametrize(
    ("higher", "rate", "expected"), [(3e-4, -0.03, 0.01), (-3e-4, -0.03, -0.01), (1e-3, 0.0, LONGEST_S)]
)
def test_a_higher_surface_was_touched_sooner_by_its_height_over_the_speed(
    higher: float, rate: float, expected: float
) -> None:
    assert since_touch(higher, rate) == pytest.approx(expected)


def on_a_surface(higher: float, known_to: float) -> OutputErrorTrace:
    """A force 2 ms late of an object whose surface is so much higher than contact is told for, and what is fitted."""
    seen = contact(12.0, lifts=2)
    measurement, late = seen.measurement.copy(), round(LATE_S / STEP)
    measurement[late:, 6:] += seen.force[:-late] - seen.force[late:]
    measurement[:, 2] += higher
    told = np.where(measurement[:, 2] - 1e-5 < 0.0, 1.0, 0.0)
    return estimate_output_error(measurement, told, OutputErrorOptions(step=STEP, surface=known_to))


@pytest.mark.parametrize("higher", [2e-4, -2e-4, 5e-4])
def test_a_surface_that_is_elsewhere_makes_no_mass_and_no_lateness(higher: float) -> None:
    trace = on_a_surface(higher, 4e-4)
    assert abs(trace.force_lateness[-1][2] - LATE_S) < 5e-4
    np.testing.assert_allclose(trace.theta[-1][:6], OBJECT.theta()[:6], rtol=0.1)
