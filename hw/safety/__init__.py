"""What stands between a computed force and any device: limits, faults, a ramp to zero, and a person who re-arms."""

from hw.safety.ages import DeviceAge, HandAge
from hw.safety.announcer import DeviceAnnouncer, SafetyAnnouncer
from hw.safety.limits import STOP_WITHIN, SafetyLimits
from hw.safety.operator_switch import OperatorSwitch
from hw.safety.reasons import Reason, describe
from hw.safety.supervised import supervised
from hw.safety.supervisor import SafetySupervisor
from hw.safety.while_well import WhileWell

__all__ = [
    "STOP_WITHIN",
    "DeviceAge",
    "DeviceAnnouncer",
    "HandAge",
    "OperatorSwitch",
    "Reason",
    "SafetyAnnouncer",
    "SafetyLimits",
    "SafetySupervisor",
    "WhileWell",
    "describe",
    "supervised",
]
