"""The layout of what a tick of the estimator puts out and of what it remembers."""

from enum import IntEnum
from typing import NamedTuple

from mmt_drake.estimation.output_error.frozen_signal import SIZE as HISTORY_SIZE
from mmt_drake.model import flexible_box as box
from mmt_drake.model import message_layout
from mmt_drake.model.held_body import HELD_SIZE
from mmt_drake.model.message_layout import MESSAGE_SIZE
from mmt_drake.model.parameters import FORCE_LATENESS, THETA
from mmt_drake.numeric.layout import Layout
from mmt_drake.told_laws import TOLD_SIZE, VECTOR_SIZE


class Status(IntEnum):
    """What the estimator is about; from `NOT_FINITE` on its input is not to be believed, and it holds what it knows."""

    LEARNING = 0
    FREE = 1  # not in contact: nothing to learn
    NOT_FINITE = 2  # NaN or infinity
    FROZEN = 3  # position, velocity or force stands still, noise included, while the others say that it moves
    SATURATED = 4  # the force stands at the largest value that it ever had, or is beyond the sensor's limit
    DROPPED = 5  # the last sample once more, although the probe moves
    JUMPED = 6  # the clock or the position did
    FLICKERING = 7  # the contact flag comes and goes
    NO_FIT = 8  # fits fail, or one does not end: what was known last stays; or laws are too fast to be followed
    NO_MODEL = 9  # a model message that is none, or tells a law that is not known or not to be felt: the last one holds


#: What a tick puts out, one after the other; the first five as the thesis's estimator has them.
PORT_SIZES = {
    "theta": len(THETA),
    "regrouped": 7,
    "stable": 1,
    "estimated_force": 3,
    "filtered_force": 3,
    "deviation": len(THETA),
    "status": 1,
    "held_body": HELD_SIZE,
    "model_status": 1,
    "residual_ratio": 1,
    "force_lateness": len(FORCE_LATENESS),
    "model": MESSAGE_SIZE,
    "thing": 1,
}
THETA_PART, REGROUPED, STABLE, ESTIMATED, FILTERED, DEVIATION, STATUS, HELD, MODEL_STATUS, *_rest = map(
    Layout().part, PORT_SIZES.values()
)
RESIDUAL, LATE, MODEL, THING = _rest
READOUT_SIZE = THING.stop
OF_SENSOR = slice(MODEL.start + message_layout.OF_SENSOR.start, MODEL.start + message_layout.OF_SENSOR.stop)
MEMORY = slice(READOUT_SIZE, None)

# The memory.
_next = Layout()
STARTED, TIME, BROKEN, FAULT, FAULT_FOR, JUMPS, SINCE_GOOD = map(_next, [1] * 7)
FLAG, ACCEPTED, NEW_FOR, CHANGES, FLICKERS = map(_next, [1] * 5)
HISTORY = _next.part(HISTORY_SIZE)
GOOD = _next(6)  # the motion that was believed last
LARGEST = _next(3)  # of the force along each axis
SUM, TICKS, OK, STAMPED = map(_next, (9, 1, 4, 1))  # the sample of the fit in the making
P = _next(VECTOR_SIZE)
LAWS = _next(TOLD_SIZE)  # beside what is told
STATE = _next(box.STATE_SIZE)
SEEN = _next(9)  # position, velocity and what the force sensor itself reads
COUNT = _next()  # samples that wait to be taken
ROWS = _next.size


class LearningSettings(NamedTuple):
    """`OutputErrorOptions` in the form that the compiled tick takes."""

    step: float
    ticks: int
    force_limit: float
    rows: int
    planar: float
