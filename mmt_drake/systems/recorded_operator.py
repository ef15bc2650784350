"""The operator's hand following a recording."""

import numpy as np
from pydrake.systems.framework import BasicVector, Context

from mmt_drake.motion.sampled import SampledMotion, sampled_motion_at
from mmt_drake.numeric.arrays import Array
from mmt_drake.systems.leaf import LeafSystem


class RecordedOperator(LeafSystem):
    """A hand that repeats a recorded motion whatever it feels.

    .. pydrake_system::

        name: RecordedOperator
        output_ports:
        - motion

    - `motion` (6): position [m] and velocity [m/s] of the hand, table frame: the cubic through neighbouring samples
      at the Context's time. Before the first sample and after the last one the hand rests where that sample is,
      with zero velocity.

    Args:
        time: (n) [s], increasing.
        position: (n, 3) [m], table frame.
        velocity: (n, 3) [m/s].

    Raises:
        BadInput: shapes that do not fit, values that are not finite, times that do not increase.
    """

    def __init__(self, time: Array, position: Array, velocity: Array):
        super().__init__()
        motion = SampledMotion(time, position, velocity)
        sampled_motion_at(0.0, motion.table, np.empty(6))  # compiles before the clock starts
        self._table = motion.table
        self.DeclareVectorOutputPort("motion", 6, self._motion, {self.time_ticket()})

    def _motion(self, context: Context, output: BasicVector) -> None:
        sampled_motion_at(context.get_time(), self._table, output.get_mutable_value())
