"""Force Dimension haptic devices (Omega, Delta, Sigma, Lambda): driver, Drake system, emulator."""

from hw.errors import DeviceError
from hw.omega.device import OmegaDevice
from hw.omega.driver import OmegaDriver
from hw.omega.faults import Fault, describe_fault
from hw.omega.operator import OmegaOperator
from hw.omega.settings import OmegaSettings

__all__ = ["DeviceError", "Fault", "OmegaDevice", "OmegaDriver", "OmegaOperator", "OmegaSettings", "describe_fault"]
