"""The offset measured on a cloud is where a sphere that comes down meets it."""

import math

import numpy as np
import pytest

from mmt_drake.cloud import contact_offset, plane
from mmt_drake.errors import BadInput
from mmt_drake.hw.realsense.untouched import measured_offset

R2 = 5e-3
BOX = (-0.1, -0.1), (0.1, 0.1)


def test_on_points_strewn_at_random_with_noise_it_is_the_closed_form() -> None:
    for n, noise in ((20_000, 2e-4), (50_000, 5e-4)):
        cloud = plane(n, layout="random", noise=noise, seed=2)
        found = measured_offset(cloud.points(), R2, *BOX)
        assert found == pytest.approx(contact_offset(R2, 0.3 / math.sqrt(n), noise), abs=4e-5)


def test_on_a_lattice_it_is_the_closed_form_without_noise() -> None:
    cloud = plane(10_000)
    assert measured_offset(cloud.points(), R2, *BOX) == pytest.approx(contact_offset(R2, cloud.spacing), abs=1e-5)


def test_an_error_of_height_is_in_it() -> None:
    points = plane(10_000).points()
    apart = measured_offset(points + np.array([0.0, 0.0, 3e-4]), R2, *BOX) - measured_offset(points, R2, *BOX)
    assert apart == pytest.approx(3e-4, abs=1e-12)


def test_no_surface_is_refused() -> None:
    with pytest.raises(BadInput, match="untouched surface"):
        measured_offset(np.zeros((1, 3)), R2, *BOX)
