"""The far side of an emulated device: its hand, its faults, what it feels."""

import ctypes
from pathlib import Path

import numpy as np

from mmt_drake.numeric.arrays import Array

#: The members of `struct emulated` in handle.c, all double, flags 0 or 1.
FIELDS = (
    *("x", "y", "z", "vx", "vy", "vz"),  # the handle [m, m/s], device frame
    *("applied_x", "applied_y", "applied_z"),  # what the motors do [N]
    *("target_x", "target_y", "target_z"),  # where the hand wants to be [m] ...
    *("swing_x", "swing_y", "swing_z", "swing_hz"),  # ... and three sines on top of it [m, Hz]
    *("sway_x", "sway_y", "sway_z", "sway_hz"),
    *("tremor_x", "tremor_y", "tremor_z", "tremor_hz"),
    "soft_start",  # [s] in which the hand takes up all of that
    *("mass", "damping", "brake", "reach", "strongest", "resolution"),  # kg, N s/m, N s/m, m, N, m
    *("hand_mass", "hand_damping", "hand_stiffness"),  # kg, N s/m, N/m
    *("type", "serial", "powered", "connected", "calibrated", "no_watchdog"),
    *("button", "force_button"),  # 1 while pressed
    *("gap", "gap_rate", "squeeze"),  # the trigger: opening [m, m/s], by what the fingers close it [N]
    *("applied_grip", "greatest_grip", "nan_gap"),  # what its motor does, opening it [N]; 1: what is read is no number
    *("stuck", "nan_position", "nan_velocity", "jump"),  # what is read is wrong; jump: by so much in x [m]
    *("failing", "error", "slow"),  # the next so many calls fail with this error; each takes so long [s]
    *("read_x", "read_y", "read_z"),  # what was read last
    *("real_time", "epoch", "clock", "simulated"),  # whether time is the wall's; else `clock` is [s]
    *("watchdog", "force_off_cause", "greatest_force", "last_force_at", "not_finite", "calls", "sets"),
    *("asked_at", "answered_after"),  # wall time of the latest reading, and from there to the latest force [s]
)


class _Emulated(ctypes.Structure):
    _fields_ = tuple((name, ctypes.c_double) for name in FIELDS)


class EmulatedOmega:
    """One of the two devices of a library that `build_library` made.

    Its members (`FIELDS`) are read and written through `get` and `set`. Time stands still but for `advance`, unless
    `real_time` is set to 1.

    Args:
        library: path of the library; it must be the one that the bindings have loaded, or will load.
        index: 0 or 1.
    """

    def __init__(self, library: Path, index: int = 0) -> None:
        self._library, self._index = ctypes.CDLL(str(library)), index
        self._memory = (_Emulated * 2).in_dll(self._library, "emulated")[index]
        self.reset()

    def reset(self) -> None:
        """Closed, whole, at rest in the middle, at time 0."""
        self._library.emulated_reset(self._index)

    def get(self, name: str) -> float:
        """A member, as of the latest call."""
        return float(getattr(self._memory, name))

    def vector(self, name: str) -> Array:
        """(3) the members NAME_x, NAME_y, NAME_z, or x, y, z for the empty name."""
        return np.array([self.get(f"{name}_{axis}" if name else axis) for axis in "xyz"])

    def set(self, **values: float) -> None:
        """Change members."""
        for name, value in values.items():
            if name not in FIELDS:
                raise KeyError(name)
            setattr(self._memory, name, value)

    def advance(self, seconds: float) -> None:
        """Let time pass, without a call from the host."""
        self._memory.clock += seconds
        self.update()

    def update(self) -> None:
        """Bring the simulation to the present."""
        self._library.emulated_update(self._index)
