"""Touch and release of scripted motions: how the hand gets into the object and out of it."""

from mmt_drake.errors import BadInput
from mmt_drake.motion.analytic import Row, step

AXES = {"x": 0, "y": 1}
"""Along which a motion may go."""
TOUCH_S = 0.6
"""That the hand takes from above the surface into the object, and back [s]."""


def press(start: float, end: float, height: float) -> list[Row]:
    """Down by `height` from `start` on, and up again until `end`."""
    return [step(2, start, start + TOUCH_S, -height), step(2, end - TOUCH_S, end, height)]


def at_least(name: str, duration: float, least: float) -> None:
    """Refuse a duration [s] too short for a motion."""
    if duration < least:
        raise BadInput(name, at="duration", found=f"{duration} s", expected=f">= {least} s")
