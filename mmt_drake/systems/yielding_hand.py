"""A hand on a device, which yields to what it feels."""

import numpy as np

from mmt_drake.errors import check_number
from mmt_drake.motion.yielding import HandImpedance, step_deviation
from mmt_drake.numeric.arrays import Array
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
        self.declare_inputs("intended", "force")
        self.declare_memory(np.zeros(6), period)
        self.declare_computed("motion", 6, self._moved, ("intended",))
        self.compile_kernels()

    def _moved(self, t: float, deviation: Array, out: Array, intended: Array) -> None:
        np.add(intended, deviation, out=out)

    def _step(self, t: float, deviation: Array, intended: Array, force: Array) -> None:
        step_deviation(deviation, force, self._limit, self._own, self._forced)
