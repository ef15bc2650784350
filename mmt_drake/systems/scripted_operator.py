"""The operator's hand following a motion."""

import numpy as np
from pydrake.systems.framework import BasicVector, Context

from mmt_drake.motion.analytic import Motion
from mmt_drake.systems.leaf import LeafSystem


class ScriptedOperator(LeafSystem):
    """A hand that follows a motion, in closed form or recorded, whatever it feels.

    .. pydrake_system::

        name: ScriptedOperator
        output_ports:
        - motion

    - `motion` (6): position [m] and velocity [m/s] of the hand, table frame, a function of the Context's time.

    Args:
        motion: what the hand does, for instance `scripted_motion("strokes")`, or a `SampledMotion`.
    """

    def __init__(self, motion: Motion):
        super().__init__()
        self._table, self._sample_into = motion.table, type(motion).sample_into
        self.DeclareVectorOutputPort("motion", 6, self._motion, {self.time_ticket()})
        motion.at(0.0)  # compiles before the clock starts

    def _motion(self, context: Context, output: BasicVector) -> None:
        self._sample_into(np.array([context.get_time()]), self._table, output.get_mutable_value()[np.newaxis])
