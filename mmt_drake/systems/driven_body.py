"""A servo, a carriage, a falling ball, the output of a gear: a body that an input moves."""

import math

import numpy as np
from numba import njit

from mmt_drake.errors import BadInput, check_number
from mmt_drake.model import body
from mmt_drake.model import driven_body as driven
from mmt_drake.model.structure import PositionOut
from mmt_drake.numeric.arrays import Array, assign
from mmt_drake.numeric.layout import Layout
from mmt_drake.systems.kernel_system import KernelSystem

_, _STARTED, _MEMORY_SIZE = map(Layout(), (driven.STATE_SIZE, 1, 0))

# The readout: each output port in turn, then the memory.
PORT_SIZES = {"output": 1, "output_rate": 1}
_OUTPUT, _RATE, _MEMORY = map(Layout(), (*PORT_SIZES.values(), _MEMORY_SIZE))


@njit(cache=True)
def _read(memory: Array, t: float, u: float, load: float, start: Array, p: Array, out: Array) -> None:
    """Bring the memory to time t under the input u and a normal load; write readout and new memory to `out`."""
    now = out[_MEMORY:]
    assign(now, memory)
    if memory[_STARTED] == 0.0:
        driven.set_out(now, t, t, u, load, start[0], start[1])
        now[_STARTED] = 1.0
    else:
        driven.advance(now, t, u, load, p)
    out[_OUTPUT] = now[driven.BODY + body.POSITION]
    out[_RATE] = now[driven.BODY + body.VELOCITY]


class DrivenBody(KernelSystem):
    """m x'' = gain u + offset - b x' - k x - Fc sgn x' - G(x), see `DrivenBodyModel`; or a `TransmissionModel`.

    Between updates input and load are taken as linear. All outputs belong to the Context's time.

    .. pydrake_system::

        name: DrivenBody
        input_ports:
        - input
        - load
        output_ports:
        - output
        - output_rate
        - readout

    - `input` (1): u [N per unit of the gain; of a transmission in its own unit], or the goal of the model's controller.
    - `load` (1): normal load of the bearing, or what may push a transmission's output [N]; unless connected what the
      structure says (`PositionOut.carried`).
    - `output` (1): position x [m] or angle [rad].
    - `output_rate` (1): its derivative [m/s] or [rad/s].
    - `readout` (20): the two above, then the system's memory.

    Args:
        model: its parameters and effects. A delay and a lag (`Additions.delay`, `lag`) are for the one who
            drives the system to put before its input.
        start: position at first [m] or [rad].
        start_rate: its derivative there [m/s] or [rad/s].
        period: of the updates [s]; 0 updates at every step of the Simulator (for unevenly sampled inputs).

    Raises:
        BadInput: a period that is negative, a start that is not finite.
    """

    def __init__(
        self, model: PositionOut, *, start: float = 0.0, start_rate: float = 0.0, period: float = 1e-3
    ) -> None:
        super().__init__()
        check_number("driven body", "period", period, least=0.0)
        for name, value in (("start", start), ("start_rate", start_rate)):
            if not math.isfinite(value):
                raise BadInput("driven body", at=name, found=value, expected="a finite number")
        self._carried = model.carried
        self._p, self._start = model.kernel_vector(), np.array([start, start_rate], dtype=np.float64)
        self.declare_inputs("input", "load", optional=("load",))
        # A position follows the input of the same instant by way of the step that ends there.
        self.declare_readout(PORT_SIZES, np.zeros(_MEMORY_SIZE), period)
        self.compile_kernels()

    def _compute(self, t: float, memory: Array, out: Array, u: Array, load: Array | None) -> None:
        load = self._carried(u) if load is None else load
        _read(memory, t, u[0], load[0], self._start, self._p, out)
