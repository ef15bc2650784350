"""A hand on a device, which yields to what it feels."""

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues

from mmt_drake.errors import check_number
from mmt_drake.motion.yielding import HandImpedance, step_deviation
from mmt_drake.systems.kernel_system import KernelSystem


class YieldingHand(KernelSystem):
    """Deviates from an intended motion under the rendered force, by the impedance of arm and device.

    Behind an operator that repeats a motion it closes the loop between force and motion, without which nothing can
    become unstable. See `mmt_drake.motion.yielding`.

    .. pydrake_system::

        name: YieldingHand
        input_ports:
        - intended
        - force
        output_ports:
        - motion

    Ports (table frame):

    - `intended` (6): position [m] and velocity [m/s] that the hand would have if it felt nothing.
    - `force` (3): rendered force [N], held between ticks as a device holds it.
    - `motion` (6): position [m] and velocity [m/s] of the hand; direct feedthrough from `intended` alone.

    Args:
        hand: its impedance.
        period: of the updates [s].

    Raises:
        BadInput: a period that is not positive.
    """

    def __init__(self, hand: HandImpedance | None = None, *, period: float = 1e-3) -> None:
        super().__init__()
        check_number("hand", "period", period, least=0.0, open_interval=True)
        hand = hand or HandImpedance()
        self._limit = hand.force_limit
        self._own, self._forced = hand.matrices(period)
        self._intended = self.DeclareVectorInputPort("intended", 6)
        self._force = self.DeclareVectorInputPort("force", 3)
        self.declare_memory(np.zeros(6), period)
        sources = {self.xd_ticket(), self._intended.ticket()}
        self.DeclareVectorOutputPort("motion", 6, self._calc_motion, sources)
        self.compile_kernels()

    def _calc_motion(self, context: Context, output: BasicVector) -> None:
        deviation = context.get_discrete_state_vector().value()
        output.SetFromVector(self._intended.Eval(context) + deviation)

    def _update(self, context: Context, state: DiscreteValues) -> None:
        step_deviation(state.get_mutable_value(), self._force.Eval(context), self._limit, self._own, self._forced)
