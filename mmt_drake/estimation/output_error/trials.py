"""What a fit by steps does not find, because least squares have valleys there, and is tried: static friction, starts.

A few trials beside each fit; which they are only its number says.
"""

from dataclasses import replace

import numpy as np

from mmt_drake.errors import MmtError
from mmt_drake.estimation.output_error.beginning import OF_LAWS, Beginning
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
from mmt_drake.model.body import MEMORY_SIZE
from mmt_drake.numeric.arrays import Array
from mmt_drake.numeric.least_squares import Minimum, minimise

# How static friction is sought: shares of Fc and speeds [m/s] that are tried one by one, and moves about what is found.
_EXCESS, _SPEED = (0.3, 1.0, 2.5), (0.001, 0.0025, 0.006, 0.015)
_MOVES = (1.3, 1.1, 1.03)
_SHARES, _LEAST_FRICTION = (0.7, 0.35, 1.0, 0.15), 0.01  # of the force, and [N], that another search begins with
_PLACE = 1e-3  # [m], by which an earlier model may have put the body elsewhere
_LOOKS = 8  # at what laws remember, all over a window
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


def better_stick(objective: Objective, minimum: Minimum, stick: Stick, numbers: range) -> tuple[Stick, Minimum]:
    """Static friction that explains more than `stick`, of those that are tried, and where the unknowns go with it.

    The unknowns have been fitted with `stick`, and another is wronged unless they may follow. How far they would go,
    and what that would bring, is told by the derivatives that the fit has left; what looks better is then simulated.
    """
    J, x, pull = minimum.jacobian.copy(), minimum.x, objective.pull.copy()
    J[:, LATENESS] = pull[LATENESS] = 0.0  # the force is late whatever friction does
    inverse, in_a_row = objective.inverse(J), objective.in_a_row(minimum)

    def followed(residual: Array) -> Array:
        """The unknowns of a linear least squares."""
        return np.clip(x - np.clip(inverse @ (J.T @ residual + pull), -SIZE, SIZE), LOW, HIGH)

    def cost(residual: Array, there: Array, tried: Stick) -> float:
        """Half of what is minimised, of residuals that are independent."""
        half = (0.5 * float(residual @ residual) + float(pull @ there)) / in_a_row
        return half + (_FIRST_GAIN if tried.speed > 0.0 else 0.0)  # the first costs what it must gain to be believed

    def promised(residual: Array, tried: Stick) -> float:
        there = followed(residual)
        return cost(residual + J @ (there - x), there, tried)

    best, found = stick, minimum
    for number in numbers:
        other = other_stick(best, float(x[FRICTION]), number)
        if other == best:
            continue
        try:
            here = objective.residual(x, other)
            if promised(here, other) > promised(found.residual, best) - _GAIN:
                continue
            moved = followed(here)
            there = objective.residual(moved, other)
        except MmtError:
            continue
        if cost(there, moved, other) < cost(found.residual, x, best) - _GAIN:
            best, found = other, replace(minimum, x=moved, residual=there)
            x = moved
    return best, found


def placed_anew(objective: Objective, x: Array, stick: Stick, steps: int) -> tuple[Beginning, Minimum]:
    """A fit where the model has become another one, and what its body is at the first sample.

    Nothing but the spring to the ground tells where a body is, until laws do that ask for it, a wall. Without either it
    is where an earlier model has put it, and where who found the law has counted from is not known. Nor is what laws
    remember by then: it is sought within what they come to in the window.

    Raises:
        MmtError: x cannot be integrated.
    """
    count = len(objective.window)
    forgotten = replace(objective, start=objective.start.elsewhere(np.zeros(2), np.zeros((2, MEMORY_SIZE))))
    later = np.linspace(0, count - 1, _LOOKS + 1)[1:].astype(int)
    usual = np.sqrt(np.mean([forgotten.end(x, stick, k)[:, OF_LAWS] ** 2 for k in later], axis=0))
    remembers = usual > 0.0
    scale = np.append(np.full(2, _PLACE), usual[remembers])

    def begun(further: Array) -> Beginning:
        memory = np.zeros((2, MEMORY_SIZE))
        memory[remembers] = further[2:]
        return objective.start.elsewhere(further[:2], memory)

    def residual(tried: Array) -> Array:
        further = tried[UNKNOWNS:]
        return np.append(replace(objective, start=begun(further)).residual(tried[:UNKNOWNS], stick), further / scale)

    as_before, there = forgotten.step(x, stick, steps), np.zeros(len(scale))
    low, high = np.append(LOW, there - np.inf), np.append(HIGH, there + np.inf)
    sizes, pull = np.append(SIZE, scale), np.append(objective.pull, there)
    found = minimise(residual, np.append(as_before.x, there), low, high, sizes, steps=steps, pull=pull)
    start = begun(found.x[UNKNOWNS:])
    return start, replace(objective, start=start).step(found.x[:UNKNOWNS], stick)


def start_elsewhere(prior: Information, number: int, force: float) -> Array:
    """Unknowns to begin another search with: those of the prior with more or less friction, and others in turn.

    Friction that is too small slides where the object is held, and no step from there shows that more would hold it.

    Args:
        prior: of the unknowns.
        number: of the start; the first is almost without friction.
        force: the largest that was measured [N]: more than all of it is no friction.
    """
    x = prior.mean()
    x[FRICTION] = _LEAST_FRICTION
    turn, about = divmod(number, 2)
    if about:
        x[FRICTION] = max(force, _LEAST_FRICTION) * _SHARES[turn % len(_SHARES)]
    elif number > 0:
        random = np.random.default_rng(number)
        x = x + np.abs(np.diag(prior.matrix)) ** -0.5 * random.standard_normal(UNKNOWNS)
        x[~LOG] = np.abs(x[~LOG])
        x[FRICTION] = _LEAST_FRICTION * (max(force, _LEAST_FRICTION) / _LEAST_FRICTION) ** random.uniform()
    return np.clip(x, LOW, HIGH)
