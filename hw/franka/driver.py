"""The thread between a diagram's ticks and the arm: it reads, watches, streams set-points and stops."""

import atexit
import threading
import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from mmt_drake.hw.franka.arm import FrankaArm
from mmt_drake.hw.franka.faults import ArmFault
from mmt_drake.hw.franka.guard import SetpointGuard
from mmt_drake.hw.franka.settings import FrankaSettings
from mmt_drake.numeric.arrays import Array

_PERIOD = 1e-3  # [s]
_ASKED_WITHIN = 2.0  # [s] from a person's asking to moving; who asked longer ago does not expect it any more
_STOP_SEEN = 0.25  # [s] beyond the time of a stop; an arm in control for longer is commanded again
_START_WITHIN = 1.0  # [s] from telling the arm a motion to its being in control


class ArmReading(NamedTuple):
    """What the thread knows; replaced as a whole, so that a tick never sees half of it.

    Attributes:
        motion: (6) position [m] and velocity [m/s] of the tip, table frame.
        force: (3) on the tip [N], table frame, offset and all.
        device: (3) fault code, time of the latest reading [s], 1 while the arm does not follow the set-points.
    """

    motion: Array
    force: Array
    device: Array


class FrankaDriver:
    """What an arm is, whatever system makes the ticks: a place for the latest set-point and the latest reading.

    The thread starts here and ends with `close`. The arm moves only after a person asked for control
    (`request_control`), and from any fault on it needs that again. Then it comes slowly to the set-points and follows
    them. Without one for `FrankaSettings.hold_after` it holds its place, without one for `stop_after` it stops; it
    stops at once for every other `ArmFault`. A stop is a ramp of the torques to damping alone and takes
    `stop_within` at most; an arm that does not obey is commanded again. If this thread dies, the control loop holds the
    place; if the process dies, the robot's own reflex stops it.

    Attributes:
        latest: reading; where the arm was last while readings fail.

    Args:
        settings: which arm, and how it is set up.
        clock: of readings and set-points [s], never set.

    Raises:
        MissingDependency, DeviceError: as `FrankaArm`.
    """

    def __init__(self, settings: FrankaSettings, clock: Callable[[], float] = time.monotonic) -> None:
        self._settings, self._clock = settings, clock
        self._arm, self._guard = FrankaArm(settings), SetpointGuard(settings)
        self._setpoint = (np.zeros(6), -np.inf)
        self._asked_at, self._active, self._emergency = -np.inf, False, False
        self._started_at, self._stepped_at, self._under_control = 0.0, clock(), False
        self._stopped_at = -np.inf
        self._fault = ArmFault.NOT_IN_CONTROL
        self._read_at, self._robot_time = clock(), -1.0
        fault = self._read(clock())
        self.latest = self._publish(fault)
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name="franka", daemon=True)
        self._thread.start()
        atexit.register(self.close)  # a program that ends brings the arm to rest

    def send(self, commanded: Array, age: float = 0.0) -> None:
        """Hand over a set-point, position [m] and velocity [m/s] (6) in the table frame; never waits.

        Args:
            commanded: the set-point.
            age: of it, if it is not from now [s].
        """
        self._setpoint = (np.array(commanded, dtype=np.float64), self._clock() - max(age, 0.0))

    def request_control(self) -> None:
        """Have the arm recover and follow set-points, now or not at all; a person's decision, from any thread."""
        self._asked_at = self._clock()

    def emergency_stop(self, pressed: bool = True) -> None:
        """Stop, and refuse control until this is undone; from any thread."""
        self._emergency = pressed

    def close(self) -> None:
        """Bring the arm to rest and disconnect; may be called again."""
        self._closing.set()
        self._thread.join()
        atexit.unregister(self.close)

    def _run(self) -> None:
        due = self._clock()
        try:
            while not self._closing.is_set():
                self._step()
                due = max(due + _PERIOD, self._clock() - _PERIOD)
                time.sleep(max(0.0, due - self._clock()))
        finally:
            self._active, self._fault = False, ArmFault.CONNECTION
            self.latest = self._publish(ArmFault.CONNECTION)
            self._arm.close()

    def _step(self) -> None:
        now = self._clock()
        fault = self._read(now)
        asked_at, self._asked_at = self._asked_at, -np.inf
        if self._emergency:
            fault = ArmFault.EMERGENCY_STOP
        elif not self._active and now - asked_at <= _ASKED_WITHIN:
            fault = self._start(asked_at)
            now = self._clock()
        if self._active:
            fault = fault or self._watch(now)
            if fault:
                self._stop(now)
                self._active, self._fault = False, fault
            else:
                self._arm.follow(self._guard.position, self._guard.velocity)
        elif now - self._stopped_at > self._settings.stop_within + _STOP_SEEN and self._arm.in_control:
            self._stop(now)  # it was refused, or a motion that was said to have failed has begun
        self._stepped_at = now
        self.latest = self._publish(fault)

    def _stop(self, now: float) -> None:
        self._arm.stop()
        self._stopped_at = now

    def _read(self, now: float) -> ArmFault:
        """A reading, which is a fault of the connection once the robot's clock stands still."""
        fault = self._arm.read()
        if fault is not ArmFault.CONNECTION and self._arm.time != self._robot_time:
            self._robot_time, self._read_at = self._arm.time, now
        silent = now - self._read_at > self._settings.gap
        return fault or (ArmFault.CONNECTION if silent else ArmFault.NONE)

    def _start(self, asked_at: float) -> ArmFault:
        self._fault = self._arm.prepare()
        if not self._fault:
            late = self._emergency or self._clock() - asked_at > _ASKED_WITHIN
            self._fault = ArmFault.NOT_IN_CONTROL if late else self._arm.start()
        if not self._fault:
            now = self._clock()
            self._guard.start(self._arm.position)
            self._started_at, self._stepped_at, self._read_at = now, now, now
            self._active, self._under_control = True, False
        return self._fault

    def _watch(self, now: float) -> ArmFault:
        """Why the arm has to stop; else the guard has the next set-point."""
        arm, settings = self._arm, self._settings
        if np.linalg.norm(arm.force) > settings.force:
            return ArmFault.FORCE
        if np.linalg.norm(arm.velocity) > settings.tip_speed:
            return ArmFault.SPEED
        if arm.in_control:
            self._under_control = True
        elif self._under_control:
            return arm.read() or ArmFault.ENDED  # why, if it was reported since the reading above
        elif now - self._started_at > _START_WITHIN:
            return ArmFault.REFUSED
        commanded, stamp = self._setpoint
        waited = settings.hold_after + _PERIOD + now - self._started_at  # counts from the start on, if none came yet
        return self._guard.advance(commanded, min(now - stamp, waited), now - self._stepped_at)

    def _publish(self, fault: ArmFault) -> ArmReading:
        arm, following = self._arm, self._active and self._guard.following
        code = float(fault or self._fault)
        device = np.array([code, self._read_at, float(not following)])
        return ArmReading(np.concatenate([arm.position, arm.velocity]), arm.force, device)
