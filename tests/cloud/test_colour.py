"""Colours as the eye sees them."""

import numpy as np
import pytest

from mmt_drake.cloud.colour import cielab

PUBLISHED = {  # of sRGB's primaries, D65, 2 degrees: Lindbloom's calculator
    (1.0, 0.0, 0.0): (53.24, 80.09, 67.20),
    (0.0, 1.0, 0.0): (87.73, -86.18, 83.18),
    (0.0, 0.0, 1.0): (32.30, 79.19, -107.86),
    (1.0, 1.0, 1.0): (100.0, 0.0, 0.0),
    (0.0, 0.0, 0.0): (0.0, 0.0, 0.0),
    (0.5, 0.5, 0.5): (53.39, 0.0, 0.0),
}


@pytest.mark.parametrize("srgb", PUBLISHED)
def test_primaries_have_their_published_numbers(srgb: tuple[float, float, float]) -> None:
    np.testing.assert_allclose(cielab(np.array(srgb)), PUBLISHED[srgb], atol=0.03)


def test_what_is_not_seen_has_no_colour_and_an_array_keeps_its_shape() -> None:
    found = cielab(np.array([[[np.nan] * 3, [1.0, 1.0, 1.0]]]))
    assert found.shape == (1, 2, 3) and np.isnan(found[0, 0]).all() and found[0, 1, 0] == pytest.approx(100.0)
