"""Fault codes of the driver, and what they mean."""

from enum import IntEnum


class ArmFault(IntEnum):
    """Why an arm does not follow its set-points."""

    NONE = 0
    #: Nobody has asked for control yet, or since the latest stop.
    NOT_IN_CONTROL = 1
    #: No new reading, or the connection is gone.
    CONNECTION = 2
    #: A reflex of the robot (collision, limits, discontinuity ...), or another error that it reports.
    REFLEX = 3
    #: The emergency stop, or the enabling switch.
    USER_STOPPED = 4
    #: The robot refuses a motion, or its recovery.
    REFUSED = 5
    #: The motion ended by itself; the force limit of the control loop does that.
    ENDED = 6
    #: A reading that is not a number.
    BAD_READING = 7
    #: The tip met more force than it may.
    FORCE = 8
    #: The tip moves faster than it may.
    SPEED = 9
    #: No set-points for a while: the arm held its place, and stopped.
    SETPOINTS_LOST = 10
    #: A set-point that is not a number.
    BAD_SETPOINT = 11
    #: A set-point far from the latest one.
    JUMP = 12
    #: A set-point that moves faster than the tip may.
    FAST_SETPOINT = 13
    #: A set-point outside the workspace.
    WORKSPACE = 14
    #: The emergency stop of this side.
    EMERGENCY_STOP = 15


_TOLD = {
    ArmFault.NONE: "well",
    ArmFault.NOT_IN_CONTROL: "not in control: ask for it",
    ArmFault.CONNECTION: "no readings: connection lost",
    ArmFault.REFLEX: "stopped by a reflex or an error of the robot",
    ArmFault.USER_STOPPED: "stopped by a person at the robot",
    ArmFault.REFUSED: "the robot refuses to move, or to recover",
    ArmFault.ENDED: "the motion ended: force limit of the control loop",
    ArmFault.BAD_READING: "a reading is not a number",
    ArmFault.FORCE: "too much force at the tip",
    ArmFault.SPEED: "the tip moves too fast",
    ArmFault.SETPOINTS_LOST: "no set-points",
    ArmFault.BAD_SETPOINT: "a set-point is not a number",
    ArmFault.JUMP: "a set-point far from the latest one",
    ArmFault.FAST_SETPOINT: "a set-point moves too fast",
    ArmFault.WORKSPACE: "a set-point outside the workspace",
    ArmFault.EMERGENCY_STOP: "emergency stop",
}


def describe_fault(code: float) -> str:
    """A fault code in words."""
    return _TOLD[ArmFault(int(code))]
