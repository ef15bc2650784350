"""Franka arms: driver, Drake system, emulator."""

from mmt_drake.hw.errors import DeviceError
from mmt_drake.hw.franka.arm import FrankaArm
from mmt_drake.hw.franka.driver import FrankaDriver
from mmt_drake.hw.franka.faults import ArmFault, describe_fault
from mmt_drake.hw.franka.settings import FrankaSettings
from mmt_drake.hw.franka.telerobot import FrankaTelerobot

__all__ = [
    "ArmFault",
    "DeviceError",
    "FrankaArm",
    "FrankaDriver",
    "FrankaSettings",
    "FrankaTelerobot",
    "describe_fault",
]
