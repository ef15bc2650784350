"""Where an arm's tip touched, from what was recorded of its position and force."""

from typing import NamedTuple

import numpy as np

from mmt_drake.analysis.signals import rising
from mmt_drake.errors import BadInput, check_number
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording import Recording

_FREE = 0.1  # without force before a touch [s]


class Touches(NamedTuple):
    """The first moments of the contacts of a recording.

    Attributes:
        times: (n,) of the touches [s].
        positions: (n, 3) of the tip then [m], table frame.
        spread: (n,) by how much a position may be off [m].
    """

    times: Array
    positions: Array
    spread: Array


def touches_of(recording: Recording, *, level: float = 0.5) -> Touches:
    """Find where contacts began by the measured force alone: what a camera is taken to see plays no part.

    A touch is where the force comes to `level` after 0.1 s below it. The last sample below half of that and the first
    that reaches it make a line; where it meets no force the tip touched. Half the way between the two samples is told
    as the spread.

    Args:
        recording: with `position_*` [m] and `force_*` [N], this free of the sensor's offset.
        level: well above the noise of the force [N].

    Raises:
        BadInput: a column is missing, no such level, or a force that is never below half of it or never reaches it.
    """
    check_number("touches", "level", level, least=0.0, open_interval=True)
    time, positions = recording.time, recording.vector("position")
    force = np.linalg.norm(recording.vector("force"), axis=1)
    for found, expected in (
        (force.min() >= 0.5 * level, f"free space, with less than {0.5 * level:g} N"),
        (force.max() < level, f"touches of {level:g} N or more"),
    ):
        if found:
            told = f"{force.min():.3g} to {force.max():.3g} N"
            raise BadInput(recording.source, at="force", found=told, expected=expected)
    pressed, free = force >= level, np.flatnonzero(force < 0.5 * level)
    reached = rising(pressed)
    rows = list[tuple[float, Array, float]]()
    for i in reached:
        before = int(np.searchsorted(free, i)) - 1
        if before < 0:
            continue
        j = int(free[before])
        since = int(np.searchsorted(time, time[j] - _FREE))
        if time[j] - time[0] < _FREE or pressed[since:i].any():
            continue
        part = force[i] / (force[i] - force[j])
        way = positions[i] - positions[j]
        rows.append((time[i] - part * (time[i] - time[j]), positions[i] - part * way, 0.5 * float(np.linalg.norm(way))))
    times, places, spread = zip(*rows, strict=True) if rows else ((), (), ())
    return Touches(np.array(times), np.array(places).reshape(-1, 3), np.array(spread))
