"""The device itself: opened, set up, read, commanded a force, and brought to rest whatever happens."""

import contextlib
import ctypes
import math
import time
import weakref
from collections.abc import Callable

import numpy as np

from mmt_drake.closing import Closing
from mmt_drake.hw.errors import DeviceError
from mmt_drake.hw.omega.faults import HandFault, describe_fault
from mmt_drake.hw.omega.sdk import Sdk, load_sdk
from mmt_drake.hw.omega.settings import OmegaSettings
from mmt_drake.numeric.arrays import Array

_STATUS_EVERY = 10  # readings from one look at the button, and at whether the device's forces are on, to the next
_NONE = int(HandFault.NONE)


class OmegaDevice(Closing):
    """One haptic device in its own frame.

    Nothing here allocates or raises once the device runs: a call that fails gives a fault code. Forces are off until
    `start`, after which the device's own watchdog expects a `set_force` in time.

    Args:
        settings: which device, and how it is set up.
        clock: by which readings are timed [s].

    Raises:
        MissingDependency: there is no such library.
        DeviceError: there is no such device, or it refuses a setting.
    """

    def __init__(self, settings: OmegaSettings, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._sdk = sdk = load_sdk(settings.library)
        self._button = settings.clutch_button
        #: Whether the clutch button is pressed.
        self.clutched = False
        #: The trigger's opening, as it was read last [m]; not read where there is no trigger.
        self.gap = 0.0
        self._trigger, self._gap = settings.trigger, ctypes.c_double(0.0)
        #: (6) what `read` read last: position [m] and velocity [m/s], device frame.
        self.reading = np.zeros(6)
        #: When the position was read, and how long that took [s].
        self.read_at = self.read_for = 0.0
        # The bindings write straight into it.
        self._position, self._velocity = sdk.arrays.Vec3(self.reading[:3]), sdk.arrays.Vec3(self.reading[3:])
        self._status = sdk.containers.Status()
        self._until_status, self._forces_fault = 0, _NONE
        self._running = self._wanted = False
        self._get_position, self._get_velocity = sdk.fast.getPosition, sdk.fast.getLinearVelocity
        self._set_force, self._get_button = sdk.dhd.setForce, sdk.dhd.getButton
        self._set_both, self._get_gap = sdk.dhd.setForceAndGripperForce, sdk.dhd.getGripperGap
        self._opens = 1.0
        self._id = int(sdk.drd.open() if settings.device is None else sdk.drd.openID(settings.device))
        if self._id < 0:
            raise DeviceError(f"omega: cannot open the device: {describe_fault(self._error())}{_OPEN_ADVICE}")
        # Also when the program ends or the last reference goes: a device is never left with a force on.
        self._finalizer = weakref.finalize(self, _to_rest, sdk, self._id)
        try:
            self._set_up(settings)
        except DeviceError:
            self.close()
            raise

    @property
    def name(self) -> str:
        """As the device calls itself."""
        return str(self._sdk.dhd.getSystemName(self._id))

    def _set_up(self, settings: OmegaSettings) -> None:
        dhd, drd, expert, index = self._sdk.dhd, self._sdk.drd, self._sdk.expert, self._id
        if settings.calibration != "none" and not drd.isInitialized(index):
            if settings.calibration == "required":
                raise DeviceError(
                    "omega: the device is not calibrated; put its pole into the calibration pit until the light stops "
                    "blinking, or set calibration to automatic and keep hands off"
                )
            self._check(drd.autoInit(index), "automatic calibration")
        self._check(dhd.setGravityCompensation(settings.gravity_compensation, index), "gravity compensation")
        self._check(dhd.configLinearVelocity(round(1e3 * settings.velocity_window), ID=index), "velocity window")
        if settings.clutch_button == 0 and dhd.hasGripper(index):
            self._check(dhd.emulateButton(True, index), "clutch button: the gripper as a button")
        if settings.trigger is not None:
            if not dhd.hasGripper(index):
                raise DeviceError("omega: trigger: the device has no gripper; set trigger to null")
            self._opens = -1.0 if dhd.isLeftHanded(index) else 1.0  # as in the vendor's own examples
        if settings.watchdog is not None:
            self._check(expert.enableExpertMode(), "expert mode")
            done = expert.setWatchdog(settings.watchdog_units, index)
            expert.disableExpertMode()
            self._check(done, "watchdog (set it to null for a device that has none)")

    def start(self) -> int:
        """Turn the motors on, without a force; gives a fault code."""
        self._running = True
        return self._enable()

    def request_forces(self) -> None:
        """Have forces turned on again at the next reading, after the device turned them off; from any thread."""
        self._wanted = True

    def read(self) -> int:
        """Bring `reading` up to date; gives a fault code, with which `reading` may hold anything."""
        index = self._id
        before = self._clock()
        bad = self._get_position(self._position, index) < 0
        self.read_for = self._clock() - before
        self.read_at = before + 0.5 * self.read_for
        if bad or self._get_velocity(self._velocity, index) < 0:
            return self._error()
        if self._trigger is not None:
            if self._get_gap(self._gap, index) < 0:
                return self._error()
            if not math.isfinite(self._gap.value):
                return int(HandFault.BAD_READING)
            self.gap = self._gap.value
        if self._running:
            if self._wanted:
                self._wanted = False
                self._until_status = 0
                if fault := self._enable():
                    return fault
            self._until_status -= 1
            if self._until_status < 0:
                self._until_status = _STATUS_EVERY - 1
                self._forces_fault = self._look_at_status()
                self.clutched = self._button is not None and self._get_button(self._button, index) > 0
        return self._forces_fault

    def set_force(self, force: Array, opening: float = 0.0) -> int:
        """Have the device make a force (3) [N] in its own frame, and open its trigger [N]; gives a fault code."""
        if self._trigger is not None:
            return self._error() if self._set_both(force, self._opens * opening, self._id) < 0 else _NONE
        return self._error() if self._set_force(force, self._id) < 0 else _NONE

    def pose(self) -> tuple[Array, Array]:
        """Position (3) [m] and orientation (3, 3) of the handle in the device's frame.

        Raises:
            DeviceError: it cannot be read.
        """
        position, matrix = np.zeros(3), np.zeros((3, 3))
        done = self._sdk.dhd.getPositionAndOrientationFrame(position, matrix, self._id)
        self._check(done, "pose")
        return position, matrix

    def force(self) -> Array:
        """(3) the force that the device makes [N], in its own frame.

        Raises:
            DeviceError: it cannot be read.
        """
        force = np.zeros(3)
        self._check(self._sdk.dhd.getForce(force, self._id), "force")
        return force

    def close(self) -> None:
        """No force, brakes on, connection closed; may be called again."""
        self._finalizer()

    def _enable(self) -> int:
        """Motors on at no force."""
        failed = self._sdk.dhd.enableForce(True, self._id) < 0 or self._set_force((0.0, 0.0, 0.0), self._id) < 0
        return self._error() if failed else _NONE

    def _look_at_status(self) -> int:
        if self._sdk.dhd.getStatus(self._status, self._id) < 0:
            return self._error()
        return _NONE if self._status.force else int(HandFault.FORCES_OFF) + int(self._status.forceoffcause)

    def _error(self) -> int:
        """The vendor's number of the latest error, never 0."""
        try:
            return int(self._sdk.dhd.errorGetLast()) or 1
        except ValueError:  # a number that the bindings do not know
            return 1

    def _check(self, result: int, what: str) -> None:
        if result < 0:
            raise DeviceError(f"omega: {what}: {describe_fault(self._error())}")


_OPEN_ADVICE = "; is it plugged in and switched on, may you access it (udev rules), is another program using it?"


def _to_rest(sdk: Sdk, index: int) -> None:
    """No force, brakes, closed; each step even where the one before failed."""
    with contextlib.suppress(Exception):
        sdk.dhd.setForce((0.0, 0.0, 0.0), index)
    for step in (sdk.dhd.stop, sdk.drd.close):
        with contextlib.suppress(Exception):
            step(index)
