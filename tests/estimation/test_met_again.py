"""What is known of an object is put away when another is met, and taken up again."""

import numpy as np
import pytest

from mmt_drake.estimation.output_error.learn import Learner
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.model.parameters import THETA

LOOKS = (0.05, 0.08, 0.08, 50.0, 0.0, 0.0)
M, K2 = THETA.index("m"), THETA.index("k2")


def test_an_object_that_is_met_for_the_first_time_is_guessed_with_wide_deviations() -> None:
    learner = Learner(OutputErrorOptions())
    met = learner.met(learner.beginning(), 1, LOOKS)
    assert met.thing == 1 and met.told.thing == 1.0
    assert met.theta[M] == pytest.approx(0.32)  # water's density
    assert met.deviation[M] > 0.3 * met.theta[M]
    assert learner.met(met, 1, LOOKS) is met and learner.met(met, 0, ()) is met


def test_what_is_known_of_one_is_untouched_by_another_and_taken_up_when_it_is_met_again() -> None:
    learner = Learner(OutputErrorOptions())
    first = learner.met(learner.beginning(), 1, LOOKS)
    second = learner.met(first, 2, (0.1, 0.1, 0.1, 50.0, 0.0, 0.0))
    assert second.thing == 2 and not np.allclose(second.theta[M], first.theta[M])
    again = learner.met(second, 1, LOOKS)
    np.testing.assert_array_equal(again.theta, first.theta)
    np.testing.assert_array_equal(again.covariance, first.covariance)
    assert again.thing == 1 and set(again.others) == {0, 2}
