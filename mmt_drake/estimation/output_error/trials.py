"""What a fit by steps does not find, because least squares have valleys there, and is tried: static friction, lateness.

A few trials beside each fit; which they are only its number says.
"""

from dataclasses import replace

import numpy as np

from mmt_drake.errors import MmtError
from mmt_drake.estimation.output_error.fit import Objective
from mmt_drake.estimation.output_error.unknowns import (
    FRICTION,
    HIGH,
    LATENESS,
    LOG,
    LOW,
    SIZE,
    UNKNOWNS,
    Information,
    Stick,
)
from mmt_drake.numeric.arrays import Array
from mmt_drake.numeric.least_squares import Minimum

# How static friction is sought: shares of Fc and speeds [m/s] that are tried one by one, and moves about what is found.
_EXCESS, _SPEED = (0.3, 1.0, 2.5), (0.001, 0.0025, 0.006, 0.015)
_MOVES = (1.3, 1.1, 1.03)
_LATE = (0.0, 0.002, 0.004, 0.008, 0.016, 0.032)  # how late the force may be, tried one by one [s]
_GAIN, _FIRST_GAIN = 3.0, 8.0  # of half the sum of squares over the variance, for another value and for the first


def other_stick(stick: Stick, Fc: float, number: int) -> Stick:
    """The static friction to try next, about what is believed and all over in turn."""
    turn, about = divmod(number, 2)
    if about and stick.speed > 0.0:
        size, direction = divmod(turn, 4)
        move = _MOVES[size % len(_MOVES)] ** (1 if direction < 2 else -1)
        return Stick(stick.excess * move, stick.speed) if direction % 2 else Stick(stick.excess, stick.speed * move)
    point = turn % (len(_EXCESS) * len(_SPEED) + 1)
    if point == 0:
        return Stick()
    share, speed = _EXCESS[(point - 1) % len(_EXCESS)], _SPEED[(point - 1) // len(_EXCESS)]
    return Stick(share * max(Fc, 0.02), speed)


class Followed:
    """How the other unknowns would follow, by the derivatives that a fit has left, where friction or lateness is tried.

    The unknowns have been fitted with what is believed, and what is tried is wronged unless they may follow.

    Args:
        objective: of the fit.
        minimum: where it ended.
    """

    def __init__(self, objective: Objective, minimum: Minimum) -> None:
        self.x, self._objective = minimum.x, objective
        self._jacobian, self._pull = minimum.jacobian.copy(), objective.pull.copy()
        self._jacobian[:, LATENESS] = self._pull[LATENESS] = 0.0  # the force is late whatever the object does
        self._inverse = objective.inverse(self._jacobian)
        self.in_a_row = objective.in_a_row(minimum)

    def to(self, residual: Array, x: Array) -> Array:
        """The unknowns to which they would go from x, where this is left."""
        step = self._inverse @ (self._jacobian.T @ residual + self._pull)
        return np.clip(x - np.clip(step, -SIZE, SIZE), LOW, HIGH)

    def cost(self, residual: Array, x: Array) -> float:
        """Half of what is minimised, for as many residuals as are independent."""
        return (0.5 * float(residual @ residual) + float(self._objective.pull @ x)) / self.in_a_row

    def promised(self, residual: Array, x: Array) -> float:
        """The cost that there would be."""
        there = self.to(residual, x)
        return self.cost(residual + self._jacobian @ (there - x), there)


def better_stick(objective: Objective, minimum: Minimum, stick: Stick, numbers: range) -> tuple[Stick, Minimum]:
    """Static friction that explains more than `stick`, of those that are tried, and where the unknowns go with it.

    How far they would go, and what that would bring, is told by the fit's derivatives; what looks better is simulated.
    """
    follow, best, found, x = Followed(objective, minimum), stick, minimum, minimum.x

    def first(tried: Stick) -> float:  # costs as much as it must gain to be believed
        return _FIRST_GAIN if tried.speed > 0.0 else 0.0

    for number in numbers:
        other = other_stick(best, float(x[FRICTION]), number)
        if other == best:
            continue
        try:
            here = objective.residual(x, other)
            if follow.promised(here, x) + first(other) > follow.promised(found.residual, x) + first(best) - _GAIN:
                continue
            moved = follow.to(here, x)
            there = objective.residual(moved, other)
        except MmtError:
            continue
        if follow.cost(there, moved) + first(other) < follow.cost(found.residual, x) + first(best) - _GAIN:
            best, found, x = other, replace(minimum, x=moved, residual=there), moved
    return best, found


def better_lateness(objective: Objective, minimum: Minimum, stick: Stick, number: int) -> Minimum:
    """Another lateness that explains more, if one of those that are tried does, and where the unknowns go with it.

    Friction makes valleys in the least squares: where the force jumps, it seems to say when to the tick.
    """
    follow, x = Followed(objective, minimum), minimum.x
    share = float(number % 2)
    for total in _LATE:
        tried = x.copy()
        tried[LATENESS] = total, share
        try:
            here = objective.residual(tried, stick)
            if follow.promised(here, tried) > follow.cost(minimum.residual, x) - _GAIN:
                continue
            moved = follow.to(here, tried)
            there = objective.residual(moved, stick)
        except MmtError:
            continue
        if follow.cost(there, moved) < follow.cost(minimum.residual, x) - _GAIN:
            minimum, x = replace(minimum, x=moved, residual=there), moved
    return minimum


def start_elsewhere(prior: Information, number: int) -> Array:
    """Unknowns to begin another search with; the first are those of a prior without friction."""
    x = prior.mean()
    random = np.random.default_rng(number)
    if number > 0:
        x = x + np.abs(np.diag(prior.matrix)) ** -0.5 * random.standard_normal(UNKNOWNS)
        x[~LOG] = np.abs(x[~LOG])
    x[FRICTION] = 0.01 * 10.0 ** random.uniform(0.0, 2.0 * (number > 0))
    return np.clip(x, LOW, HIGH)
