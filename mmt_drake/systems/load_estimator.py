"""The telerobot's estimator of what it carries."""

import numpy as np

from mmt_drake.errors import check_number
from mmt_drake.estimation.carried import MEMORY_SIZE, PORT_SIZES, bank, estimate_load
from mmt_drake.numeric.arrays import Array
from mmt_drake.systems.kernel_system import KernelSystem


class LoadEstimator(KernelSystem):
    """Mass, centre and swing of a carried object from force and motion of the tip (`mmt_drake.estimation.carried`).

    .. pydrake_system::

        name: LoadEstimator
        input_ports:
        - measurement
        - held
        - grip
        - in_contact
        - theta
        output_ports:
        - carried
        - deviation
        - status
        - in_contact
        - readout

    Ports (table frame):

    - `measurement` (9): position [m], velocity [m/s] and force [N] as the sensors read them.
    - `held` (4): as the grip's own sensors tell, what it has (0 nothing, 1 the object, 2 it has slipped out), how far
      it has slipped up the object and in all [m]; the fourth is not read.
    - `grip` (1): its force [N].
    - `in_contact` (1): 1 where a contact detector says that the tip touches.
    - `theta` (10): of the contact [SI]; the grasp is its spring and damper.
    - `carried` (5): what becomes of the object (0 there is none, 1 it stands on the table, 2 it is carried, 3 it slips,
      4 it has slipped out), its mass [kg], how far its centre is below the grip [m], damping ratio of its swing (0: not
      known yet, of the latest object), the grip as it is known here [N].
    - `deviation` (3): standard deviations of mass [kg], centre [m] and damping ratio.
    - `status` (1): 0 where all is told, 1 nothing yet, 3 UNEXCITED: the swing does not tell the centre.
    - `in_contact` (1): the detector's, 0 while the object is carried: what then touches pushes nothing.
    - `readout` (the four above, the memory).

    Args:
        period: of the ticks [s].

    Raises:
        BadInput: a period that is not positive.
    """

    def __init__(self, *, period: float = 1e-3) -> None:
        super().__init__()
        check_number("load estimator", "period", period, least=0.0, open_interval=True)
        self._period, self._rods = period, bank()
        self.declare_inputs("measurement", "held", "grip", "in_contact", "theta")
        self.declare_readout(PORT_SIZES, np.zeros(MEMORY_SIZE), period)
        self.compile_kernels()

    def _compute(self, t: float, memory: Array, out: Array, *inputs: Array) -> None:
        measurement, held, grip, contact, theta = inputs
        estimate_load(memory, measurement, held, grip[0], contact[0], theta, self._period, self._rods, out)
