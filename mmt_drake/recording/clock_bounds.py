"""How two clocks stand to each other, from time stamps of packets that went both ways between them.

A packet cannot arrive before it was sent. So each one bounds the difference of the clocks from one side, and together
the packets of both ways leave the straight lines (offset, drift) between: D. Mills, "Internet time synchronization: the
network time protocol", IEEE Trans. Communications 39 (1991), section 2; for lines with drift V. Paxson, "On calibrating
measurements of packet transit times", ACM SIGMETRICS 1998, section 4.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.optimize import linprog

from mmt_drake.errors import BadInput
from mmt_drake.numeric.arrays import Array

FASTEST_DRIFT: Final = 1e-3
"""By which two clocks may drift apart at most, s a second; those of computers stay below 1e-4."""


@dataclass(frozen=True)
class ClockBounds:
    """The difference of two clocks, first less second: `offset + drift (t - middle)`, t on the first [s].

    Attributes:
        middle: of the packets' times, on the first clock [s].
        offset: there [s].
        drift: 0 where none can be told [s/s].
        uncertainty: the difference is within so much of this line over the whole span, whatever the network did [s].
        least_drift, most_drift: between which the drift lies for certain [s/s].
    """

    middle: float
    offset: float
    drift: float
    uncertainty: float
    least_drift: float
    most_drift: float

    @property
    def drift_told(self) -> bool:
        """Whether the clocks drift for certain."""
        return not self.least_drift <= 0.0 <= self.most_drift

    def second(self, first: Array) -> Array:
        """Times on the second clock, (n,), of times on the first [s]."""
        since = first - self.middle
        return first - self.offset - self.drift * since

    def first(self, second: Array) -> Array:
        """Times on the first clock, (n,), of times on the second [s]."""
        return self.middle + (second + self.offset - self.middle) / (1.0 - self.drift)


def clock_bounds(arrived: Array, sent: Array, answered: Array, received: Array, source: object) -> ClockBounds:
    """The difference of two clocks.

    Args:
        arrived, sent: (n,) packets to the first: when they arrived there, on its clock, and when they were sent, on
            the second's [s].
        answered, received: (m,) packets to the second: when they were sent, on the first's clock, and when they
            arrived there, on the second's [s].
        source: what a refusal names.

    Raises:
        BadInput: no packets one way; or no straight line fits: a clock was set in between.
    """
    if not len(arrived) or not len(answered):
        raise BadInput(source, found="packets one way alone", expected="time stamps of packets both ways")
    middle = 0.5 * float(max(arrived.max(), answered.max()) + min(arrived.min(), answered.min()))
    zero = float(arrived[0] - sent[0])  # near the difference: what is left is small beside it, and keeps its digits
    above = _hull(arrived - middle, arrived - sent - zero)
    below = _hull(answered - middle, -(answered - received - zero))
    # Lines a + b t under each of `above` and over each of `below`.
    rows = np.vstack([np.column_stack([np.ones(len(above)), above[:, 0]]),
                      -np.column_stack([np.ones(len(below)), below[:, 0]])])  # fmt: skip
    limits = np.concatenate([above[:, 1], below[:, 1]])

    def extreme(goal: Array) -> Array | None:
        found = linprog(goal, rows, limits, bounds=[(None, None), (-FASTEST_DRIFT, FASTEST_DRIFT)], method="highs")
        return np.asarray(found.x) if found.status == 0 else None

    span = [min(above[:, 0].min(), below[:, 0].min()), max(above[:, 0].max(), below[:, 0].max())]
    goals = [np.array([0.0, 1.0])] + [np.array([1.0, t]) for t in span]
    ends = [(extreme(goal), extreme(-goal)) for goal in goals]
    contradiction = BadInput(
        source, found="time stamps that contradict each other", expected="two clocks of which none was set in the run"
    )
    if any(end is None for pair in ends for end in pair):
        raise contradiction
    values = [[float(goal @ end) for end in pair if end is not None] for goal, pair in zip(goals, ends, strict=True)]
    (least, most), *at_ends = values
    line = _middle_line(rows, limits, drifts=not least <= 0.0 <= most)
    if line is None:
        raise contradiction
    reach = max(abs(value - (line[0] + line[1] * t)) for t, pair in zip(span, at_ends, strict=True) for value in pair)
    return ClockBounds(middle, zero + float(line[0]), float(line[1]) + 0.0, float(reach), least, most)


def _middle_line(rows: Array, limits: Array, *, drifts: bool) -> Array | None:
    """(2) offset and drift of the line that stays farthest from all bounds, without drift where none is certain.

    None: there is no such line.
    """
    widened = np.column_stack([rows, np.ones(len(rows))])
    most = FASTEST_DRIFT if drifts else 0.0
    found = linprog(
        [0.0, 0.0, -1.0], widened, limits, bounds=[(None, None), (-most, most), (0.0, None)], method="highs"
    )
    return np.asarray(found.x[:2]) if found.status == 0 else None


def _hull(t: Array, values: Array) -> Array:
    """(k, 2) corners of the lower convex hull of points: all that a line under every point has to stay under."""
    order = np.lexsort((values, t))
    corners: list[tuple[float, float]] = []
    for point in zip(t[order].tolist(), values[order].tolist(), strict=True):
        if corners and corners[-1][0] == point[0]:
            continue  # the lower of the two came first
        while len(corners) > 1 and _turns_down(corners[-2], corners[-1], point):
            corners.pop()
        corners.append(point)
    return np.array(corners)


def _turns_down(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> bool:
    return (b[0] - a[0]) * (c[1] - a[1]) <= (b[1] - a[1]) * (c[0] - a[0])
