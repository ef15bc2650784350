"""A window that is let go in two parts says what it says whole."""

from dataclasses import replace

import numpy as np
import pytest

from mmt_drake.diagrams.proof.experiments.objects import drawn, path_of
from mmt_drake.estimation.output_error.beginning import Beginning
from mmt_drake.estimation.output_error.fit import Objective
from mmt_drake.estimation.output_error.options import Prior
from mmt_drake.estimation.output_error.smoothing import filter_bank
from mmt_drake.estimation.output_error.unknowns import (
    HIGH,
    LOW,
    OBJECT,
    SIZE,
    UNKNOWNS,
    Information,
    Stick,
    prior_information,
    unknowns,
)
from mmt_drake.estimation.output_error.window import FORCE, POSITION, SAMPLE_SIZE, VELOCITY, Window
from mmt_drake.model.body import ANCHOR, AXIS_SIZE, MODE
from mmt_drake.model.body import VELOCITY as BODY_VELOCITY
from mmt_drake.model.plane_call import planar
from mmt_drake.numeric.arrays import Array
from mmt_drake.numeric.least_squares import stay

H, TICKS = 0.005, 5
MODEL = replace(drawn(2), in_plane="vector")
PRIOR = prior_information(Prior(), None)
DEVIATION = np.full(UNKNOWNS, 1e-3) * SIZE


def reaches(begin: float, end: float) -> tuple[Objective, Array]:
    """The least squares of slow reaches in contact, all explained, and the unknowns of their object."""
    _, path = path_of("reaches", end)
    path = path[round(begin / 1e-3) :: TICKS]
    samples = np.ones((len(path), SAMPLE_SIZE))
    samples[:, POSITION], samples[:, VELOCITY] = path[:, :3], path[:, 3:]
    window = Window.empty().extended(samples, H, filter_bank(H, TICKS))
    objective = Objective(window, H, TICKS, Beginning.at_rest(path[0, :2]), PRIOR, 0.02, planar("vector"))
    x = unknowns(MODEL.theta())
    window.samples[:, FORCE][:, :2] += objective.difference(x, Stick()).reshape(2, -1).T
    return objective, x


def information(objective: Objective, x: Array, count: int) -> Array:
    """What the first samples say of the object (6, 6)."""
    return objective.said(x, Stick(), count).matrix[OBJECT, OBJECT]


def deviations(information: Array) -> Array:
    """Of the object's numbers (6,)."""
    return np.sqrt(np.diag(np.linalg.inv(information)))


@pytest.mark.parametrize("cut", [150, 700])
def test_samples_in_two_parts_say_what_they_say_together(cut: int) -> None:
    """The place where the second part begins is not measured: with it, k2 was told 14 times too well."""
    whole, x = reaches(3.0, 9.0)
    n = len(whole.window)
    later = replace(whole, window=whole.window.shortened(cut))
    follows = replace(later, start=whole.beginning_after(x, Stick(), cut, DEVIATION))
    together = deviations(information(whole, x, n))
    in_parts = deviations(information(whole, x, cut) + information(follows, x, n - cut))
    np.testing.assert_allclose(in_parts, together, rtol=0.02)
    placed = replace(later, start=Beginning.known(whole.end(x, Stick(), cut)))
    assert (deviations(information(whole, x, cut) + information(placed, x, n - cut)) < 0.5 * together).any()


def test_the_state_with_other_unknowns_is_where_they_bring_the_body() -> None:
    whole, x = reaches(3.0, 9.0)
    found = whole.beginning_after(x, Stick(), 500, DEVIATION)
    np.testing.assert_array_equal(found.of(x), whole.end(x, Stick(), 500))
    for j in range(UNKNOWNS):
        other = x.copy()
        other[j] += 2e-3 * SIZE[j] if x[j] < 0.5 else -2e-3 * SIZE[j]
        np.testing.assert_allclose(found.of(other), whole.end(other, Stick(), 500), rtol=1e-3, atol=2e-6)


def test_what_is_held_stays_at_rest_and_what_slides_does_not_turn() -> None:
    def end(x: Array) -> Array:
        state = np.zeros((2, AXIS_SIZE))
        state[0, [BODY_VELOCITY, MODE]] = 0.001 + x[0], 1.0
        state[1, BODY_VELOCITY] = abs(x[0])
        return state

    found = Beginning.after(end, np.zeros(UNKNOWNS), np.full(UNKNOWNS, 0.01))
    other = np.zeros(UNKNOWNS)
    other[0] = -0.01
    np.testing.assert_array_equal(found.of(other)[:, BODY_VELOCITY], 0.0)
    other[0] = 0.01
    np.testing.assert_allclose(found.of(other)[:, BODY_VELOCITY], [0.011, 0.0])


def test_a_probe_elsewhere_takes_the_body_along() -> None:
    moved = Beginning.at_rest(np.array([0.1, 0.2])).moved(np.array([0.01, -0.02]))
    np.testing.assert_allclose(moved.state[:, ANCHOR], [0.11, 0.18])


@pytest.mark.parametrize("times", [1, 4])
def test_residuals_that_repeat_each_other_count_as_one(times: int) -> None:
    whole, x = reaches(3.0, 9.0)
    random = np.random.default_rng(1)
    noise = np.repeat(random.standard_normal((2, len(whole.window) // times)), times, axis=1)
    there = stay(lambda tried: whole.difference(tried, Stick()), x, LOW, HIGH, SIZE)
    fitted = replace(there, residual=noise.ravel())
    assert whole.repeated(fitted) == pytest.approx(times, rel=0.4)


def test_where_no_difference_of_two_numbers_could_be_simulated_what_is_known_stands_for_them() -> None:
    whole, x = reaches(3.0, 9.0)
    there = stay(lambda tried: whole.residual(tried, Stick()), x, LOW, HIGH, SIZE)
    lost = there.jacobian.copy()
    lost[:, :2] = 0.0
    far = Information.about(x + 0.2 * SIZE, 0.1 * SIZE)
    covariance = np.diag((0.2 * SIZE) ** 2)
    found = whole.unexcited_beside(replace(there, jacobian=lost), Stick(), covariance, far)
    assert np.isfinite(found).all() and (np.diag(found) >= np.diag(covariance)).all()
    assert (np.diag(found) > np.diag(covariance)).any()
