"""Direct force feedback under time-domain passivity control: the telerobot's end."""

import math

import numpy as np

from mmt_drake.errors import check_number
from mmt_drake.numeric.arrays import Array
from mmt_drake.rendering.passivity import ENERGY_PORT, MOTION_MEMORY_SIZE, PassivityControl, control_motion, drifted
from mmt_drake.systems.kernel_system import KernelSystem


class PassivityControlledMotion(KernelSystem):
    """Lets the telerobot yield to the force where the network would give out more energy than was put in.

    One of the two ends of `mmt_drake.rendering.passivity`; the other one is `PassivityControlledForce`.

    .. pydrake_system::

        name: PassivityControlledMotion
        input_ports:
        - commanded
        - force
        - remote_energy
        output_ports:
        - motion
        - energy_in

    Ports (table frame):

    - `commanded` (6): position [m] and velocity [m/s] of the hand as the network delivers them.
    - `force` (3): on the probe, as measured [N].
    - `remote_energy` (3): energy that has flowed into the network at the operator's end [J], along x, y, z, likewise.
    - `motion` (6): of the probe [m], [m/s]: the commanded one and the drift; direct feedthrough from `commanded` alone.
    - `energy_in` (3): energy that has flowed into the network at this end [J], to be sent; a state.

    Args:
        period: of the updates [s].
        control: how strongly it may act.

    Raises:
        BadInput: a period that is not positive.
    """

    def __init__(self, *, period: float = 1e-3, control: PassivityControl | None = None) -> None:
        super().__init__()
        check_number("passivity control", "period", period, least=0.0, open_interval=True)
        self._period, self._control = period, control or PassivityControl()
        self._share = -math.expm1(-period / self._control.yielding_lag)
        self._return_rate = 0.0 if self._control.return_time is None else 1.0 / self._control.return_time
        self.declare_inputs("commanded", "force", "remote_energy")
        self.declare_memory(np.zeros(MOTION_MEMORY_SIZE), period)
        self.declare_computed("motion", 6, self._moved, ("commanded",))
        self.declare_state_parts(ENERGY_PORT)
        self.compile_kernels()

    def _moved(self, t: float, memory: Array, out: Array, commanded: Array) -> None:
        drifted(memory, commanded, out)

    def _step(self, t: float, memory: Array, commanded: Array, force: Array, energy: Array) -> None:
        most = self._control.most_yielding
        control_motion(memory, commanded, force, energy, self._period, most, self._share, self._return_rate)
