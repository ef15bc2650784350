"""The device in the table's frame: read at the start of a tick, told a force at its end."""

import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from mmt_drake.hw.omega import frames
from mmt_drake.hw.omega.device import OmegaDevice
from mmt_drake.hw.omega.settings import OmegaSettings

Array = NDArray[np.float64]

_FIRST_READINGS, _BETWEEN = 5, 2e-3  # [s]


class OmegaDriver:
    """What one tick of an `OmegaDevice` is, whatever system makes the ticks.

    It is its own last line: whatever force it is handed, the device gets zero while a reading fails, while the clutch
    is held and for a force that is not a number, and never more than `OmegaSettings.force`.

    Attributes:
        device: the device itself, in its own frame.
        motion: (6) position [m] and velocity [m/s], table frame; where it was last while a reading fails.
        state: (3) fault code, time of the latest reading [s], 1 while the clutch holds the position.

    Args:
        settings: which device, and how it lies on the table.
        clock: of the readings [s], never set.

    Raises:
        MissingDependency, DeviceError: as `OmegaDevice`.
    """

    def __init__(self, settings: OmegaSettings | None = None, clock: Callable[[], float] = time.monotonic) -> None:
        settings = OmegaSettings() if settings is None else settings
        self.motion = np.concatenate([settings.origin, np.zeros(3)])
        self.state = np.zeros(frames.DEVICE_SIZE)
        self._clutch, self._sent = np.zeros(frames.CLUTCH_SIZE), np.zeros(3)
        self._frame, self._clock = frames.frame_vector(settings), clock
        self._started, self._send_fault = False, 0
        # Compiles before the clock starts.
        parts = self.motion.copy(), self.state.copy(), self._clutch.copy()
        frames.take_reading(*parts, np.zeros(6), 0, False, 0.0, self._frame)
        frames.force_on_hand(self.state, self._clutch, np.zeros(3), self._frame, self._sent)
        self.device = OmegaDevice(settings)
        for _ in range(_FIRST_READINGS):  # where the hand is now; the vendor's velocity wants two positions
            self._take(self.device.read())
            if self.state[0] == 0.0:
                break
            time.sleep(_BETWEEN)

    def read(self) -> None:
        """Bring `motion` and `state` up to date; the first time, turn the motors on."""
        fault = 0
        if not self._started:  # the device's watchdog starts to count here, not while a diagram is built
            self._started = True
            fault = self.device.start()
        self._take(self.device.read() or fault or self._send_fault)

    def _take(self, fault: int) -> None:
        device = self.device
        frames.take_reading(
            self.motion, self.state, self._clutch, device.reading, fault, device.clutched, self._clock(), self._frame
        )

    def send(self, force: Array) -> None:
        """Have the device make a force (3) [N], table frame; what goes wrong is told at the next reading."""
        bad = frames.force_on_hand(self.state, self._clutch, force, self._frame, self._sent)
        self._send_fault = self.device.set_force(self._sent) or bad

    def request_forces(self) -> None:
        """Have the device's motors turned on again after it turned them off; a person's decision, from any thread."""
        self.device.request_forces()

    def close(self) -> None:
        """Bring the device to rest; readings after that are faults."""
        self.device.close()
