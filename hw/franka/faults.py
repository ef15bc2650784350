"""Fault codes of the driver, and what they mean."""

from mmt_drake.hw.errors import FaultCode


class ArmFault(FaultCode):
    """Why an arm does not follow its set-points."""

    NONE = 0, "well"
    #: Nobody has asked for control yet, or since the latest stop.
    NOT_IN_CONTROL = 1, "not in control: ask for it"
    CONNECTION = 2, "no readings: connection lost"
    #: Collision, limits, discontinuity ...
    REFLEX = 3, "stopped by a reflex or an error of the robot"
    #: By the emergency stop, or the enabling switch.
    USER_STOPPED = 4, "stopped by a person at the robot"
    REFUSED = 5, "the robot refuses to move, or to recover"
    ENDED = 6, "the motion ended: force limit of the control loop"
    BAD_READING = 7, "a reading is not a number"
    FORCE = 8, "too much force at the tip"
    SPEED = 9, "the tip moves too fast"
    #: For a while: the arm held its place, and stopped.
    SETPOINTS_LOST = 10, "no set-points"
    BAD_SETPOINT = 11, "a set-point is not a number"
    JUMP = 12, "a set-point far from the latest one"
    #: Faster than the tip may.
    FAST_SETPOINT = 13, "a set-point moves too fast"
    WORKSPACE = 14, "a set-point outside the workspace"
    #: Of this side.
    EMERGENCY_STOP = 15, "emergency stop"


def describe_fault(code: float) -> str:
    """A fault code in words."""
    return ArmFault(int(code)).words
