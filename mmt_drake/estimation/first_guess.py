"""A first guess of an object that nobody has touched: by its looks, and by like objects that have been.

What is carried over from one object to another does not depend on size: with A the area of the top, H the height and
g = 9.81 m/s^2 these are density m/(A H), stiffness and damping of a column of the material, k2 H/A and b2 H/A, and the
coefficient of friction Fc/(m g). Their logarithms are averaged over objects with weights exp(-d^2/2), d being the
distances of the logarithms of volume and height over `LIKE`. One of another colour weighs less, down to `OTHER_COLOUR`
of that; where a colour is not known it does not count. What is believed beforehand has the weight 1: a soft thing as
dense as water. The deviation of a logarithm is `WIDEST` where nothing like it is known, and never below `NARROWEST`:
like things differ. No guess holds to the world: k1 = 0.
"""

import math

import numpy as np
from numba import njit

from mmt_drake.model.parameters import THETA
from mmt_drake.model.scene_layout import LOOKS
from mmt_drake.numeric.arrays import Array

LIKE = 0.5
"""Of the logarithms of volume and height: objects that are like each other differ by so much."""
LIKE_COLOUR = 20.0
"""In CIELAB: things of one make differ by less, by the light on them; red, yellow, green and blue by 60 and more."""
OTHER_COLOUR = 0.3
"""Of its weight that a thing of quite another colour keeps: things of one make may be dyed."""
WIDEST, NARROWEST = 1.0, 0.4
"""Deviations of the logarithm of a number that is guessed."""
DENSITY, FRICTION = 1000.0, 0.3
"""Believed beforehand [kg/m^3], [1]."""
STIFFNESS, DAMPING = 2500.0, 100.0
"""Of a column of the material, believed beforehand [N/m^2], [N s/m^2]."""
_G = 9.81  # [m/s^2]
_LEAST_M = 1e-3  # [m] of a side
_M, _K1, _K2, _B1, _B2, _FC, _NORMAL_K, _NORMAL_B, _FS, _VD = range(len(THETA))
_SMALLEST, _GREATEST = np.zeros(len(THETA)), np.zeros(len(THETA))
_SMALLEST[:] = 0.02, 0.0, 5.0, 0.0, 0.1, 0.0, 5.0, 0.0, 0.0, 0.0
_GREATEST[:] = 50.0, 0.0, 2e4, 100.0, 200.0, 20.0, 2e4, 200.0, 20.0, 0.0


@njit(cache=True)
def _numbers(theta: Array, area: float, height: float, out: Array) -> None:
    """Logarithms of what does not depend on size (6): density, k2, b2, friction, normal k and normal b."""
    tiny = 1e-9
    out[0] = math.log(max(theta[_M], tiny) / (area * height))
    out[1] = math.log(max(theta[_K2], tiny) * height / area)
    out[2] = math.log(max(theta[_B2], 0.1) * height / area)
    out[3] = math.log(max(theta[_FC], 0.01) / (max(theta[_M], tiny) * _G))
    out[4] = math.log(max(theta[_NORMAL_K], tiny) * height / area)
    out[5] = math.log(max(theta[_NORMAL_B], 0.1) * height / area)


@njit(cache=True)
def guess(looks: Array, others: Array, thetas: Array, count: int, theta: Array) -> float:
    """Guess the numbers of an object; always physical, and stable.

    Args:
        looks: (LOOKS,) of it: height, extents along x and y [m], colour as `mmt_drake.model.scene_layout.COLOUR`.
        others: (n, LOOKS) of objects that have been touched.
        thetas: (n, 10) their numbers.
        count: how many of the rows count.
        theta: (10,) to be filled with the guess.

    Returns:
        The deviation of the logarithms of m, k2, b2 and Fc.
    """
    area = max(looks[1], _LEAST_M) * max(looks[2], _LEAST_M)
    height = max(looks[0], _LEAST_M)
    mean, own = np.empty(6), np.empty(6)
    mean[0], mean[1], mean[2], mean[3] = math.log(DENSITY), math.log(STIFFNESS), math.log(DAMPING), math.log(FRICTION)
    mean[4], mean[5] = mean[1], mean[2]
    total = 1.0
    for i in range(count):
        other = max(others[i, 1], _LEAST_M) * max(others[i, 2], _LEAST_M)
        high = max(others[i, 0], _LEAST_M)
        volume, tall = math.log(area * height / (other * high)) / LIKE, math.log(height / high) / LIKE
        apart = 0.0
        for j in range(3, LOOKS):
            apart += ((looks[j] - others[i, j]) / LIKE_COLOUR) ** 2
        alike = OTHER_COLOUR + (1.0 - OTHER_COLOUR) * math.exp(-0.5 * apart) if math.isfinite(apart) else 1.0
        weight = alike * math.exp(-0.5 * (volume * volume + tall * tall))
        _numbers(thetas[i], other, high, own)
        total += weight
        for j in range(6):
            mean[j] += weight / total * (own[j] - mean[j])
    theta[:] = 0.0
    theta[_M] = math.exp(mean[0]) * area * height
    theta[_K2], theta[_NORMAL_K] = math.exp(mean[1]) * area / height, math.exp(mean[4]) * area / height
    theta[_B2], theta[_NORMAL_B] = math.exp(mean[2]) * area / height, math.exp(mean[5]) * area / height
    theta[_FC] = math.exp(mean[3]) * theta[_M] * _G
    for j in range(len(theta)):
        theta[j] = min(max(theta[j], _SMALLEST[j]), _GREATEST[j])
    theta[_FS] = theta[_FC]
    # A light body on a stiff, damped contact is the fastest of all: its damper is no stronger than its spring wants.
    theta[_B2] = min(theta[_B2], 2.0 * math.sqrt(theta[_K2] * theta[_M]))
    return max(NARROWEST, WIDEST / math.sqrt(1.0 + 3.0 * (total - 1.0)))
