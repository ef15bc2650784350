"""The operator's hand on a haptic device, with the ports of a simulated hand."""

import time
from collections.abc import Callable

import numpy as np
from pydrake.systems.framework import Context, DiscreteValues, State

from mmt_drake.closing import Closing
from mmt_drake.hw.omega import frames
from mmt_drake.hw.omega.device import OmegaDevice
from mmt_drake.hw.omega.settings import OmegaSettings
from mmt_drake.hw.omega.velocity import keep_near, take_position, velocity_memory
from mmt_drake.numeric.arrays import Array
from mmt_drake.systems.leaf import LeafSystem

_FIRST_READINGS, _BETWEEN = 5, 2e-3  # [s]
_LONGEST_READING = 0.5e-3  # [s]: of a longer one nobody knows when it was, and the device's own velocity holds


class OmegaOperator(LeafSystem, Closing):
    """A person's hand on a Force Dimension device.

    At each tick the device is read *before* any other system is updated (an unrestricted update comes first in a step
    of Drake's), so the force sent at the end of that tick answers the motion read at its start: no tick lies between.

    It is its own last line: whatever force it is handed, the device gets zero while a reading fails, while the clutch
    is held and for a force that is not a number, and never more than `OmegaSettings.force`. If ticks stop coming, the
    device's own watchdog turns it off; and it is brought to rest when this system is closed, at the latest when
    Python collects it with its diagram, some time after the last reference went, or the program ends. It takes a
    force as it comes otherwise: put a `SafetySupervisor` before it (`mmt_drake.hw.safety.supervised`).

    .. pydrake_system::

        name: OmegaOperator
        input_ports:
        - force
        output_ports:
        - motion
        - reported_motion
        - device

    Ports, and with `OmegaSettings.trigger` an input `gain` (1: of the supervisor, 0 to 1, on the trigger's spring) and
    an output `grip` (1: force [N] that the trigger stands for; what it was last while a reading fails):

    - `force` (3): rendered force [N], table frame.
    - `motion` (6): position [m] and velocity [m/s] of the hand, table frame; where it was last while a reading fails.
      The velocity is that of the positions, which is not late (`mmt_drake.hw.omega.velocity`).
    - `reported_motion` (6): the same with the velocity that the device reports, late by half of
      `OmegaSettings.velocity_window`: for a supervisor, which holds the one against the other.
    - `device` (3): fault code (0: well; else `describe_fault`), time of the latest reading [s] by a clock that is never
      set, and 1 while the clutch holds the position (else 0).

    The device, and what is known of it, is outside the Context: a cloned Context shares it.

    Args:
        settings: which device, and how it lies on the table.
        period: of the ticks [s].
        clock: of the readings [s].
        supervisor_clock: by which the port `device` tells their times; `clock` if None.

    Raises:
        MissingDependency, DeviceError: as `OmegaDevice`.
    """

    def __init__(
        self,
        settings: OmegaSettings | None = None,
        *,
        period: float = 1e-3,
        clock: Callable[[], float] = time.monotonic,
        supervisor_clock: Callable[[], float] | None = None,
    ) -> None:
        super().__init__()
        settings = OmegaSettings() if settings is None else settings
        self._motion, self._state = np.concatenate([settings.origin, np.zeros(3)]), np.zeros(frames.DEVICE_SIZE)
        self._reported, self._positions = self._motion.copy(), velocity_memory()
        self._clutch, self._sent = np.zeros(frames.CLUTCH_SIZE), np.zeros(3)
        self._frame = frames.frame_vector(settings)
        self._told_clock = clock if supervisor_clock is None else supervisor_clock
        self._started, self._send_fault = False, 0
        self._trigger, self._grip, self._gain = settings.trigger, np.zeros(1), None
        # Compiles before the clock starts.
        parts = self._motion.copy(), self._state.copy(), self._clutch.copy()
        frames.take_reading(*parts, np.zeros(6), 0, False, 0.0, self._frame)
        frames.force_on_hand(self._state, self._clutch, np.zeros(3), self._frame, self._sent)
        take_position(velocity_memory(), 0.0, np.zeros(6))
        keep_near(np.zeros(6), np.zeros(6))
        #: The device itself, for its name, pose and what it says about forces.
        self.device = OmegaDevice(settings, clock)
        for _ in range(_FIRST_READINGS):  # where the hand is now; the vendor's velocity wants two positions
            self._read_device()
            if self._state[0] == 0.0:
                break
            time.sleep(_BETWEEN)
        (self._force,) = self.declare_inputs("force")
        self.DeclareStateOutputPort("motion", self.DeclareDiscreteState(self._motion))
        self.DeclareStateOutputPort("reported_motion", self.DeclareDiscreteState(self._reported))
        self.DeclareStateOutputPort("device", self.DeclareDiscreteState(self._state))
        if settings.trigger is not None:
            (self._gain,) = self.declare_inputs(gain=1)
            self.DeclareStateOutputPort("grip", self.DeclareDiscreteState(self._grip))
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._read)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def request_forces(self) -> None:
        """Have the device's motors turned on again after it turned them off; a person's decision, from any thread."""
        self.device.request_forces()

    def close(self) -> None:
        """Bring the device to rest; ticks after that report a fault."""
        self.device.close()

    def _read(self, context: Context, state: State) -> None:
        fault = 0
        if not self._started:  # the device's watchdog starts to count here, not while a diagram is built
            self._started = True
            fault = self.device.start()
        self._read_device(fault)
        values = state.get_mutable_discrete_state()
        values.get_mutable_value(0)[:] = self._motion
        values.get_mutable_value(1)[:] = self._reported
        values.get_mutable_value(2)[:] = self._state
        if self._trigger is not None:
            values.get_mutable_value(3)[:] = self._grip

    def _read_device(self, earlier_fault: int = 0) -> None:
        device = self.device
        fault = device.read() or earlier_fault or self._send_fault
        reading, clutched, told = device.reading, device.clutched, self._told_clock()
        frames.take_reading(self._reported, self._state, self._clutch, reading, fault, clutched, told, self._frame)
        self._motion[:] = self._reported
        if self._trigger is not None and self._state[0] == 0.0:
            self._grip[0] = self._trigger.grip_at(device.gap)
        if self._state[0] == 0.0 and not clutched and device.read_for <= _LONGEST_READING:
            take_position(self._positions, device.read_at, self._motion)
            keep_near(self._motion, self._reported)

    def _update(self, context: Context, state: DiscreteValues) -> None:
        try:
            force = self._force.Eval(context)
            gain = 0.0 if self._gain is None else float(self._gain.Eval(context)[0])
        except BaseException:  # whatever it is, and Ctrl-C too: no force stays on while it is dealt with
            self._send(np.zeros(3))
            raise
        self._send(force, gain)

    def _send(self, force: Array, gain: float = 0.0) -> None:
        """Have the device make a force (3) [N], table frame; what goes wrong is reported at the next reading.

        The trigger's spring goes with the gain, and is none while a reading fails.
        """
        bad = frames.force_on_hand(self._state, self._clutch, force, self._frame, self._sent)
        opening = 0.0
        if self._trigger is not None and self._state[0] == 0.0 and bad == 0:
            opening = self._trigger.spring_at(self.device.gap, gain)
        self._send_fault = self.device.set_force(self._sent, opening) or bad
