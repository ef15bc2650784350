"""What stands between a computed force and any device: limits, faults, a ramp to zero, and a person who re-arms."""

from hw.safety.announcer import SafetyAnnouncer
from hw.safety.limits import STOP_WITHIN, SafetyLimits
from hw.safety.operator_switch import OperatorSwitch
from hw.safety.reasons import Reason, describe
from hw.safety.supervised import supervised
from hw.safety.supervisor import SafetySupervisor

__all__ = [
    "STOP_WITHIN",
    "OperatorSwitch",
    "Reason",
    "SafetyAnnouncer",
    "SafetyLimits",
    "SafetySupervisor",
    "describe",
    "supervised",
]
