"""Takes back what a device that has stopped would go on to say."""

import numpy as np
from pydrake.systems.framework import BasicVector, Context

from mmt_drake.systems.leaf import LeafSystem


class WhileWell(LeafSystem):
    """Hands a vector on while a device is well, and zeros while its driver reports a fault.

    What an arm last touched is no longer there once it has stopped: nobody is to feel it.

    .. pydrake_system::

        name: WhileWell
        input_ports:
        - signal
        - device
        output_ports:
        - signal

    - `signal` (the size given): as it comes and, as an output, as it goes on; direct feedthrough.
    - `device` (3): as a driver tells of itself: fault code, time of the latest reading [s], and a flag.

    Args:
        size: of the signal.
    """

    def __init__(self, size: int) -> None:
        super().__init__()
        self.set_name("WhileWell")
        self._signal = self.DeclareVectorInputPort("signal", size)
        self._device = self.DeclareVectorInputPort("device", 3)
        self.DeclareVectorOutputPort("signal", size, self._calc, {self._signal.ticket(), self._device.ticket()})

    def _calc(self, context: Context, output: BasicVector) -> None:
        signal = self._signal.Eval(context)
        output.SetFromVector(signal if self._device.Eval(context)[0] == 0.0 else np.zeros_like(signal))
