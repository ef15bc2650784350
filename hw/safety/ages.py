"""Ages of the signals of one side of a teleoperator, sent to the other where both are in one program."""

import math
import time
from collections.abc import Callable

from mmt_drake.hw.safety.reasons import Reason
from mmt_drake.systems.leaf import LeafSystem

LOST = 1e9
"""An age that nobody waits for [s]; finite, for a link refuses what is not."""

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
        clock: of readings [s].
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        super().__init__()
        self.declare_inputs("device")
        self.declare_function("age", 1, lambda t, device: clock() - device[1] if device[0] == 0.0 else math.inf)


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
        self.declare_inputs("status")
        self.declare_function("age", 1, lambda t, status: math.inf if status[2] in _OF_THE_HAND else 0.0)


class CameraAge(LeafSystem):
    """How old a camera's latest frame is; `LOST` while the camera reports a fault.

    Without a surface there is no contact, and so no force. With the surface the force would come back by itself, to a
    hand that is by then deep in the object: for a supervisor to watch, which lets nothing through until a person arms.

    .. pydrake_system::

        name: CameraAge
        input_ports:
        - camera
        output_ports:
        - age

    - `camera` (3): as on the port of `DepthCameraSystem`.
    - `age` (1): [s]; direct feedthrough.
    """

    def __init__(self) -> None:
        super().__init__()
        self.declare_inputs("camera")
        self.declare_function("age", 1, lambda t, camera: camera[1] if camera[0] == 0.0 else LOST)
