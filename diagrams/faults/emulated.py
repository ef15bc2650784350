"""The emulated haptic device that all trials of this process share."""

from __future__ import annotations

from pathlib import Path

from mmt_drake.hw.omega.emulator import EmulatedOmega, load_emulated

_LOADED: list[EmulatedOmega] = []


def emulated_omega(folder: Path) -> EmulatedOmega:
    """The first emulated device, as it left the factory; the bindings of a process load one library, once.

    Args:
        folder: where to build the library, if this process has none yet.

    Raises:
        MissingDependency: the bindings or a C compiler are not installed.
    """
    if not _LOADED:
        _LOADED.append(EmulatedOmega(load_emulated(folder)))
    _LOADED[0].reset()
    return _LOADED[0]
