"""Fault codes of the driver, and what they mean."""

from mmt_drake.hw.errors import FaultCode


class HandFault(FaultCode):
    """Faults that the vendor's library does not report by itself; codes below 100 are its own error numbers."""

    NONE = 0, "well"
    BAD_READING = 100, "position or velocity is not a number"
    BAD_FORCE = 101, "the force handed in is not a number"
    #: The device makes no force; from here on the vendor's cause is added.
    FORCES_OFF = 110


_VENDORS = {
    1: "error",
    2: "no communication with the device",
    3: "the controller is busy",
    4: "a driver is missing",
    5: "no device found",
    6: "not available on this device",
    7: "timeout",
    8: "geometry: position impossible",
    9: "expert mode is off",
    10: "not implemented",
    11: "out of memory",
    12: "device not ready",
    13: "file not found",
    14: "bad configuration of the device",
    15: "no device of that index",
    18: "redundant encoders disagree",
    19: "feature not enabled",
    20: "device in use by another program",
    21: "invalid argument",
}
_CAUSES = ("no cause given", "force button", "too fast", "watchdog", "turned off", "unplugged", "no hand on the handle")


def describe_fault(code: float) -> str:
    """A fault code in words."""
    number = int(code)
    if HandFault.FORCES_OFF <= number < HandFault.FORCES_OFF + len(_CAUSES):
        return f"forces are off: {_CAUSES[number - HandFault.FORCES_OFF]}"
    words = {int(fault): fault.words for fault in HandFault} | _VENDORS
    return words.get(number, f"error {number}")
