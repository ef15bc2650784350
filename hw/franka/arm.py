"""The arm itself: connected, set up, read, commanded, stopped."""

import contextlib
import ctypes
import os
import threading
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from mmt_drake.closing import Closing
from mmt_drake.errors import one_line
from mmt_drake.hw.errors import DeviceError
from mmt_drake.hw.franka.faults import ArmFault
from mmt_drake.hw.franka.sdk import load_franky
from mmt_drake.hw.franka.settings import FrankaSettings
from mmt_drake.numeric.arrays import Array

_READINGS = 100  # from a recovery to its being seen


def _scheduling() -> tuple[int, os.sched_param]:
    """Of this thread, and of those that it begins."""
    return os.sched_getscheduler(0), os.sched_getparam(0)


@contextlib.contextmanager
def _scheduled_as_before() -> Iterator[None]:
    before = _scheduling()
    try:
        yield
    finally:
        os.sched_setscheduler(0, *before)


class FrankaArm(Closing):
    """One arm, in the table frame.

    The 1 kHz control loop is the library's, in its own thread, compiled: an impedance controller that follows the
    latest set-point, and stops by itself above `FrankaSettings.force`, whatever Python does. It has the highest
    real-time priority that the system permits, and it alone. No call but `connect`, `prepare` and `close` waits for the
    robot; `read` does while no motion runs, for one packet.

    Args:
        settings: which arm, and how it is set up.

    Attributes:
        position, velocity: of the tip (3) [m], [m/s]; the velocity is J dq: the robot measures no other.
        force: on the tip (3) as the robot estimates it, offset and all [N].
        time: of the reading by the robot's clock [s].

    Raises:
        MissingDependency: there is no such library.
        DeviceError: there is no such arm, or it refuses a setting.
    """

    def __init__(self, settings: FrankaSettings) -> None:
        self._franky: Any = load_franky()
        self._settings = settings
        self._to_base, self._table = settings.rotation_matrix(), np.array(settings.table)
        self.position, self.velocity, self.force = np.zeros(3), np.zeros(3), np.zeros(3)
        self.time = 0.0
        mode = self._franky.RobotMode
        self._faults = {mode.Reflex: ArmFault.REFLEX, mode.UserStopped: ArmFault.USER_STOPPED}
        self._orientation: Any = None
        self._motion: Any = None
        self._robot: Any = None
        self.connect()

    def connect(self) -> None:
        """Connect, anew if there was a connection, and set up.

        Raises:
            DeviceError: as the class.
        """
        franky, settings = self._franky, self._settings
        self._robot = None
        realtime = franky.RealtimeConfig.Enforce if settings.realtime == "enforce" else franky.RealtimeConfig.Ignore
        thresholds = settings.collision_torque, settings.collision_force
        try:
            with _scheduled_as_before():
                # The library raises the priority of whoever connects, for the control loop to inherit; kept, it would
                # starve all else.
                robot = franky.Robot(settings.address, 1.0, *thresholds, realtime_config=realtime)
                self._raised = _scheduling()
            tip = np.eye(4)
            tip[:3, 3] = settings.tip
            robot.set_ee(tip.ravel(order="F").tolist())
            robot.set_load(settings.load_mass, list(settings.load_centre), [0.0] * 9)
            robot.set_collision_behavior(*thresholds)
        except Exception as error:
            raise DeviceError(
                f"franka: cannot reach the robot at {settings.address}: {one_line(error)}{_ADVICE}"
            ) from None
        self._robot = robot

    @property
    def in_control(self) -> bool:
        """Whether a motion runs."""
        return self._robot is not None and bool(self._robot.is_in_control)

    def read(self) -> ArmFault:
        """Bring the attributes up to date; with a fault, of the connection or a number, they stay as they were."""
        try:
            state = self._robot.state
            jacobian = self._robot.model.zero_jacobian(self._franky.Frame.EndEffector, state)
            velocity = (jacobian[:3] @ state.dq) @ self._to_base
            position = (state.O_T_EE.translation - self._table) @ self._to_base
            force = -state.O_F_ext_hat_K[:3] @ self._to_base  # the robot's sign: of the force that it exerts
            mode, now = state.robot_mode, state.time.to_sec()
        except Exception:  # the library's exceptions share no base
            if not self.in_control:
                self._robot = None  # `prepare` connects anew
            return ArmFault.CONNECTION
        if not np.isfinite(np.concatenate([position, velocity, force])).all():
            return ArmFault.BAD_READING
        self.position, self.velocity, self.force, self.time = position, velocity, force, now
        return self._faults.get(mode, ArmFault.NONE)

    def prepare(self) -> ArmFault:
        """Be ready to `start`: connected anew if need be, the motion before ended, errors recovered from; waits.

        Returns:
            Why the arm is not ready, or `ArmFault.NONE`.
        """
        try:
            if self._robot is None:
                self.connect()
            if not self._ended():
                return ArmFault.REFUSED
            if self._robot.has_errors and not self._robot.recover_from_errors():
                return self.read() or ArmFault.REFUSED
            return self._settled()
        except DeviceError:
            return ArmFault.CONNECTION
        except Exception:
            return self.read() or ArmFault.REFUSED

    def start(self) -> ArmFault:
        """Take control and hold the present place.

        Returns:
            Why there is no control, or `ArmFault.NONE`.
        """
        try:
            motion = self._tracking(self._robot.state)
            with _scheduled_as_before():
                os.sched_setscheduler(0, *self._raised)  # the control loop begins as a thread of this one
                self._robot.move(motion, asynchronous=True)
        except Exception:
            return self.read() or ArmFault.REFUSED
        return ArmFault.NONE

    def _ended(self) -> bool:
        """Whether the motion before, which may still be stopping, ends in time; what ended it is reported already."""
        try:
            return bool(self._robot.join_motion(timeout=2.0 * self._settings.stop_within))
        except Exception:
            return True

    def _settled(self) -> ArmFault:
        """Read until the robot says that all is well; the fault if it does not."""
        fault = self.read()
        for _ in range(_READINGS):
            if not fault or fault is ArmFault.CONNECTION:
                break
            fault = self.read()
        return fault

    def _tracking(self, state: Any) -> Any:
        """The impedance controller, at rest where the tip is."""
        franky, settings, measure = self._franky, self._settings, self._franky.Measure
        yields = settings.impedance
        motion = franky.CartesianImpedanceTrackingMotion(
            posture_task=franky.PostureTask(state.q, yields.posture_stiffness, yields.posture_damping),
            translational_error_clip=np.full(3, settings.pull / yields.stiffness),
        )
        stiffness, damping = (
            (yields.stiffness, yields.rotational_stiffness),
            (yields.damping, yields.rotational_damping),
        )
        motion.set_gains(franky.CartesianImpedanceGains.isotropic(*stiffness, *damping))
        motion.set_reference(franky.CartesianReference(target=state.O_T_EE))
        squared = measure.FORCE_X**2 + measure.FORCE_Y**2 + measure.FORCE_Z**2
        motion.add_reaction(franky.TorqueReaction(squared > settings.force**2, self._stop_motion()))
        self._orientation, self._motion = state.O_T_EE.quaternion, motion
        return motion

    def follow(self, position: Array, velocity: Array) -> None:
        """Have the tip pulled to a position (3) [m] that moves at a velocity (3) [m/s], until commanded otherwise."""
        franky = self._franky
        target = franky.Affine(self._to_base @ position + self._table, self._orientation)
        twist = franky.Twist(self._to_base @ velocity, np.zeros(3))
        self._motion.set_reference(franky.CartesianReference(target=target, target_twist=twist))

    def stop(self) -> None:
        """Take the torques back and come to rest, within `FrankaSettings.stop_within`; returns at once."""
        with contextlib.suppress(Exception):  # no connection: the robot stops by itself
            if self.in_control:
                self._robot.move(self._stop_motion(), asynchronous=True)

    def close(self) -> None:
        """Come to rest and disconnect; may be called again."""
        self.stop()
        if not self._ended():
            # The library asks the robot as well, and may wait for an answer without end.
            threading.Thread(target=_attempt, args=(self._robot.stop,), name="stop", daemon=True).start()
            if not self._ended():
                # A robot that never says that its motion is over: the library would wait for it here without end.
                ctypes.pythonapi.Py_IncRef(ctypes.py_object(self._robot))
        self._robot = None

    def _stop_motion(self) -> Any:
        settings = self._settings
        return self._franky.TorqueStopMotion(ramp_duration=settings.stop_ramp, max_duration=settings.stop_within)


_ADVICE = "; is it switched on, unlocked, in FCI mode, and is no other program connected?"


def _attempt(call: Callable[[], object]) -> None:
    with contextlib.suppress(Exception):
        call()
