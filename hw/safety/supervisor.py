"""The supervisor between whatever computes a force and the device that makes it."""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from mmt_drake.errors import BadInput, check_number
from mmt_drake.hw.safety import kernel
from mmt_drake.hw.safety.limits import STOP_WITHIN, SafetyLimits
from mmt_drake.numeric.arrays import Array
from mmt_drake.systems.kernel_system import KernelSystem

_NO_AGES = np.zeros(0)


def check_settings(limits: SafetyLimits, period: float, watched: Mapping[str, float]) -> None:
    """Refuse what a supervisor could not keep.

    Raises:
        BadInput: a period or an age that is not positive, a ramp that one period makes longer than `STOP_WITHIN`, a gap
            that every period is.
    """
    check_number("safety", "period", period, least=0.0, open_interval=True)
    for name, age in watched.items():
        check_number("safety", f"watched.{name}", age, least=0.0, open_interval=True)
    if limits.ramp + period > STOP_WITHIN * (1.0 + 1e-9):
        expected = f"at most {STOP_WITHIN:g} s less one period of {period:g} s"
        raise BadInput("safety limits", at="ramp", found=limits.ramp, expected=expected)
    if limits.gap <= period:
        raise BadInput("safety limits", at="gap", found=limits.gap, expected=f"more than one period of {period:g} s")


class SafetySupervisor(KernelSystem):
    """Passes a force on while everything is well; else ramps it to zero, says why, and waits for a person.

    Force and power are limited: the command is scaled down, its direction kept, and goes on. Everything else is a
    fault (`Reason`): from the tick that sees it the force given out last falls linearly to exactly zero, in
    `SafetyLimits.ramp` by the diagram's clock or the device's, whichever is faster, so within `STOP_WITHIN` even when
    ticks come late. It stays zero until the fault is gone and the arm switch, seen open meanwhile, is pressed; then the
    force comes back over `SafetyLimits.rise`. The first arming is no different: it starts disarmed.

    Every fault is seen at the first tick that it reaches, but for a stuck position (after `SafetyLimits.stuck`), a
    silent device (after `SafetyLimits.gap`) and a watched age (when it passes its limit). A tick that never comes is
    beyond this system: there the device's own watchdog stands in, which its driver sets.

    .. pydrake_system::

        name: SafetySupervisor
        input_ports:
        - command
        - motion
        - device
        - ages
        - switches
        output_ports:
        - force
        - status
        - readout

    Ports (table frame):

    - `command` (3): force asked for [N].
    - `motion` (6): position [m] and velocity [m/s] of the device.
    - `device` (3): the driver's fault code (0: well), the time of the latest reading by a clock that is never set [s],
      and 1 while a clutch holds the position. Only there if `device` is asked for.
    - `ages` (one for each of `watched`): age [s] of the latest good packet of a peer, result of a worker ... Only there
      if something is watched.
    - `switches` (2): arm, 1 while a person presses it; emergency stop, anything but 0 stops.
    - `force` (3): what the device may make [N]; direct feedthrough, never a tick late.
    - `status` (6): armed (0 or 1), the `Reason` of the last stop, the `Reason` that is present now, what is limited
      (1 force, 2 power, 3 both), gain on the command (0 to 1), how many faults so far.
    - `readout` (19): force, status and the rest of the system's memory.

    Args:
        limits: of the device.
        period: of the updates [s].
        device: whether there is a driver that tells about itself; a simulated hand does not.
        watched: name -> greatest age [s] of the inputs that must stay fresh.

    Raises:
        BadInput: as `check_settings`.
    """

    def __init__(
        self,
        limits: SafetyLimits | None = None,
        *,
        period: float = 1e-3,
        device: bool = True,
        watched: Mapping[str, float] = MappingProxyType({}),
    ) -> None:
        super().__init__()
        limits = SafetyLimits() if limits is None else limits
        check_settings(limits, period, watched)
        self._limits, self._oldest = limits.kernel_vector(), np.array(list(watched.values()), dtype=np.float64)
        #: Names of the watched inputs, for `describe`.
        self.watched = tuple(watched)

        self.declare_inputs("command", "motion", device=3 if device else 0, ages=len(watched))
        self.declare_inputs("switches")
        self.declare_readout(kernel.PORT_SIZES, kernel.initial_memory(), period, memory_at=0)
        self.compile_kernels()

    def _compute(self, t: float, memory: Array, out: Array, *inputs: Array) -> None:
        command, motion, device, ages, switches = inputs
        device = np.array([0.0, t, 0.0]) if device is None else device
        ages = _NO_AGES if ages is None else ages
        kernel.supervise(memory, t, command, motion, device, ages, switches, self._limits, self._oldest, out)
