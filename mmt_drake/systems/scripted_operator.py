"""The operator's hand following a motion in closed form."""

import numpy as np
from pydrake.systems.framework import BasicVector, Context

from mmt_drake.motion.analytic import AnalyticMotion, motion_at
from mmt_drake.systems.leaf import LeafSystem


class ScriptedOperator(LeafSystem):
    """A hand that follows a scripted motion whatever it feels.

    .. pydrake_system::

        name: ScriptedOperator
        output_ports:
        - motion

    - `motion` (6): position [m] and velocity [m/s] of the hand, table frame, a function of the Context's time.

    Args:
        motion: what the hand does, for instance `scripted_motion("strokes")`.
    """

    def __init__(self, motion: AnalyticMotion):
        super().__init__()
        self._table = motion.table
        self.DeclareVectorOutputPort("motion", 6, self._motion, {self.time_ticket()})
        motion_at(0.0, motion.table, np.empty(6))  # compiles before the clock starts

    def _motion(self, context: Context, output: BasicVector) -> None:
        motion_at(context.get_time(), self._table, output.get_mutable_value())
