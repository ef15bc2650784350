"""Direct force feedback under time-domain passivity control: the operator's end."""

import numpy as np

from mmt_drake.errors import check_number
from mmt_drake.numeric.arrays import Array
from mmt_drake.rendering.passivity import ENERGY_PORT, FORCE_MEMORY_SIZE, PassivityControl, control_force
from mmt_drake.systems.kernel_system import KernelSystem
from mmt_drake.systems.renderer_ports import declare_rendering


class PassivityControlledForce(KernelSystem):
    """Renders the telerobot's force, damped where the network would give out more energy than was put in.

    One of the two ends of `mmt_drake.rendering.passivity`; the other one is `PassivityControlledMotion`.

    .. pydrake_system::

        name: PassivityControlledForce
        input_ports:
        - motion
        - remote_force
        - remote_energy
        output_ports:
        - force
        - readout
        - energy_in
        - status

    Ports (table frame):

    - `motion` (6): the hand's position [m] and velocity [m/s].
    - `remote_force` (3): force on the telerobot's probe as the network delivers it [N].
    - `remote_energy` (3): energy that has flowed into the network at the telerobot's end [J], along x, y, z, likewise.
    - `force` (3): on the hand [N]; direct feedthrough from `motion`, `remote_force`, `remote_energy`.
    - `readout` (3 and the memory): the force, then the memory.
    - `energy_in` (3): energy that has flowed into the network at this end [J], to be sent; a state.
    - `status` (1): 1 where it renders, since it waits for no parameters; 6 where an input that it uses is not finite,
      and it lets go of its force (`mmt_drake.rendering.finite`).

    Args:
        period: of the updates [s].
        control: how strongly it may act.

    Raises:
        BadInput: a period that is not positive.
    """

    def __init__(self, *, period: float = 1e-3, control: PassivityControl | None = None) -> None:
        super().__init__()
        check_number("renderer", "period", period, least=0.0, open_interval=True)
        self._period, self._control = period, control or PassivityControl()
        inputs = self.declare_inputs("motion", "remote_force", "remote_energy")
        self.declare_readout({"force": 3}, np.zeros(FORCE_MEMORY_SIZE), period)
        self.declare_state_parts(ENERGY_PORT)
        declare_rendering(self, inputs)
        self.compile_kernels()

    def _compute(self, t: float, memory: Array, out: Array, motion: Array, force: Array, energy: Array) -> None:
        out[3:] = memory
        control_force(out[3:], motion, force, energy, self._period, self._control.most_damping, out[:3])
