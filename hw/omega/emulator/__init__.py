"""A stand-in for the vendor's haptic library, built from C when a test needs it."""

from mmt_drake.hw.omega.emulator.build import build_library, load_emulated
from mmt_drake.hw.omega.emulator.emulated import EmulatedOmega

__all__ = ["EmulatedOmega", "build_library", "load_emulated"]
