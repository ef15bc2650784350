"""Reaching movements of a hand, their duration and their path, and touches: how it gets into the object and out."""

import math

from mmt_drake.errors import BadInput
from mmt_drake.motion.analytic import Row, step

AXES = {"x": 0, "y": 1}
"""Along which a motion may go."""
TOUCH_S = 0.6
"""That the hand takes from above the surface into the object, and back [s]."""

FITTS_INTERCEPT = 0.10  # [s]
FITTS_SLOPE = 0.12  # [s/bit]; published slopes for hand movements lie between 0.1 and 0.2


def fitts_duration(distance: float, width: float) -> float:
    """Duration of a reach over `distance` [m] to a target `width` [m] wide [s].

    T = a + b log2(D / W + 1): Fitts, "The information capacity of the human motor system", J. Exp.
    Psychol. 47(6), 1954, in the form of MacKenzie, "Fitts' law as a research and design tool",
    Human-Computer Interaction 7, 1992.

    Raises:
        BadInput: a negative distance, or a width that is not positive.
    """
    if not (distance >= 0.0 and width > 0.0):
        raise BadInput("reach", found=f"distance {distance} m, width {width} m", expected=">= 0 and > 0")
    return FITTS_INTERCEPT + FITTS_SLOPE * math.log2(distance / width + 1.0)


def reach(start: float, end: float, displacement: tuple[float, float], *, bow: float = 0.0) -> list[Row]:
    """Steps of one tangential reach from `start` to `end` [s] by `displacement` (x, y) [m].

    `bow` is the sideways excursion half-way [m], to the left of the direction of travel: hand paths
    are gently curved (Atkeson and Hollerbach, "Kinematic features of unrestrained vertical arm
    movements", J. Neurosci. 5(9), 1985). It is made of a step out and a step back.
    """
    rows = [step(axis, start, end, displacement[axis]) for axis in (0, 1)]
    length = math.hypot(*displacement)
    if bow != 0.0 and length > 0.0:
        middle = 0.5 * (start + end)
        for axis, sideways in ((0, -displacement[1]), (1, displacement[0])):
            out = bow * sideways / length
            rows += [step(axis, start, middle, out), step(axis, middle, end, -out)]
    return rows


def press(start: float, end: float, height: float) -> list[Row]:
    """Down by `height` from `start` on, and up again until `end`."""
    return [step(2, start, start + TOUCH_S, -height), step(2, end - TOUCH_S, end, height)]


def at_least(name: str, duration: float, least: float) -> None:
    """Refuse a duration [s] too short for a motion."""
    if duration < least:
        raise BadInput(name, at="duration", found=f"{duration} s", expected=f">= {least} s")
