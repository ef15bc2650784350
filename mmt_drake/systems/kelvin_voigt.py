"""A spring and a damper to the world: a contact along its normal, a damper, a tissue."""

import numpy as np
from numba import njit

from mmt_drake.errors import check_number
from mmt_drake.model import body
from mmt_drake.model import kelvin_voigt as spring
from mmt_drake.model.kelvin_voigt import KelvinVoigt
from mmt_drake.numeric.arrays import Array, assign
from mmt_drake.numeric.layout import Layout
from mmt_drake.systems.kernel_system import KernelSystem

_, _STARTED, _MEMORY_SIZE = map(Layout(), (spring.STATE_SIZE, 1, 0))
_AXIS = 1  # y

# The readout: each output port in turn, then the memory.
PORT_SIZES = {"measurement": 9, "force": 3}
_, _FORCE, _MEMORY = map(Layout(), (*PORT_SIZES.values(), _MEMORY_SIZE))


@njit(cache=True)
def _read(memory: Array, t: float, motion: Array, load: float, p: Array, out: Array) -> None:
    """Bring the memory to time t with the probe at `motion`; write readout and new memory to `out`."""
    now = out[_MEMORY:]
    assign(now, memory)
    if memory[_STARTED] == 0.0:
        spring.begin(now, t, motion[_AXIS], motion[3 + _AXIS], load, p)
        now[_STARTED] = 1.0
    else:
        spring.advance(now, t, motion[_AXIS], motion[3 + _AXIS], load, p)
    assign(out[:6], motion)
    out[6:_MEMORY] = 0.0
    out[6 + _AXIS] = now[spring.BODY + body.READING]
    out[_FORCE + _AXIS] = spring.force_on_probe(now, p)


class KelvinVoigtContact(KernelSystem):
    """F = F0 - k (x - x0) - b v along y, and what effects add; see `mmt_drake.model.kelvin_voigt`.

    Between updates the motion is taken as cubic, the load as linear. All outputs belong to the input at the same
    instant.

    .. pydrake_system::

        name: KelvinVoigtContact
        input_ports:
        - motion
        - load
        output_ports:
        - measurement
        - force
        - readout

    Ports (table frame):

    - `motion` (6): probe position [m] and velocity [m/s].
    - `load` (1): normal load [N], for effects that depend on it; 0 unless connected.
    - `measurement` (9): position [m], velocity [m/s] and force [N] as the sensor reads it.
    - `force` (3): force on the probe [N] as it is; 0 along the other axes.
    - `readout` (29): the two above in that order, then the system's memory.

    Args:
        model: its parameters and effects. A delay (`Additions.delay`) is for the one who drives the system to put
            before its input.
        period: of the updates [s]; 0 updates at every step of the Simulator (for unevenly sampled motions).

    Raises:
        BadInput: a period that is negative.
    """

    def __init__(self, model: KelvinVoigt, *, period: float = 1e-3) -> None:
        super().__init__()
        check_number("Kelvin-Voigt contact", "period", period, least=0.0)
        self._p = model.kernel_vector()
        self.declare_inputs("motion", "load", optional=("load",))
        self.declare_readout(PORT_SIZES, np.zeros(_MEMORY_SIZE), period)
        self.compile_kernels()

    def _compute(self, t: float, memory: Array, out: Array, motion: Array, load: Array | None) -> None:
        _read(memory, t, motion, 0.0 if load is None else load[0], self._p, out)
