"""Safety between a computed force and any device: limits, faults, a ramp to zero, and a person who re-arms."""

from mmt_drake.hw.safety.ages import CameraAge, DeviceAge, HandAge
from mmt_drake.hw.safety.announcer import DeviceAnnouncer, SafetyAnnouncer
from mmt_drake.hw.safety.limits import STOP_WITHIN, SafetyLimits
from mmt_drake.hw.safety.operator_switch import OperatorSwitch
from mmt_drake.hw.safety.reasons import Reason, describe
from mmt_drake.hw.safety.supervised import supervised
from mmt_drake.hw.safety.supervisor import SafetySupervisor
from mmt_drake.hw.safety.while_well import WhileWell

__all__ = [
    "STOP_WITHIN",
    "CameraAge",
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
