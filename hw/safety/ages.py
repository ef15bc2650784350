"""Ages of the signals of one side of a teleoperator, told to the other where both are in one program."""

import math
import time
from collections.abc import Callable

from pydrake.systems.framework import BasicVector, Context

from mmt_drake.hw.safety.reasons import Reason
from mmt_drake.systems.leaf import LeafSystem

# What a supervisor says of the hand itself; the rest is about the force, or about what comes from elsewhere.
_OF_THE_HAND = frozenset(
    float(reason)
    for reason in (
        *(Reason.EMERGENCY_STOP, Reason.DEVICE_FAULT, Reason.MOTION_NOT_FINITE, Reason.CLOCK, Reason.SILENT_DEVICE),
        *(Reason.SPEED, Reason.JUMP, Reason.WORKSPACE, Reason.STUCK),
    )
)


class DeviceAge(LeafSystem):
    """How old a device's latest reading is; infinitely old while its driver reports a fault.

    For a supervisor on the other side to watch: it lets go when this device stops.

    .. pydrake_system::

        name: DeviceAge
        input_ports:
        - device
        output_ports:
        - age

    - `device` (3): as a driver tells of itself: fault code, time of the latest reading [s], and a flag.
    - `age` (1): [s]; follows the clock, not the diagram's time.

    Args:
        clock: that readings are told by [s].
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        super().__init__()
        self.set_name("DeviceAge")
        self._clock = clock
        self._device = self.DeclareVectorInputPort("device", 3)
        self.DeclareVectorOutputPort("age", 1, self._calc, {self.time_ticket(), self._device.ticket()})

    def _calc(self, context: Context, output: BasicVector) -> None:
        fault, read_at, _ = self._device.Eval(context)
        output.SetAtIndex(0, self._clock() - read_at if fault == 0.0 else math.inf)


class HandAge(LeafSystem):
    """How old the motion of a supervised hand is: of this tick, or infinitely old while it is not to be believed.

    For an arm that follows it: it stops when the supervisor finds something wrong with the hand or its device, whether
    the force is armed or not.

    .. pydrake_system::

        name: HandAge
        input_ports:
        - status
        output_ports:
        - age

    - `status` (6): as on the port of `SafetySupervisor`.
    - `age` (1): [s], 0 or infinite.
    """

    def __init__(self) -> None:
        super().__init__()
        self.set_name("HandAge")
        self._status = self.DeclareVectorInputPort("status", 6)
        self.DeclareVectorOutputPort("age", 1, self._calc, {self._status.ticket()})

    def _calc(self, context: Context, output: BasicVector) -> None:
        output.SetAtIndex(0, math.inf if self._status.Eval(context)[2] in _OF_THE_HAND else 0.0)
