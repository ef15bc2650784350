"""Between a source of motion that can jump and what follows it."""

import math

import numpy as np

from mmt_drake.errors import check_number
from mmt_drake.numeric.arrays import Array
from mmt_drake.systems.interactive_operator import follow
from mmt_drake.systems.kernel_system import KernelSystem

GREATEST_SPEED = 0.05
"""Along each axis [m/s]: at which an arm also comes to its first set-point."""

_BANDWIDTH = 2.0  # [Hz]


class MotionRateLimiter(KernelSystem):
    """Follows commanded positions smoothly, and never faster than `GREATEST_SPEED`, however they jump.

    .. pydrake_system::

        name: MotionRateLimiter
        input_ports:
        - commanded
        output_ports:
        - motion

    - `commanded` (6): position [m] and velocity [m/s], table frame. The velocity is not believed; a position that is
      not finite makes the motion so from then on, and what follows has to refuse that.
    - `motion` (6): position [m] and velocity [m/s], table frame: a critically damped second-order filter behind the
      commanded position.

    Args:
        start: (3) where it begins [m].
        period: step of the filter [s].

    Raises:
        BadInput: a period that is not positive.
    """

    def __init__(self, start: Array, *, period: float = 0.001) -> None:
        super().__init__()
        check_number("motion rate limiter", "period", period, least=0.0, open_interval=True)
        self._period = period
        self.declare_inputs("commanded")
        self.declare_memory(np.concatenate([start, np.zeros(3)]), period)
        self.declare_state_parts({"motion": 6})
        self.compile_kernels()

    def _step(self, t: float, motion: Array, commanded: Array) -> None:
        follow(commanded[:3], 2.0 * math.pi * _BANDWIDTH, GREATEST_SPEED, self._period, motion)
