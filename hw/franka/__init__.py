"""Franka arms: driver, Drake system, emulator."""

from hw.errors import DeviceError
from hw.franka.arm import FrankaArm
from hw.franka.driver import FrankaDriver
from hw.franka.faults import Fault, describe_fault
from hw.franka.settings import FrankaSettings
from hw.franka.telerobot import FrankaTelerobot

__all__ = ["DeviceError", "Fault", "FrankaArm", "FrankaDriver", "FrankaSettings", "FrankaTelerobot", "describe_fault"]
