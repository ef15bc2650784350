"""The normal axis: what its force tells of k and b, and of where the surface is."""

from dataclasses import replace

import numpy as np
import pytest
from hand_and_box import OBJECT, STEP, contact

from mmt_drake.estimation.output_error.along_normal import said_along_normal, with_normal_axis
from mmt_drake.estimation.output_error.knowledge import Knowledge
from mmt_drake.estimation.output_error.learn import Learner
from mmt_drake.estimation.output_error.offline import OutputErrorTrace, estimate_output_error
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.estimation.output_error.window import CONTACT, FORCE, POSITION, SAMPLE_SIZE, VELOCITY
from mmt_drake.numeric.arrays import Array

H, K, B, SURFACE = 0.005, 450.0, 20.0, 1e-3


def pressed(heights: tuple[float, ...], noise: float = 0.0) -> Knowledge:
    """Knowledge with samples of presses on a surface that is at another height each time, told to be at 0."""
    n = 120
    z = 0.004 - 0.008 * np.sin(np.pi * np.arange(n) * H / 0.6) ** 2
    rate = -0.008 * np.pi / 0.6 * np.sin(2.0 * np.pi * np.arange(n) * H / 0.6)
    samples = np.ones((n * len(heights), SAMPLE_SIZE))
    samples[:, POSITION] = samples[:, VELOCITY] = samples[:, FORCE] = 0.0
    samples[:, POSITION.stop - 1], samples[:, VELOCITY.stop - 1] = (np.tile(one, len(heights)) for one in (z, rate))
    above = z - np.repeat(np.array(heights)[:, np.newaxis], n, axis=1)
    force = np.where(above < 0.0, -K * above - B * rate, 0.0).ravel()
    samples[:, FORCE.stop - 1] = force + noise * np.random.default_rng(5).standard_normal(len(force))
    samples[:, CONTACT] = np.tile(z < 0.0, len(heights))
    learner = Learner(OutputErrorOptions(step=H, sample=H))
    nothing = learner.beginning()
    return replace(nothing, window=nothing.window.extended(samples, H, learner._bank), noise=max(noise, 1e-3))


def told(known: Knowledge, surface: float = SURFACE) -> Knowledge:
    return with_normal_axis(known, OutputErrorOptions().prior, H, surface)


def heights_of(known: Knowledge) -> tuple[Array, Array]:
    begins = np.flatnonzero(np.diff(known.window.contact, prepend=0.0) > 0.0)
    return known.window.height[begins], known.window.unsure[begins]


def test_each_contact_tells_its_own_height_and_k_and_b_are_not_bent_by_it() -> None:
    heights = 0.001, -0.0008, 0.0, 0.0003
    known = told(pressed(heights, noise=0.01))
    found, deviation = heights_of(known)
    np.testing.assert_allclose(known.normal, [K, B], rtol=0.01)
    np.testing.assert_allclose(found, heights, atol=3e-5)
    assert (np.abs(found - heights) < 3.0 * deviation).all() and (deviation < 3e-5).all()
    bent = told(pressed(heights, noise=0.01), surface=0.0)
    assert abs(bent.normal[0] / K - 1.0) > 0.03, "with the heights taken for certain"
    assert not bent.window.height.any() and not bent.window.unsure.any()


def test_a_touch_is_where_the_probe_crosses_the_height_that_is_found() -> None:
    before = pressed((0.001,))
    after = told(before)
    (first,), (second,) = (np.flatnonzero(np.diff(one.window.contact) > 0.0) for one in (before, after))
    z = before.window.motion[:, 2]
    assert z[first] > 0.0 > z[first + 1]
    assert z[second] > 0.001 > z[second + 1]


def test_what_is_said_of_k_and_b_is_that_of_one_least_squares_with_the_heights() -> None:
    """Derived anew: heights as further unknowns of one dense problem with their prior, eliminated by its inverse."""
    known = pressed((0.0005, -0.0002), noise=0.02)
    said = said_along_normal(known, H, slice(None), SURFACE)
    whole = said_along_normal(known, H, slice(None), 0.0)
    window, force = known.window, known.normal[0] * SURFACE
    begins = np.flatnonzero(np.diff(window.contact, prepend=0.0) > 0.0)
    rows = np.column_stack([-window.motion[:, 2], -window.motion[:, 5]]) * window.contact[:, np.newaxis]
    which = np.cumsum(np.isin(np.arange(len(window)), begins))[:, np.newaxis] == np.arange(1, len(begins) + 1)
    rows = np.hstack([rows, which * window.contact[:, np.newaxis]]) * (window.weight[:, 2:] / known.noise)
    normal = rows.T @ rows + np.diag([0.0, 0.0, force**-2.0, force**-2.0])
    right = rows.T @ (window.samples[:, FORCE][:, 2] / known.noise)
    covariance = np.linalg.inv(normal)
    np.testing.assert_allclose(np.linalg.inv(said.numbers.matrix), covariance[:2, :2], rtol=1e-6)
    np.testing.assert_allclose(said.numbers.mean(), (covariance @ right)[:2], rtol=1e-6)
    np.testing.assert_allclose(said.certain, np.diag(normal)[2:], rtol=1e-6)
    assert len(whole.certain) == 0
    np.testing.assert_allclose(whole.numbers.matrix, normal[:2, :2], rtol=1e-6)


def on_a_surface(higher: float) -> OutputErrorTrace:
    """What is fitted in two seconds to an object whose surface is so much higher than contact is told for."""
    seen = contact(2.0)
    measurement = seen.measurement.copy()
    measurement[:, 2] += higher
    in_contact = np.where(measurement[:, 2] < 0.0, 1.0, 0.0)
    return estimate_output_error(measurement, in_contact, OutputErrorOptions(step=STEP, surface=SURFACE))


@pytest.mark.parametrize("higher", [-0.001, 0.0, 0.001])
def test_on_a_surface_that_is_elsewhere_all_numbers_of_the_object_are_found_within_two_seconds(higher: float) -> None:
    theta = on_a_surface(higher).theta[-1]
    np.testing.assert_allclose(theta[6:8], OBJECT.theta()[6:8], rtol=0.02)
    np.testing.assert_allclose(theta[[0, 2, 4]], OBJECT.theta()[[0, 2, 4]], rtol=0.15)
