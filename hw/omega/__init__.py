"""Force Dimension haptic devices (Omega, Delta, Sigma, Lambda): driver, Drake system, emulator."""

from mmt_drake.hw.errors import DeviceError
from mmt_drake.hw.omega.device import OmegaDevice
from mmt_drake.hw.omega.faults import HandFault, describe_fault
from mmt_drake.hw.omega.operator import OmegaOperator
from mmt_drake.hw.omega.settings import OmegaSettings

__all__ = ["DeviceError", "HandFault", "OmegaDevice", "OmegaOperator", "OmegaSettings", "describe_fault"]
