"""The offset by which a measured cloud is taken lower, so that contact begins where the surface is."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mmt_drake.errors import BadInput, check_number

_PLACES = 2000
_LEAST_PLACES = 100


def measured_offset(
    points: ArrayLike, r2: float, low: tuple[float, float], high: tuple[float, float], *, seed: int = 0
) -> float:
    """Mean height above z = 0 at which a sphere that comes down meets the first point of an untouched surface [m].

    What `ProxySettings.surface_offset` should be for this camera: sampling, noise, its correlation, the voxel filter
    and what is left of the calibration's error are all in it. `mmt_drake.cloud.contact_offset` is the closed form for
    points strewn at random with independent noise, and a voxel filter leaves neither. A sphere of radius r2 whose
    centre is at a horizontal distance rho from a point of height z touches it at z + √(r2² - rho²); the highest counts.

    Args:
        points: (n, 3) of the object's flat top, untouched, from one or, better, several frames one by one: average.
        r2: contact radius of the detector [m].
        low: least x, y where the sphere comes down [m]; r2 or more from the object's rim.
        high: greatest x, y.
        seed: of the places.

    Raises:
        BadInput: no surface there.
    """
    from scipy.spatial import cKDTree

    check_number("measured offset", "r2", r2, least=0.0, open_interval=True)
    cloud: NDArray[np.float64] = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    places = np.random.default_rng(seed).uniform(low, high, (_PLACES, 2))
    heights = []
    for place, near in zip(places, cKDTree(cloud[:, :2]).query_ball_point(places, r2), strict=True):
        if near:
            apart = ((cloud[near, :2] - place) ** 2).sum(axis=1)
            heights.append(float((cloud[near, 2] + np.sqrt(np.maximum(r2 * r2 - apart, 0.0))).max()))
    if len(heights) < _LEAST_PLACES:
        found = f"points below {len(heights)} of {_PLACES} places"
        raise BadInput("measured offset", found=found, expected="an untouched surface")
    return float(np.mean(heights))
