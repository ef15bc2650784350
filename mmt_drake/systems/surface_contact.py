"""A tip on a surface that stays, in three dimensions: palpation."""

import numpy as np
from numba import njit

from mmt_drake.errors import check_number
from mmt_drake.model import surface_contact as contact
from mmt_drake.model.surface_contact import SurfaceContact
from mmt_drake.numeric.arrays import Array, assign
from mmt_drake.numeric.layout import Layout
from mmt_drake.systems.kernel_system import KernelSystem

_, _STARTED, _MEMORY_SIZE = map(Layout(), (contact.STATE_SIZE, 1, 0))

# The readout: each output port in turn, then the memory.
PORT_SIZES = {"measurement": 9, "force": 3, "in_contact": 1}
_, _FORCE, _IN_CONTACT, _MEMORY = map(Layout(), (*PORT_SIZES.values(), _MEMORY_SIZE))


@njit(cache=True)
def _read(memory: Array, t: float, motion: Array, p: Array, out: Array) -> None:
    """Bring the memory to time t with the probe at `motion`; write readout and new memory to `out`."""
    now = out[_MEMORY:]
    assign(now, memory)
    if memory[_STARTED] == 0.0:
        contact.begin(now, t, motion, p)
        now[_STARTED] = 1.0
    else:
        contact.advance(now, t, motion, p)
    assign(out[:6], motion)
    for i in range(3):
        out[6 + i] = out[_FORCE + i] = now[contact.FORCE + i]
    out[_IN_CONTACT] = now[contact.TOUCHES]


class SurfaceContactSystem(KernelSystem):
    """A tip that presses into a surface, sticks and slips on it; see `mmt_drake.model.surface_contact`.

    All outputs belong to the input at the same instant.

    .. pydrake_system::

        name: SurfaceContactSystem
        input_ports:
        - motion
        output_ports:
        - measurement
        - force
        - in_contact
        - readout

    Ports (table frame):

    - `motion` (6): probe position [m] and velocity [m/s].
    - `measurement` (9): position [m], velocity [m/s] and force on the probe [N] as the sensor reads it.
    - `force` (3): the same force [N].
    - `in_contact` (1): 1 where the tip is below the surface, else 0.
    - `readout` (45): the three above in that order, then the system's memory.

    Args:
        model: its parameters and effects. A delay (`Additions.delay`) is for the one who drives the system to put
            before its input.
        period: of the updates [s]; 0 updates at every step of the Simulator (for unevenly sampled motions).

    Raises:
        BadInput: a period that is negative.
    """

    def __init__(self, model: SurfaceContact, *, period: float = 1e-3) -> None:
        super().__init__()
        check_number("surface contact", "period", period, least=0.0)
        self._p = model.kernel_vector()
        self.declare_inputs("motion")
        self.declare_readout(PORT_SIZES, np.zeros(_MEMORY_SIZE), period)
        self.compile_kernels()

    def _compute(self, t: float, memory: Array, out: Array, motion: Array) -> None:
        _read(memory, t, motion, self._p, out)
